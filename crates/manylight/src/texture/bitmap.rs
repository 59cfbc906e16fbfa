//! Image textures. Conventions are those of Mitsuba 3.9.1's `bitmap`, verified against its values.

use crate::color::Rgb;
use crate::image::Image;
use crate::lanes::{Color, Float, One, Pair, Width};
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
/// best, and [`Float::floor`] is not defined.
const FARTHEST_TEXEL: f32 = 4e6;

/// Texels of the lookups of bilinear interpolation.
struct Footprint<S: Width> {
    /// Indices of the left and of the right column.
    columns: [S::Each<u32>; 2],
    /// Indices of the upper and of the lower row.
    rows: [S::Each<u32>; 2],
    /// Position between the texels, in [0, 1)².
    between: Pair<S>,
}

impl Bitmap {
    /// Filtered color at `uv`.
    #[inline(always)]
    pub(super) fn eval<S: Width>(&self, uv: Pair<S>) -> Color<S> {
        let s = uv.x.width();
        if self.filtering == Filtering::Nearest {
            let (column, row) = self.nearest(uv);
            return self.color(s, &column, &row);
        }
        let Footprint {
            columns: [left, right],
            rows: [above, below],
            between,
        } = self.footprint(uv);
        let (a, b) = (self.color(s, &left, &above), self.color(s, &right, &above));
        let top = mix_colors(a, b, between.x);
        let (a, b) = (self.color(s, &left, &below), self.color(s, &right, &below));
        mix_colors(top, mix_colors(a, b, between.x), between.y)
    }

    /// Filtered luminance at `uv`; for images of one channel their value.
    #[inline(always)]
    pub(super) fn eval_float<S: Width>(&self, uv: Pair<S>) -> Float<S> {
        let s = uv.x.width();
        if self.filtering == Filtering::Nearest {
            let (column, row) = self.nearest(uv);
            return self.value(s, &column, &row);
        }
        let (values, between) = self.four_values(uv);
        let top = mix(values[0], values[1], between.x);
        mix(top, mix(values[2], values[3], between.x), between.y)
    }

    /// Derivatives of [`Bitmap::eval_float`] by u and by v; zero for [`Filtering::Nearest`], as in Mitsuba.
    ///
    /// Like Mitsuba's `eval_1_grad`, this multiplies by the resolution after the transform, not before. This differs for a non-square image
    /// with a rotation in `uv_transform`, and makes bump maps look alike.
    #[inline(always)]
    pub(super) fn gradient<S: Width>(&self, uv: Pair<S>) -> Pair<S> {
        if self.filtering == Filtering::Nearest {
            return Pair::splat(uv.x.width(), Vec2::ZERO);
        }
        let ([v00, v10, v01, v11], f) = self.four_values(uv);
        let du = (v11 - v01).mul_add(f.y, (v10 - v00) * (1.0 - f.y));
        let dv = (v11 - v10).mul_add(f.x, (v01 - v00) * (1.0 - f.x));
        let m = &self.uv_transform;
        Pair::new(
            (du * m.x_axis.x + dv * m.x_axis.y) * self.image.width as f32,
            (du * m.y_axis.x + dv * m.y_axis.y) * self.image.height as f32,
        )
    }

    /// Prefetches the memory that evaluation at `uv` reads.
    #[inline]
    pub(super) fn prefetch(&self, uv: Vec2) {
        let Footprint { columns, rows, .. } = self.footprint(Pair::<One>::from(uv));
        for [row] in rows {
            if let Some(texel) = self.image.data.get(self.start(columns[0][0], row)) {
                prefetch(texel);
            }
        }
    }

    /// Largest luminance of a texel.
    pub(super) fn max_luminance(&self) -> f32 {
        let pixels =
            (0..self.image.height).flat_map(|y| (0..self.image.width).map(move |x| (x, y)));
        let value = |(x, y): (usize, usize)| match *self.image.pixel(x, y) {
            [r, g, b, ..] => Rgb::new(r, g, b).luminance(),
            [v, ..] => v,
            [] => 0.0,
        };
        pixels.map(value).fold(0.0, f32::max)
    }

    /// Values of the upper left, upper right, lower left and lower right texel of a lookup, and the position between them.
    #[inline(always)]
    fn four_values<S: Width>(&self, uv: Pair<S>) -> ([Float<S>; 4], Pair<S>) {
        let s = uv.x.width();
        let Footprint {
            columns: [left, right],
            rows: [above, below],
            between,
        } = self.footprint(uv);
        let values = [
            self.value(s, &left, &above),
            self.value(s, &right, &above),
            self.value(s, &left, &below),
            self.value(s, &right, &below),
        ];
        (values, between)
    }

    /// The texel that contains `uv`: column and row.
    #[inline(always)]
    fn nearest<S: Width>(&self, uv: Pair<S>) -> (S::Each<u32>, S::Each<u32>) {
        let p = self.in_texels(uv, 0.0);
        let index = |x: Float<S>, wrap: Wrap, n: usize| wrap.index(x.floor(), n).to_word().store();
        (
            index(p.x, self.wrap[0], self.image.width),
            index(p.y, self.wrap[1], self.image.height),
        )
    }

    #[inline(always)]
    fn footprint<S: Width>(&self, uv: Pair<S>) -> Footprint<S> {
        // Texel centers are at half-integers.
        let p = self.in_texels(uv, 0.5);
        let (left, above) = (p.x.floor(), p.y.floor());
        let two = |first: Float<S>, wrap: Wrap, n: usize| {
            let second = wrap.index(first + 1.0, n);
            let first = wrap.index(first, n);
            [first.to_word().store(), second.to_word().store()]
        };
        Footprint {
            columns: two(left, self.wrap[0], self.image.width),
            rows: two(above, self.wrap[1], self.image.height),
            between: Pair::new(p.x - left, p.y - above),
        }
    }

    /// The position in texels, minus `half`.
    #[inline(always)]
    fn in_texels<S: Width>(&self, uv: Pair<S>, half: f32) -> Pair<S> {
        let p = transformed(&self.uv_transform, uv);
        let scaled =
            |x: Float<S>, n: usize| (x * n as f32 - half).clamp(-FARTHEST_TEXEL, FARTHEST_TEXEL);
        Pair::new(
            scaled(p.x, self.image.width),
            scaled(p.y, self.image.height),
        )
    }

    /// Index of the first value of a texel.
    #[inline(always)]
    fn start(&self, column: u32, row: u32) -> usize {
        (row as usize * self.image.width + column as usize) * self.image.channels
    }

    /// Colors of texels. Images of one or two channels give gray.
    #[inline(always)]
    fn color<S: Width>(&self, s: S, column: &S::Each<u32>, row: &S::Each<u32>) -> Color<S> {
        let start = |i: usize| self.start(column.as_ref()[i], row.as_ref()[i]);
        let data = &self.image.data;
        if self.image.channels < 3 {
            let value = |i: usize| data.get(start(i)).copied().unwrap_or(0.0);
            return Color::grey(Float::from_fn(s, value));
        }
        // Four values from the first of a texel on; they end in the next texel, which the last one lacks.
        let last = match **data {
            [.., r, g, b] => [r, g, b, 0.0],
            _ => [0.0; 4],
        };
        let [[r, g, b, _]] = Float::gather_quads(s, |i| {
            let four = data.get(start(i)..).and_then(<[f32]>::first_chunk);
            [four.unwrap_or(&last)]
        });
        Color::new(r, g, b)
    }

    /// Luminances of texels; for images of one channel their values.
    #[inline(always)]
    fn value<S: Width>(&self, s: S, column: &S::Each<u32>, row: &S::Each<u32>) -> Float<S> {
        let color = self.color(s, column, row);
        match self.image.channels {
            0..3 => color.r,
            _ => color.luminance(),
        }
    }
}

/// Linear interpolation: `a` at `t = 0`, `b` at `t = 1`.
#[inline(always)]
fn mix<S: Width>(a: Float<S>, b: Float<S>, t: Float<S>) -> Float<S> {
    b.mul_add(t, a * (1.0 - t))
}

#[inline(always)]
fn mix_colors<S: Width>(a: Color<S>, b: Color<S>, t: Float<S>) -> Color<S> {
    Color::new(mix(a.r, b.r, t), mix(a.g, b.g, t), mix(a.b, b.b, t))
}

/// The texture coordinates under a transform of (u, v, 1).
#[inline(always)]
pub(super) fn transformed<S: Width>(m: &Mat3, uv: Pair<S>) -> Pair<S> {
    let along = |u: f32, v: f32, offset: f32| {
        let s = uv.x.width();
        let sum = uv.y.mul_add(Float::splat(s, v), Float::splat(s, offset));
        uv.x.mul_add(Float::splat(s, u), sum)
    };
    Pair::new(
        along(m.x_axis.x, m.y_axis.x, m.z_axis.x),
        along(m.x_axis.y, m.y_axis.y, m.z_axis.y),
    )
}

impl Wrap {
    /// Index, from 0 to `n - 1`, of texel `i` of a line of `n` texels. Both are integers below 2²².
    #[inline(always)]
    fn index<S: Width>(self, i: Float<S>, n: usize) -> Float<S> {
        let n = n as f32;
        if (i.ge(0.0) & i.lt(n)).all() {
            // Inside of the image no mode changes the index.
            return i;
        }
        match self {
            Wrap::Repeat => remainder(i, n),
            Wrap::Mirror => {
                let k = remainder(i, 2.0 * n);
                k.min(2.0 * n - 1.0 - k)
            }
            Wrap::Clamp => i.clamp(0.0, n - 1.0),
        }
    }
}

/// The remainder of integers, in [0, n).
#[inline(always)]
fn remainder<S: Width>(i: Float<S>, n: f32) -> Float<S> {
    // The quotient by the inverse of `n` may be off by one.
    let rest = i - (i * (1.0 / n)).floor() * n;
    let rest = rest.lt(0.0).select(rest + n, rest);
    rest.ge(n).select(rest - n, rest)
}
