//! From stored to linear values and back.

use manylight::image::Image;

/// How the values of an image file become linear ones.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Transfer {
    /// The sRGB curve for 8 and 16 bit integers; float values are linear already.
    #[default]
    Auto,
    /// The sRGB curve.
    Srgb,
    /// Values are data, not colors.
    Raw,
    /// Values are raised to this power.
    Gamma(f32),
}

/// How a file stores its values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Depth {
    /// Integers, here divided by their maximum.
    Integer,
    /// Floating point.
    Float,
}

impl Transfer {
    /// The function from stored to linear values.
    pub(super) fn curve(self, depth: Depth) -> impl Fn(f32) -> f32 {
        let transfer = match (self, depth) {
            (Transfer::Auto, Depth::Integer) => Transfer::Srgb,
            (Transfer::Auto, Depth::Float) => Transfer::Raw,
            (other, _) => other,
        };
        move |v| match transfer {
            Transfer::Srgb => linear_from_srgb(v),
            Transfer::Gamma(exponent) => v.max(0.0).powf(exponent),
            Transfer::Raw | Transfer::Auto => v,
        }
    }

    /// The image with its values made linear.
    pub(super) fn apply(self, mut image: Image, depth: Depth) -> Image {
        let curve = self.curve(depth);
        for v in &mut image.data {
            *v = curve(*v);
        }
        image
    }
}

/// The linear value that sRGB stores as `v`. Source: IEC 61966-2-1.
pub fn linear_from_srgb(v: f32) -> f32 {
    if v <= 0.040_45 {
        v / 12.92
    } else {
        ((v + 0.055) / 1.055).powf(2.4)
    }
}

/// What sRGB stores for a linear value. Source: IEC 61966-2-1.
pub fn srgb_from_linear(v: f32) -> f32 {
    if v <= 0.003_130_8 {
        v * 12.92
    } else {
        1.055 * v.powf(1.0 / 2.4) - 0.055
    }
}
