//! The layers and metadata of an image file, from a film.
//!
//! `R`, `G`, `B` are premultiplied by the alpha `A`: light where nothing is, such as that of glass,
//! adds to what is behind. With a denoised image, `R`, `G`, `B` hold it, and the layer `noisy`
//! holds the sum of the other layers. All variances belong to the latter. Light groups sum to
//! `noisy`, their denoised layers to the image.
//!
//! The variance of the mean is infinite, that is unknown, with fewer than two passes. The same
//! holds for the variance of block means with fewer than two batches.

mod derived;
mod facts;
mod layer_names;

pub(crate) use derived::{
    color_layer, derived_image, layers_without_light, metadata_without_noise, picture_layer,
    picture_name, planes, split_last_part,
};
pub(crate) use facts::PictureFacts;

use crate::args::FileArgs;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::names::AovNames;
use crate::stated_error;
use manylight::film::{ErrorBars, Film, IdLayer, Layer};
use manylight::image::Image;
use manylight_denoise::DenoisedImage;
use manylight_io::image::{
    Cryptomatte, ImageFormat, ImageLayer, ImageWindow, LIGHT_GROUP, LayeredImage, full_name,
    write_image,
};
use manylight_lab::noise::{self, BLOCK_ERROR, BLOCK_VARIANCE, ERROR, NOISY, VARIANCE};
use std::cell::LazyCell;
use std::path::PathBuf;

pub(crate) const RGB: &[&str] = &["R", "G", "B"];

/// Start of the name of a light group's layer of variances, before that of its layer.
pub(crate) const GROUP_VARIANCE: &str = "variance_";

/// Start of the name of a light group's layer in the denoised image, before that of its layer.
pub(crate) const DENOISED_GROUP: &str = "denoised_";

/// What a picture is made of.
pub(crate) struct PictureSource<'f> {
    /// The rendered film.
    pub(crate) film: &'f Film,
    /// The image without noise, if there is one.
    pub(crate) denoised: Option<&'f DenoisedImage>,
    /// The error bars of the picture, if they are known.
    pub(crate) bars: Option<&'f ErrorBars>,
    /// Names, camera and metadata.
    pub(crate) facts: &'f PictureFacts,
}

impl PictureSource<'_> {
    /// Writes the picture to files. A file that cannot be written does not prevent the others.
    ///
    /// # Errors
    /// A file cannot be written, or its format is unknown: the first such error.
    pub(crate) fn write(
        &self,
        outputs: &[PathBuf],
        args: &FileArgs,
        interrupt: &Interrupt,
    ) -> Result<(), Failure> {
        let plain = LazyCell::new(|| self.picture(AovNames::Manylight));
        let renamed = LazyCell::new(|| self.picture(args.aov_names));
        let write = |path: &PathBuf| -> Result<(), Failure> {
            // Only EXR files have layers with names.
            let picture = match ImageFormat::from_path(path)? {
                ImageFormat::Exr if args.aov_names != AovNames::Manylight => &*renamed,
                _ => &*plain,
            };
            let _complete_file = interrupt.writing();
            Ok(write_image(path, picture, args.tone.display())?)
        };
        let results: Vec<Result<(), Failure>> = outputs.iter().map(write).collect();
        results.into_iter().collect()
    }

    /// All layers of the film: the image with its alpha, its variances, the other layers, then the
    /// mattes.
    pub(crate) fn picture(&self, naming: AovNames) -> LayeredImage {
        let film = self.film;
        let size = film.image_size();
        let named = NamedFilm {
            film,
            denoised: self.denoised,
            groups: self.facts.light_groups(),
        };
        let mut layers = film_layers(&named, self.bars, naming);
        let mut metadata = self.facts.metadata.clone();
        metadata.extend(noise::metadata(film));
        metadata.extend(
            self.bars
                .iter()
                .flat_map(|bars| stated_error::metadata(&bars.stated)),
        );
        for &layer in film.id_layers() {
            let matte = matte(film, layer, self.facts.names(layer), naming);
            layers.extend(matte.layers);
            metadata.extend(matte.metadata);
        }
        LayeredImage {
            width: size.x as usize,
            height: size.y as usize,
            layers,
            metadata,
            window: window(film),
            camera: Some(self.facts.camera()),
        }
    }
}

/// A film with what its layers are named by.
#[derive(Clone, Copy)]
pub(crate) struct NamedFilm<'f> {
    pub(crate) film: &'f Film,
    pub(crate) denoised: Option<&'f DenoisedImage>,
    /// Names of the light groups.
    pub(crate) groups: &'f [String],
}

impl NamedFilm<'_> {
    /// The name of a layer in image files.
    pub(crate) fn name_of(&self, layer: Layer) -> String {
        match layer {
            Layer::LightGroup(group) => match self.groups.get(group.index()) {
                Some(name) => format!("{LIGHT_GROUP}{name}"),
                None => format!("{LIGHT_GROUP}{}", group.0),
            },
            _ => layer.name().into_owned(),
        }
    }
}

pub(crate) fn film_layers(
    named_film: &NamedFilm,
    bars: Option<&ErrorBars>,
    naming: AovNames,
) -> Vec<ImageLayer> {
    let NamedFilm { film, denoised, .. } = *named_film;
    let mut layers: Vec<ImageLayer> = Vec::new();
    let mut denoised_groups = denoised.iter().flat_map(|denoised| &denoised.groups);
    let mut push = |name: &str, channels: &[&str], image: &Image| {
        layers.push(named(&naming.layer(name), channels, image));
    };
    for &layer in film.layers() {
        let (Some(image), false) = (film.image(layer), layer == Layer::Alpha) else {
            continue;
        };
        let name = match (layer, denoised) {
            (Layer::Beauty, Some(denoised)) => {
                push("", RGB, &denoised.image);
                NOISY.to_owned()
            }
            _ => named_film.name_of(layer),
        };
        push(&name, channels(layer), &image);
        if let Layer::LightGroup(_) = layer {
            if let Some(variance) = film.layer_variance(layer) {
                push(&format!("{GROUP_VARIANCE}{name}"), RGB, &variance);
            }
            if let Some(group) = denoised_groups.next() {
                push(&format!("{DENOISED_GROUP}{name}"), RGB, group);
            }
        }
        if layer == Layer::Beauty {
            push(VARIANCE, RGB, &film.variance());
            push(BLOCK_VARIANCE, RGB, &film.block_variance());
            if let Some(bars) = bars {
                push(ERROR, RGB, &bars.pixels);
                push(BLOCK_ERROR, RGB, &bars.blocks);
            }
        }
    }
    if let Some(alpha) = film.alpha() {
        let alpha = named(&naming.layer(""), &["A"], &alpha);
        layers[0].channels.extend(alpha.channels);
    }
    layers
}

/// A Cryptomatte of the film.
fn matte(film: &Film, layer: IdLayer, names: &[String], naming: AovNames) -> Cryptomatte {
    let typename = match layer {
        IdLayer::Object => "CryptoObject",
        IdLayer::Material => "CryptoMaterial",
    };
    let pixels = film.ranked_ids(layer).unwrap_or_default();
    Cryptomatte::new(&naming.layer(typename), names, &pixels)
}

/// The place of a crop window; `None` if the film has none.
fn window(film: &Film) -> Option<ImageWindow> {
    let desc = film.desc();
    let pixels = |v: manylight::math::UVec2| v.to_array().map(|v| v as usize);
    (desc.crop_size != desc.size).then(|| ImageWindow {
        full_size: pixels(desc.size),
        offset: pixels(desc.crop_offset),
    })
}

pub(crate) fn channels(layer: Layer) -> &'static [&'static str] {
    match layer {
        Layer::Normal | Layer::Position => &["X", "Y", "Z"],
        Layer::Depth => &["Z"],
        Layer::Alpha => &["A"],
        Layer::CutSize | Layer::CutBound => &["Y"],
        _ => RGB,
    }
}

/// Number of channels of a picture with these layers.
pub(crate) fn channel_count(layers: &[Layer], id_layers: &[IdLayer]) -> usize {
    let of_layer = |&layer: &Layer| match layer {
        // With its variance.
        Layer::LightGroup(_) => 2 * RGB.len(),
        _ => channels(layer).len(),
    };
    let of_layers: usize = layers.iter().map(of_layer).sum();
    // The variances and error bars of the image, of its pixels and of its blocks.
    let of_variances = 4 * RGB.len();
    of_layers + of_variances + id_layers.len() * Cryptomatte::CHANNELS
}

pub(crate) fn named(name: &str, channels: &[&str], image: &Image) -> ImageLayer {
    let channels = channels.iter().map(|channel| full_name(name, channel));
    ImageLayer::from_image(name, channels, image)
}

#[cfg(test)]
mod tests {
    use super::*;
    use manylight::color::Rgb;
    use manylight::film::{FilmDesc, Filter, StatedError};
    use manylight::math::UVec2;
    use std::sync::atomic::{AtomicBool, AtomicU64};

    #[test]
    fn layers_have_their_names_and_rows() {
        let size = UVec2::new(11, 9);
        let desc = FilmDesc {
            size,
            crop_offset: UVec2::ZERO,
            crop_size: size,
            filter: Filter::Box,
        };
        let mut film = Film::new(
            desc,
            &[Layer::Beauty, Layer::Direct, Layer::Normal, Layer::Depth],
        );
        film.add_pass(&AtomicBool::new(false), &AtomicU64::new(0), |samples| {
            for (i, pixel) in samples.tile().pixels().enumerate() {
                samples.add(
                    i,
                    Layer::Direct,
                    Rgb::new(pixel.x as f32, pixel.y as f32, 2.0),
                );
                samples.add(i, Layer::Depth, Rgb::splat(5.0));
            }
        });
        let named_film = NamedFilm {
            film: &film,
            denoised: None,
            groups: &[],
        };
        let bars = ErrorBars {
            pixels: Image::new(11, 9, 3),
            blocks: Image::new(11, 9, 3),
            stated: StatedError {
                pixels: 0.0,
                blocks: 0.0,
                at_most: 0.0,
                concentration: 0.0,
            },
        };
        let layers = film_layers(&named_film, Some(&bars), AovNames::Manylight);
        let names: Vec<&str> = layers
            .iter()
            .flat_map(|l| &l.channels)
            .map(|c| c.0.as_str())
            .collect();
        assert_eq!(
            names,
            [
                "R",
                "G",
                "B",
                "variance.R",
                "variance.G",
                "variance.B",
                "block_variance.R",
                "block_variance.G",
                "block_variance.B",
                "error.R",
                "error.G",
                "error.B",
                "block_error.R",
                "block_error.G",
                "block_error.B",
                "direct.R",
                "direct.G",
                "direct.B",
                "normal.X",
                "normal.Y",
                "normal.Z",
                "depth.Z"
            ]
        );
        let (row, column) = (7, 10);
        assert_eq!(channel_count(film.layers(), &[]), names.len());
        let at = |layer: usize, c: usize| layers[layer].channels[c].1[row * 11 + column];
        assert_eq!(
            (at(0, 0), at(0, 1), at(5, 2), at(7, 0)),
            (10.0, 7.0, 2.0, 5.0)
        );
        assert!(at(1, 0).is_infinite());
    }
}
