//! Images as textures. Conventions are those of Mitsuba 3.9.1's `bitmap`, measured by evaluating it.

use crate::color::Rgb;
use crate::image::Image;
use crate::math::float::floor;
use crate::math::prefetch::prefetch;
use crate::math::{Mat3, Vec2};

/// How texels are blended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filtering {
    /// The texel that holds the point.
    Nearest,
    /// The four texels around the point.
    Bilinear,
}

/// What lies outside [0, 1]².
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// The image again.
    Repeat,
    /// The image mirrored.
    Mirror,
    /// The nearest edge texel.
    Clamp,
}

/// An image over the uv square. Values are linear (decoded by the loader).
///
/// The image's top row is at v = 0, as in Mitsuba 3: there the v axis is turned round by mesh loaders
/// (`flip_tex_coords`, on for OBJ), never by the texture. Texel centers are at half-integers.
#[derive(Clone, Debug)]
pub struct Bitmap {
    /// One or three channels, linear.
    pub image: Image,
    /// How texels are blended.
    pub filtering: Filtering,
    /// What lies outside.
    pub wrap: Wrap,
    /// Applied to (u, v, 1).
    pub uv_transform: Mat3,
}

/// Coordinates beyond this many texels are cut: so far out single precision cannot tell the parts of a texel apart.
const FARTHEST_TEXEL: f32 = 4e6;

impl Bitmap {
    /// Color at `uv`.
    pub(super) fn eval(&self, uv: Vec2) -> Rgb {
        self.filter(uv, |x, y| self.image.rgb(x, y))
    }

    /// Luminance at `uv`; of one-channel images the value.
    pub(super) fn eval_float(&self, uv: Vec2) -> f32 {
        self.filter(uv, |x, y| self.value(x, y))
    }

    /// Derivatives of [`Bitmap::eval_float`] by u and v; zero without blending, as in Mitsuba.
    ///
    /// With a rotation in `uv_transform` and a non-square image, Mitsuba's `eval_1_grad` multiplies by the resolution after
    /// the transform and not before. Bump maps must look as there, so this does the same.
    pub(super) fn gradient(&self, uv: Vec2) -> Vec2 {
        if self.filtering == Filtering::Nearest {
            return Vec2::ZERO;
        }
        let (x, y, f) = self.locate(uv);
        let texel = |dx, dy| self.value(self.column(x + dx), self.row(y + dy));
        let [v00, v10, v01, v11] = [texel(0, 0), texel(1, 0), texel(0, 1), texel(1, 1)];
        let du = (v10 - v00) * (1.0 - f.y) + (v11 - v01) * f.y;
        let dv = (v01 - v00) * (1.0 - f.x) + (v11 - v10) * f.x;
        let m = &self.uv_transform;
        let resolution = Vec2::new(self.image.width as f32, self.image.height as f32);
        resolution
            * Vec2::new(
                m.x_axis.x * du + m.x_axis.y * dv,
                m.y_axis.x * du + m.y_axis.y * dv,
            )
    }

    /// Asks for the memory that evaluation at `uv` will read.
    #[inline]
    pub(super) fn prefetch(&self, uv: Vec2) {
        let (x, y, _) = self.locate(uv);
        let column = self.column(x);
        for y in [y, y + 1] {
            if let Some(texel) = self.image.pixel(column, self.row(y)).first() {
                prefetch(texel);
            }
        }
    }

    /// Largest luminance of any texel.
    pub(super) fn max_luminance(&self) -> f32 {
        let pixels =
            (0..self.image.height).flat_map(|y| (0..self.image.width).map(move |x| (x, y)));
        pixels.map(|(x, y)| self.value(x, y)).fold(0.0, f32::max)
    }

    fn filter<T>(&self, uv: Vec2, texel: impl Fn(usize, usize) -> T) -> T
    where
        T: std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>,
    {
        let (x, y, f) = self.locate(uv);
        if self.filtering == Filtering::Nearest {
            return texel(self.column(x), self.row(y));
        }
        let (left, right) = (self.column(x), self.column(x + 1));
        let (above, below) = (self.row(y), self.row(y + 1));
        let top = texel(left, above) * (1.0 - f.x) + texel(right, above) * f.x;
        let bottom = texel(left, below) * (1.0 - f.x) + texel(right, below) * f.x;
        top * (1.0 - f.y) + bottom * f.y
    }

    /// The (unwrapped) texel at the upper left of the point, and where the point lies between its neighbors.
    fn locate(&self, uv: Vec2) -> (i32, i32, Vec2) {
        let half = if self.filtering == Filtering::Nearest {
            0.0
        } else {
            0.5
        };
        let resolution = Vec2::new(self.image.width as f32, self.image.height as f32);
        let p = self.uv_transform.transform_point2(uv) * resolution - Vec2::splat(half);
        let p = p.clamp(Vec2::splat(-FARTHEST_TEXEL), Vec2::splat(FARTHEST_TEXEL));
        let ((left, x), (above, y)) = (floor(p.x), floor(p.y));
        (x, y, p - Vec2::new(left, above))
    }

    fn value(&self, x: usize, y: usize) -> f32 {
        match *self.image.pixel(x, y) {
            [r, g, b, ..] => Rgb::new(r, g, b).luminance(),
            [v, ..] => v,
            [] => 0.0,
        }
    }

    fn column(&self, x: i32) -> usize {
        self.wrap.index(x, self.image.width)
    }

    fn row(&self, y: i32) -> usize {
        self.wrap.index(y, self.image.height)
    }
}

impl Wrap {
    /// The texel that stands for texel `i` of a line of `n` texels.
    #[inline]
    fn index(self, i: i32, n: usize) -> usize {
        if (i as u32 as usize) < n {
            // Within the image all agree, without a division.
            return i as usize;
        }
        let n = n as i32;
        let wrapped = match self {
            Wrap::Repeat => i.rem_euclid(n),
            Wrap::Mirror => {
                let k = i.rem_euclid(2 * n);
                k.min(2 * n - 1 - k)
            }
            Wrap::Clamp => i.clamp(0, n - 1),
        };
        wrapped as usize
    }
}
