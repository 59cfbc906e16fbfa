//! Image textures. Conventions are those of Mitsuba 3.9.1's `bitmap`, verified against its values.

use crate::color::Rgb;
use crate::image::Image;
use crate::lanes::{Color, Float, Pair, Width, Word};
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
/// The top row is at v = 0, as in Mitsuba 3. There the mesh loaders flip the v axis
/// (`flip_tex_coords`, on for OBJ), never the texture. Texel centers are at half-integers.
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

/// Largest coordinate of a lookup in texels; larger ones are clamped. From 2²² ≈ 4.2e6 on, `f32`
/// resolves half texels at best, and [`Float::floor`] is not defined.
const FARTHEST_TEXEL: f32 = 4e6;

/// The lookups of bilinear interpolation.
struct Footprint<S: Width> {
    /// Indices of the upper left, upper right, lower left and lower right texel.
    texels: [S::Each<u32>; 4],
    /// Position between the texels, in [0, 1)².
    between: Pair<S>,
}

// Closures over vectors are not always inlined; the parts are functions for this reason.
impl Bitmap {
    /// Filtered color at `uv`.
    #[inline(always)]
    pub(super) fn eval<S: Width>(&self, uv: Pair<S>) -> Color<S> {
        let s = uv.x.width();
        if self.filtering == Filtering::Nearest {
            return self.color(s, &self.nearest(uv));
        }
        let Footprint { texels, between } = self.footprint(uv);
        let (a, b) = (self.color(s, &texels[0]), self.color(s, &texels[1]));
        let top = mix_colors(a, b, between.x);
        let (a, b) = (self.color(s, &texels[2]), self.color(s, &texels[3]));
        mix_colors(top, mix_colors(a, b, between.x), between.y)
    }

    /// Filtered luminance at `uv`; for images of one channel their value.
    #[inline(always)]
    pub(super) fn eval_float<S: Width>(&self, uv: Pair<S>) -> Float<S> {
        if self.filtering == Filtering::Nearest {
            return self.value(uv.x.width(), &self.nearest(uv));
        }
        let ([v00, v10, v01, v11], f) = self.four_values(uv);
        mix(mix(v00, v10, f.x), mix(v01, v11, f.x), f.y)
    }

    /// Derivatives of [`Bitmap::eval_float`] by u and by v; zero for [`Filtering::Nearest`], as in
    /// Mitsuba.
    ///
    /// Like Mitsuba's `eval_1_grad`, this multiplies by the resolution after the transform, not
    /// before. This differs for a non-square image with a rotation in `uv_transform`, and makes
    /// bump maps look alike.
    #[inline(always)]
    pub(super) fn gradient<S: Width>(&self, uv: Pair<S>) -> Pair<S> {
        if self.filtering == Filtering::Nearest {
            return Pair::splat(uv.x.width(), Vec2::ZERO);
        }
        let ([v00, v10, v01, v11], f) = self.four_values(uv);
        let du = mix(v10 - v00, v11 - v01, f.y);
        let dv = mix(v01 - v00, v11 - v10, f.x);
        let m = &self.uv_transform;
        Pair::new(
            (du * m.x_axis.x + dv * m.x_axis.y) * self.image.width as f32,
            (du * m.y_axis.x + dv * m.y_axis.y) * self.image.height as f32,
        )
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

    /// Values of the texels of a lookup, and the position between them.
    #[inline(always)]
    fn four_values<S: Width>(&self, uv: Pair<S>) -> ([Float<S>; 4], Pair<S>) {
        let s = uv.x.width();
        let Footprint { texels, between } = self.footprint(uv);
        let [a, b, c, d] = &texels;
        let top = (self.value(s, a), self.value(s, b));
        let bottom = (self.value(s, c), self.value(s, d));
        ([top.0, top.1, bottom.0, bottom.1], between)
    }

    /// The texels that contain `uv`.
    #[inline(always)]
    fn nearest<S: Width>(&self, uv: Pair<S>) -> S::Each<u32> {
        let p = self.in_texels(uv, 0.0);
        self.texel(self.column(p.x.floor()), self.row(p.y.floor()))
    }

    #[inline(always)]
    fn footprint<S: Width>(&self, uv: Pair<S>) -> Footprint<S> {
        // Texel centers are at half-integers.
        let p = self.in_texels(uv, 0.5);
        let (x, y) = (p.x.floor(), p.y.floor());
        let (left, right) = (self.column(x), self.column(x + 1.0));
        let (above, below) = (self.row(y), self.row(y + 1.0));
        Footprint {
            texels: [
                self.texel(left, above),
                self.texel(right, above),
                self.texel(left, below),
                self.texel(right, below),
            ],
            between: Pair::new(p.x - x, p.y - y),
        }
    }

    /// The position in texels, minus `half`.
    #[inline(always)]
    fn in_texels<S: Width>(&self, uv: Pair<S>, half: f32) -> Pair<S> {
        let p = transformed(&self.uv_transform, uv);
        let (x, y) = (
            p.x * self.image.width as f32 - half,
            p.y * self.image.height as f32 - half,
        );
        Pair::new(
            x.clamp(-FARTHEST_TEXEL, FARTHEST_TEXEL),
            y.clamp(-FARTHEST_TEXEL, FARTHEST_TEXEL),
        )
    }

    #[inline(always)]
    fn column<S: Width>(&self, x: Float<S>) -> Word<S> {
        self.wrap[0].index(x, self.image.width).to_word()
    }

    #[inline(always)]
    fn row<S: Width>(&self, y: Float<S>) -> Word<S> {
        self.wrap[1].index(y, self.image.height).to_word()
    }

    /// Indices of texels, of which an image has fewer than 2³².
    #[inline(always)]
    fn texel<S: Width>(&self, column: Word<S>, row: Word<S>) -> S::Each<u32> {
        (row * self.image.width as u32 + column).store()
    }

    /// Colors of texels. Images of one or two channels give gray.
    #[inline(always)]
    fn color<S: Width>(&self, s: S, texels: &S::Each<u32>) -> Color<S> {
        let (data, channels) = (self.image.data.as_slice(), self.image.channels);
        if channels < 3 {
            return Color::grey(self.first_channel(s, texels));
        }
        // Four values from the first of a texel on; they end in the next texel, which the last one
        // lacks.
        let last = match *data {
            [.., r, g, b] => [r, g, b, 0.0],
            _ => [0.0; 4],
        };
        let [[r, g, b, _]] = Float::gather_quads(s, |i| {
            let start = texels.as_ref()[i] as usize * channels;
            [four_from(data, start, &last)]
        });
        Color::new(r, g, b)
    }

    /// Luminances of texels; for images of one channel their values.
    #[inline(always)]
    fn value<S: Width>(&self, s: S, texels: &S::Each<u32>) -> Float<S> {
        match self.image.channels {
            0..3 => self.first_channel(s, texels),
            _ => self.color(s, texels).luminance(),
        }
    }

    #[inline(always)]
    fn first_channel<S: Width>(&self, s: S, texels: &S::Each<u32>) -> Float<S> {
        let (data, channels) = (self.image.data.as_slice(), self.image.channels);
        Float::from_fn(s, |i| {
            let value = data.get(texels.as_ref()[i] as usize * channels);
            *value.unwrap_or(&0.0)
        })
    }
}

/// The four values from `start` on, `last` if there are fewer.
#[inline(always)]
fn four_from<'a>(data: &'a [f32], start: usize, last: &'a [f32; 4]) -> &'a [f32; 4] {
    match data.get(start..) {
        Some(rest) => rest.first_chunk().unwrap_or(last),
        None => last,
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
    Pair::new(
        product(uv, [m.x_axis.x, m.y_axis.x, m.z_axis.x]),
        product(uv, [m.x_axis.y, m.y_axis.y, m.z_axis.y]),
    )
}

/// The product of (u, v, 1) with `row`.
#[inline(always)]
fn product<S: Width>(uv: Pair<S>, row: [f32; 3]) -> Float<S> {
    let [u, v, one] = row;
    let sum = uv.y.mul_add(uv.y.same(v), uv.y.same(one));
    uv.x.mul_add(uv.x.same(u), sum)
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
