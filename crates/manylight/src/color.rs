//! Linear Rec. 709 color.

use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// Linear Rec. 709 RGB: radiance, flux, intensity, reflectance or any other per-channel quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Rgb {
    /// Red.
    pub r: f32,
    /// Green.
    pub g: f32,
    /// Blue.
    pub b: f32,
}

impl Rgb {
    /// Zero in every channel.
    pub const BLACK: Rgb = Rgb::splat(0.0);
    /// One in every channel.
    pub const WHITE: Rgb = Rgb::splat(1.0);

    /// A color from its three channels.
    #[inline]
    pub const fn new(r: f32, g: f32, b: f32) -> Self {
        Rgb { r, g, b }
    }

    /// The same value in every channel.
    #[inline]
    pub const fn splat(v: f32) -> Self {
        Rgb { r: v, g: v, b: v }
    }

    /// Weights of the channels in the relative luminance of linear Rec. 709.
    pub const LUMINANCE: [f32; 3] = [0.212_671, 0.715_160, 0.072_169];

    /// Relative luminance.
    #[inline]
    pub fn luminance(self) -> f32 {
        let [r, g, b] = Self::LUMINANCE;
        r * self.r + g * self.g + b * self.b
    }

    /// A scalar in proportion to which a quantity is sampled, such as the power of emitters:
    /// positive for every color that is not black.
    pub(crate) fn selection_weight(self) -> f32 {
        // The mean of luminance and largest channel: by luminance alone blue light would have few
        // samples of large weight.
        0.5 * (self.luminance() + self.max_channel()).max(0.0)
    }

    /// The largest channel.
    #[inline]
    pub fn max_channel(self) -> f32 {
        self.r.max(self.g).max(self.b)
    }

    /// The mean of the three channels.
    #[inline]
    pub fn mean(self) -> f32 {
        (self.r + self.g + self.b) * (1.0 / 3.0)
    }

    /// Whether every channel is zero.
    #[inline]
    pub fn is_black(self) -> bool {
        self.r == 0.0 && self.g == 0.0 && self.b == 0.0
    }

    /// Whether all channels are equal.
    #[inline]
    pub fn is_gray(self) -> bool {
        self.r == self.g && self.g == self.b
    }

    /// Whether every channel is finite.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.r.is_finite() && self.g.is_finite() && self.b.is_finite()
    }

    /// Applies `f` to every channel.
    #[inline]
    pub fn map(self, f: impl Fn(f32) -> f32) -> Self {
        Rgb::new(f(self.r), f(self.g), f(self.b))
    }

    /// Applies `f` to every pair of channels.
    #[inline]
    pub fn zip(self, other: Rgb, f: impl Fn(f32, f32) -> f32) -> Self {
        Rgb::new(f(self.r, other.r), f(self.g, other.g), f(self.b, other.b))
    }

    /// Linear interpolation: `self` at `t = 0`, `other` at `t = 1`.
    #[inline]
    pub fn lerp(self, other: Rgb, t: f32) -> Self {
        self * (1.0 - t) + other * t
    }

    /// The three channels in order.
    #[inline]
    pub fn to_array(self) -> [f32; 3] {
        [self.r, self.g, self.b]
    }
}

impl From<[f32; 3]> for Rgb {
    #[inline]
    fn from([r, g, b]: [f32; 3]) -> Self {
        Rgb::new(r, g, b)
    }
}

impl From<Rgb> for [f32; 3] {
    #[inline]
    fn from(c: Rgb) -> Self {
        c.to_array()
    }
}

macro_rules! channelwise {
    ($($trait:ident $method:ident $assign_trait:ident $assign_method:ident),*) => {$(
        impl $trait for Rgb {
            type Output = Rgb;
            #[inline]
            fn $method(self, o: Rgb) -> Rgb {
                Rgb::new(self.r.$method(o.r), self.g.$method(o.g), self.b.$method(o.b))
            }
        }
        impl $trait<f32> for Rgb {
            type Output = Rgb;
            #[inline]
            fn $method(self, s: f32) -> Rgb {
                Rgb::new(self.r.$method(s), self.g.$method(s), self.b.$method(s))
            }
        }
        impl $assign_trait for Rgb {
            #[inline]
            fn $assign_method(&mut self, o: Rgb) {
                *self = (*self).$method(o);
            }
        }
        impl $assign_trait<f32> for Rgb {
            #[inline]
            fn $assign_method(&mut self, s: f32) {
                *self = (*self).$method(s);
            }
        }
    )*};
}

channelwise!(Add add AddAssign add_assign, Sub sub SubAssign sub_assign, Mul mul MulAssign mul_assign, Div div DivAssign div_assign);

impl Mul<Rgb> for f32 {
    type Output = Rgb;
    #[inline]
    fn mul(self, c: Rgb) -> Rgb {
        c * self
    }
}

impl Neg for Rgb {
    type Output = Rgb;
    fn neg(self) -> Rgb {
        self * -1.0
    }
}

impl std::iter::Sum for Rgb {
    fn sum<I: Iterator<Item = Rgb>>(iter: I) -> Rgb {
        iter.fold(Rgb::BLACK, |a, b| a + b)
    }
}
