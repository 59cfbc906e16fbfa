//! The layers and metadata of an image file, from a film.
//!
//! With a denoised image, `R`, `G`, `B` hold it, and the layer `noisy` holds the sum of the other layers. All variances belong to the latter.
//!
//! The variance of the mean is infinite, that is unknown, with fewer than two passes. The same holds for the variance of block means with fewer
//! than two batches.

use manylight::film::{Film, Layer};
use manylight::image::Image;
use manylight_io::image::{ImageLayer, LayeredImage};
use manylight_lab::noise::{self, NOISY};

pub(super) const RGB: &[&str] = &["R", "G", "B"];

/// All layers of `film`: the image (`denoised`, if given), its variances, then the other layers.
pub(super) fn from_film(
    film: &Film,
    denoised: Option<&Image>,
    mut metadata: Vec<(String, String)>,
) -> LayeredImage {
    let size = film.image_size();
    let mut layers = Vec::new();
    for &layer in film.layers() {
        let Some(image) = film.image(layer) else {
            continue;
        };
        let name = match (layer, denoised) {
            (Layer::Beauty, Some(denoised)) => {
                layers.push(named("", RGB, denoised));
                NOISY
            }
            _ => layer.name(),
        };
        layers.push(named(name, channels(layer), &image));
        if layer == Layer::Beauty {
            layers.push(named("variance", RGB, &film.variance()));
            let blocks = film.block_variance();
            layers.push(named("block_variance", RGB, &blocks));
        }
    }
    metadata.extend(noise::metadata(film));
    LayeredImage {
        width: size.x as usize,
        height: size.y as usize,
        layers,
        metadata,
    }
}

pub(super) fn channels(layer: Layer) -> &'static [&'static str] {
    match layer {
        Layer::Normal => &["X", "Y", "Z"],
        Layer::Depth => &["Z"],
        Layer::CutSize | Layer::CutBound => &["Y"],
        _ => RGB,
    }
}

/// The name of a channel with that of its layer.
pub(super) fn full_name(layer: &str, channel: &str) -> String {
    match layer {
        "" => channel.to_string(),
        _ => format!("{layer}.{channel}"),
    }
}

pub(super) fn named(name: &str, channels: &[&str], image: &Image) -> ImageLayer {
    let values = |c: usize| {
        image
            .data
            .chunks_exact(image.channels)
            .map(|p| p[c])
            .collect()
    };
    let channels = channels
        .iter()
        .enumerate()
        .map(|(c, channel)| (full_name(name, channel), values(c)));
    ImageLayer {
        name: name.into(),
        channels: channels.collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use manylight::color::Rgb;
    use manylight::film::{FilmDesc, Filter};
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
        let picture = from_film(&film, None, vec![("a".into(), "b".into())]);
        let names: Vec<&str> = picture
            .layers
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
        let at = |layer: usize, c: usize| picture.layers[layer].channels[c].1[row * 11 + column];
        assert_eq!(
            (at(0, 0), at(0, 1), at(3, 2), at(5, 0)),
            (10.0, 7.0, 2.0, 5.0)
        );
        assert!(at(1, 0).is_infinite());
    }
}
