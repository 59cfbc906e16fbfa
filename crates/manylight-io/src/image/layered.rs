//! Images with named channels in layers, metadata, and their place on the film and in the world.

use manylight::image::Image;

/// A group of channels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImageLayer {
    /// Empty for the beauty layer, else the part of the channel names before the last dot.
    pub name: String,
    /// Full name, such as `R`, `variance.R` or `depth.Z`, and `width * height` values in rows from
    /// top to bottom.
    pub channels: Vec<(String, Vec<f32>)>,
}

impl ImageLayer {
    /// The channels of an image. `channels` are their full names; channels of the image without a
    /// name are left out.
    pub fn from_image(
        name: impl Into<String>,
        channels: impl IntoIterator<Item = String>,
        image: &Image,
    ) -> Self {
        let plane = |c: usize| {
            let values = image.data.iter().skip(c).step_by(image.channels);
            values.copied().collect()
        };
        let channels = channels.into_iter().enumerate();
        ImageLayer {
            name: name.into(),
            channels: channels.map(|(c, name)| (name, plane(c))).collect(),
        }
    }
}

/// The part of a full picture that an image shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageWindow {
    /// Width and height of the full picture in pixels.
    pub full_size: [usize; 2],
    /// Column and row of the upper left pixel of the image in the full picture.
    pub offset: [usize; 2],
}

/// The camera of an image, by the definitions of OpenEXR's standard attributes. Matrices are in
/// column-major order for column vectors, which is OpenEXR's row-major order for row vectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageCamera {
    /// From world space to camera space, in the world's unit: x to the right, y up, z in the
    /// direction of view.
    pub camera_from_world: [f32; 16],
    /// From world space to the full picture: (0, 0) is its upper left corner, (1, 1) its lower
    /// right. Homogeneous; z has no meaning.
    pub ndc_from_world: [f32; 16],
    /// Center of the full picture on the plane z = 1 of camera space; 0 for cameras with parallel
    /// rays.
    pub screen_center: [f32; 2],
    /// Width of the full picture on that plane; 1 for cameras with parallel rays.
    pub screen_width: f32,
}

/// A rendered image: named channels of equal size, and metadata.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LayeredImage {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Layers. All channel names differ.
    pub layers: Vec<ImageLayer>,
    /// Pairs of name and value. OpenEXR files store them, PNG files those for readers of pictures.
    pub metadata: Vec<(String, String)>,
    /// The part of a larger picture that the image shows; `None`: all of it. Only OpenEXR files
    /// store it.
    pub window: Option<ImageWindow>,
    /// The camera. Only OpenEXR files store it.
    pub camera: Option<ImageCamera>,
}

impl LayeredImage {
    /// The values of the channel with this full name.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.layers
            .iter()
            .flat_map(|l| &l.channels)
            .find(|(n, _)| n == name)
            .map(|(_, values)| values.as_slice())
    }

    /// The value of a metadata entry.
    pub fn metadata_value(&self, name: &str) -> Option<&str> {
        self.metadata
            .iter()
            .find(|(n, _)| n == name)
            .map(|(_, value)| value.as_str())
    }

    /// The beauty layer: the channels `R`, `G` and `B`, or `Y`.
    pub(super) fn beauty(&self) -> Option<Image> {
        let names: &[&str] = if self.channel("R").is_some() {
            &["R", "G", "B"]
        } else {
            &["Y"]
        };
        let planes: Option<Vec<&[f32]>> = names.iter().map(|name| self.channel(name)).collect();
        Some(interleave(self.width, self.height, &planes?))
    }

    /// The image as its beauty layer: the channels `R`, `G` and `B` if it has three channels, else
    /// its first channel as `Y`.
    pub fn from_image(image: &Image) -> LayeredImage {
        let names: &[&str] = if image.channels == 3 {
            &["R", "G", "B"]
        } else {
            &["Y"]
        };
        let names = names.iter().map(|&name| name.to_owned());
        LayeredImage {
            width: image.width,
            height: image.height,
            layers: vec![ImageLayer::from_image("", names, image)],
            ..LayeredImage::default()
        }
    }

    /// Groups channels into layers by the part of their names before the last dot. Layers are in
    /// the order of their first channels.
    pub fn from_channels(
        width: usize,
        height: usize,
        channels: Vec<(String, Vec<f32>)>,
    ) -> LayeredImage {
        let mut layers: Vec<ImageLayer> = Vec::new();
        for (name, values) in channels {
            let layer_name = name.rsplit_once('.').map_or("", |(layer, _)| layer);
            let index = layers
                .iter()
                .position(|l| l.name == layer_name)
                .unwrap_or_else(|| {
                    layers.push(ImageLayer {
                        name: layer_name.to_owned(),
                        channels: Vec::new(),
                    });
                    layers.len() - 1
                });
            layers[index].channels.push((name, values));
        }
        LayeredImage {
            width,
            height,
            layers,
            ..LayeredImage::default()
        }
    }
}

/// Whether a layer has the image, by its name: that of Blender's pass, in any layer of its scene.
pub fn is_combined(layer: &str) -> bool {
    last_part(layer) == "Combined"
}

/// Start of the name of a light group's layer: that of Blender's light groups, which compositors
/// know.
pub const LIGHT_GROUP: &str = "Combined_";

/// The name of the light group that a layer has, by the last part of the layer's name.
pub fn light_group(layer: &str) -> Option<&str> {
    last_part(layer).strip_prefix(LIGHT_GROUP)
}

/// The name of a channel with that of its layer.
pub fn full_name(layer: &str, channel: &str) -> String {
    match layer {
        "" => channel.to_owned(),
        _ => format!("{layer}.{channel}"),
    }
}

/// The last part of the name of a layer or channel: `R` of `ViewLayer.Combined.R`.
pub fn last_part(name: &str) -> &str {
    name.rfind('.').map_or(name, |dot| &name[dot + 1..])
}

/// One image from `planes`, each of `width * height` values.
pub fn interleave(width: usize, height: usize, planes: &[&[f32]]) -> Image {
    let data = (0..width * height)
        .flat_map(|i| planes.iter().map(move |plane| plane[i]))
        .collect();
    Image {
        width,
        height,
        channels: planes.len(),
        data,
    }
}
