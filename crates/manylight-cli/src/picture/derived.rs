//! Pictures that are made of the layers of another picture, without a render.

use super::{DENOISED_GROUP, GROUP_VARIANCE, RGB};
use manylight::film::Layer;
use manylight_io::image::{
    ImageLayer, LayeredImage, full_name, is_combined, last_part, light_group,
};
use manylight_lab::noise::{BLOCK_ERROR, BLOCK_VARIANCE, ERROR, NOISY, VARIANCE};

/// The picture with these layers and metadata, with the size, place and camera of `image`.
pub(crate) fn derived_image(
    image: &LayeredImage,
    layers: Vec<ImageLayer>,
    metadata: Vec<(String, String)>,
) -> LayeredImage {
    LayeredImage {
        width: image.width,
        height: image.height,
        layers,
        metadata,
        window: image.window,
        camera: image.camera,
    }
}

/// A layer with these planes of red, green and blue.
pub(crate) fn color_layer(name: &str, planes: Vec<Vec<f32>>) -> ImageLayer {
    let names = RGB.iter().map(|channel| full_name(name, channel));
    ImageLayer {
        name: name.to_owned(),
        channels: names.zip(planes).collect(),
    }
}

/// The layer of the picture with other planes of red, green and blue. It keeps its alpha.
pub(crate) fn picture_layer(image: &LayeredImage, planes: Vec<Vec<f32>>) -> ImageLayer {
    let name = picture_name(image);
    let mut layer = color_layer(name, planes);
    let alpha = full_name(name, "A");
    if let Some(values) = image.channel(&alpha) {
        layer.channels.push((alpha, values.to_vec()));
    }
    layer
}

/// The planes of red, green and blue of a layer.
pub(crate) fn planes<'i>(image: &'i LayeredImage, layer: &str) -> Option<[&'i [f32]; 3]> {
    let [r, g, b] = [0, 1, 2].map(|c| image.channel(&full_name(layer, RGB[c])));
    Some([r?, g?, b?])
}

/// The name of the layer with the picture.
pub(crate) fn picture_name(image: &LayeredImage) -> &str {
    let mut names = image.layers.iter().map(|layer| layer.name.as_str());
    names.find(|name| is_combined(name)).unwrap_or("")
}

/// The last part of the name of a layer, and what stands before it.
pub(crate) fn split_last_part(layer: &str) -> (&str, &str) {
    match layer.rfind('.') {
        Some(dot) => (&layer[dot + 1..], &layer[..=dot]),
        None => (layer, ""),
    }
}

/// The layers that are the same whatever the light: all but the picture, its terms, its variances
/// and error bars, and its light groups.
pub(crate) fn layers_without_light(image: &LayeredImage) -> impl Iterator<Item = ImageLayer> {
    let layers = image.layers.iter();
    layers
        .filter(|layer| !depends_on_light(&layer.name))
        .cloned()
}

fn depends_on_light(name: &str) -> bool {
    let last = last_part(name);
    let of_picture = [
        "",
        "Combined",
        NOISY,
        VARIANCE,
        BLOCK_VARIANCE,
        ERROR,
        BLOCK_ERROR,
    ];
    let is_named = |layer: &Layer| {
        let depends = layer.is_term() || matches!(layer, Layer::CutSize | Layer::CutBound);
        depends && layer.name() == last
    };
    of_picture.contains(&last)
        || light_group(name).is_some()
        || last.starts_with(GROUP_VARIANCE)
        || last.starts_with(DENOISED_GROUP)
        || Layer::ALL.iter().any(is_named)
}

/// The metadata of a picture, without what they say about its noise.
pub(crate) fn metadata_without_noise(image: &LayeredImage) -> Vec<(String, String)> {
    let is_noise = |name: &str| {
        name == "batches"
            || name == "error"
            || name.starts_with("error.")
            || name.starts_with("variance_of_mean")
    };
    let metadata = image.metadata.iter();
    metadata
        .filter(|(name, _)| !is_noise(name))
        .cloned()
        .collect()
}
