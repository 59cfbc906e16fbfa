//! Textures.

use super::numbers::Numbers;
use manylight::ids::TextureId;
use manylight::image::Image;
use manylight::texture::{
    Bitmap, ColorInput, Filtering, FloatInput, Pattern, Solid, Texture, Wrap,
};

pub(super) fn textures(numbers: &mut Numbers) -> Vec<Texture> {
    (0..numbers.below(5)).map(|i| texture(numbers, i)).collect()
}

/// An image of `channels` channels, and of a few pixels.
pub(super) fn image(numbers: &mut Numbers, channels: usize) -> Image {
    let (width, height) = (1 + numbers.below(4), 1 + numbers.below(4));
    Image {
        width,
        height,
        channels,
        data: (0..width * height * channels)
            .map(|_| numbers.unit())
            .collect(),
    }
}

/// A constant, or one of `textures` textures.
pub(super) fn color_input(numbers: &mut Numbers, textures: usize, high: f32) -> ColorInput {
    if textures > 0 && numbers.rarely(3) {
        ColorInput::Texture(TextureId::from(numbers.index(textures)))
    } else {
        ColorInput::Constant(numbers.color(high))
    }
}

/// A constant in [0, `high`], or one of `textures` textures.
pub(super) fn float_input(numbers: &mut Numbers, textures: usize, high: f32) -> FloatInput {
    if textures > 0 && numbers.rarely(3) {
        FloatInput::Texture(TextureId::from(numbers.index(textures)))
    } else {
        FloatInput::Constant(numbers.float(0.0, high))
    }
}

/// The texture of index `i`, which may contain those before it.
fn texture(numbers: &mut Numbers, i: usize) -> Texture {
    match numbers.below(11) {
        0..=2 => bitmap(numbers),
        3 => Texture::Checkerboard {
            color0: color_input(numbers, i, 1.0),
            color1: color_input(numbers, i, 1.0),
            uv_transform: numbers.mat3(),
        },
        4 => Texture::Product {
            first: color_input(numbers, i, 1.0),
            second: color_input(numbers, i, 1.0),
        },
        5 => Texture::Mix {
            first: color_input(numbers, i, 1.0),
            second: color_input(numbers, i, 1.0),
            weight: float_input(numbers, i, 1.0),
        },
        6 => Texture::Dots {
            inside: color_input(numbers, i, 1.0),
            outside: color_input(numbers, i, 1.0),
            uv_transform: numbers.mat3(),
        },
        7 if i > 0 => Texture::Power {
            base: TextureId::from(numbers.index(i)),
            exponent: numbers.float(-1.0, 3.0),
        },
        9 if i > 0 => Texture::Transformed {
            uv_transform: numbers.mat3(),
            inner: TextureId::from(numbers.index(i)),
        },
        8 if i > 0 => Texture::Step {
            base: TextureId::from(numbers.index(i)),
            threshold: numbers.float(-1.0, 3.0),
        },
        _ => Texture::Solid(Solid {
            pattern_from_world: numbers.affine(),
            pattern: pattern(numbers, i),
        }),
    }
}

fn bitmap(numbers: &mut Numbers) -> Texture {
    let wraps = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];
    let channels = numbers.choose(&[1, 3]);
    Texture::Bitmap(Bitmap {
        image: image(numbers, channels),
        filtering: numbers.choose(&[Filtering::Nearest, Filtering::Bilinear]),
        wrap: [numbers.choose(&wraps), numbers.choose(&wraps)],
        uv_transform: numbers.mat3(),
    })
}

fn pattern(numbers: &mut Numbers, textures: usize) -> Pattern {
    let octaves = numbers.below(12) as u32;
    let roughness = numbers.unit();
    match numbers.below(5) {
        0 => Pattern::Fractal { octaves, roughness },
        1 => Pattern::Wrinkled { octaves, roughness },
        2 => Pattern::Windy,
        3 => Pattern::Marble {
            octaves,
            roughness,
            variation: numbers.unit(),
        },
        _ => Pattern::Cells {
            color0: color_input(numbers, textures, 1.0),
            color1: color_input(numbers, textures, 1.0),
        },
    }
}
