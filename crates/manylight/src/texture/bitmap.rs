//! Image textures. Conventions are those of Mitsuba 3.9.1's `bitmap`, verified against its values.

use crate::color::Rgb;
use crate::image::Image;
use crate::math::float::floor;
use crate::math::prefetch::prefetch;
use crate::math::{Mat3, Vec2};

/// Interpolation between texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filtering {
    /// Value of the texel that contains the point.
    Nearest,
    /// Bilinear interpolation between the four nearest texels.
    Bilinear,
}

/// Continuation of the image outside of [0, 1]².
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// Periodic repetition.
    Repeat,
    /// Repetition, mirrored in every other period.
    Mirror,
    /// Value of the nearest edge texel.
    Clamp,
}

/// An image over the uv square. Values are linear: the loader decodes them.
///
/// The top row is at v = 0, as in Mitsuba 3. There the mesh loaders flip the v axis (`flip_tex_coords`, on for OBJ), never the texture. Texel
/// centers are at half-integers.
#[derive(Clone, Debug)]
pub struct Bitmap {
    /// One or three channels, linear.
    pub image: Image,
    /// Interpolation between texels.
    pub filtering: Filtering,
    /// Continuation outside of the unit square, along u and along v.
    pub wrap: [Wrap; 2],
    /// Transform of (u, v, 1).
    pub uv_transform: Mat3,
}

/// Largest coordinate of a lookup in texels; larger ones are clamped. From 2²² ≈ 4.2e6 on, `f32` resolves half texels at
/// best, and [`floor`] is not defined.
const FARTHEST_TEXEL: f32 = 4e6;

impl Bitmap {
    /// Filtered color at `uv`.
    pub(super) fn eval(&self, uv: Vec2) -> Rgb {
        self.filter(uv, |x, y| self.image.rgb(x, y))
    }

    /// Filtered luminance at `uv`; for images of one channel their value.
    pub(super) fn eval_float(&self, uv: Vec2) -> f32 {
        self.filter(uv, |x, y| self.value(x, y))
    }

    /// Derivatives of [`Bitmap::eval_float`] by u and by v; zero for [`Filtering::Nearest`], as in Mitsuba.
    ///
    /// Like Mitsuba's `eval_1_grad`, this multiplies by the resolution after the transform, not before. This differs for a non-square image
    /// with a rotation in `uv_transform`, and makes bump maps look alike.
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

    /// Prefetches the memory that evaluation at `uv` reads.
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

    /// Largest luminance of a texel.
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

    /// Column and row, not wrapped, of the upper left texel of the lookup, and the position between it and its neighbors in [0, 1)².
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
        self.wrap[0].index(x, self.image.width)
    }

    fn row(&self, y: i32) -> usize {
        self.wrap[1].index(y, self.image.height)
    }
}

impl Wrap {
    /// Index, from 0 to `n - 1`, of texel `i` of a line of `n` texels.
    #[inline]
    fn index(self, i: i32, n: usize) -> usize {
        if (i as u32 as usize) < n {
            // Inside of the image no mode changes the index; saves a division.
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
