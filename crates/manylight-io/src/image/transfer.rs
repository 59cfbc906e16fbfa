//! Transfer functions between stored and linear values.

use manylight::image::Image;

/// The transfer function from the values of an image file to linear values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Transfer {
    /// The sRGB curve for 8 and 16 bit integers, the identity for floating point.
    #[default]
    Auto,
    /// The sRGB curve.
    Srgb,
    /// The identity: values are linear, or not colors.
    Raw,
    /// Raises values to this power; negative values become 0.
    Gamma(f32),
}

/// How a file stores its values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Depth {
    /// Integers, divided by their maximum.
    Integer,
    /// Floating point.
    Float,
}

impl Transfer {
    /// The function from a stored to a linear value.
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

    /// The image with linear values.
    pub(super) fn apply(self, mut image: Image, depth: Depth) -> Image {
        let curve = self.curve(depth);
        for v in &mut image.data {
            *v = curve(*v);
        }
        image
    }
}

/// The linear value of the sRGB value `v`. Source: IEC 61966-2-1.
pub fn linear_from_srgb(v: f32) -> f32 {
    if v <= 0.040_45 {
        v / 12.92
    } else {
        ((v + 0.055) / 1.055).powf(2.4)
    }
}

/// The sRGB value of the linear value `v`. Source: IEC 61966-2-1.
pub fn srgb_from_linear(v: f32) -> f32 {
    if v <= 0.003_130_8 {
        v * 12.92
    } else {
        1.055 * v.powf(1.0 / 2.4) - 0.055
    }
}
