//! Images made of the values of others.

use manylight::image::Image;

/// An image of the size of another one.
pub(super) fn of_size(image: &Image, channels: usize, data: Vec<f32>) -> Image {
    Image {
        width: image.width,
        height: image.height,
        channels,
        data,
    }
}

/// The `wanted` channels, in this order.
pub(super) fn pick(image: &Image, wanted: &[usize]) -> Image {
    let pixels = image.data.chunks_exact(image.channels);
    let picked = pixels.flat_map(|pixel| wanted.iter().map(|&index| pixel[index]));
    of_size(image, wanted.len(), picked.collect())
}

/// Three channels: the first three, or three times the first one.
pub(super) fn three_channels(image: &Image) -> Image {
    let is_gray = image.channels < 3;
    pick(image, if is_gray { &[0; 3] } else { &[0, 1, 2] })
}

/// The luminance of every pixel under `map`.
pub(super) fn luminance(image: &Image, map: impl Fn(f32) -> f32) -> Image {
    let pixels = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
    let luminance = pixels.map(|(x, y)| map(image.rgb(x, y).luminance()));
    of_size(image, 1, luminance.collect())
}
