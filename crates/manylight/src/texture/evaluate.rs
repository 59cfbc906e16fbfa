//! Values of textures and inputs, nested textures included. Single values are those of one lane.

use super::bitmap::transformed;
use super::point::TexturePoints;
use super::solid::{Pattern, is_in_dot};
use super::{ColorInput, FloatInput, Texture, TexturePoint};
use crate::color::Rgb;
use crate::geometry::SurfacePoints;
use crate::ids::TextureId;
use crate::lanes::{Color, Float, Mask, Pair, Vector, Width};
use crate::math::{Mat3, Vec2, Vec3};
use crate::simd::outlined;

/// A texture at a place in each lane.
#[derive(Clone, Copy)]
struct Lookup<'a, S: Width> {
    texture: &'a Texture,
    at: TexturePoints<'a, S>,
    /// All textures of the scene, for nested ones.
    textures: &'a [Texture],
}

outlined! {
    /// [`Texture::eval`] in lanes.
    fn color<S: Width>(look: Lookup<'_, S>) -> Color<S> { look.width() => look.color_inlined() }

    /// [`Texture::eval_float`] in lanes.
    fn value<S: Width>(look: Lookup<'_, S>) -> Float<S> { look.width() => look.value_inlined() }

    /// [`Texture::gradient`] in lanes, with the derivatives of the position.
    fn gradient<S: Width>(look: Lookup<'_, S>, dp: [Vector<S>; 2]) -> Pair<S> {
        look.width() => look.gradient_inlined(dp)
    }
}

impl Texture {
    /// Filtered color at a point. `textures` are all textures of the scene, for nested ones.
    pub fn eval(&self, at: impl Into<TexturePoint>, textures: &[Texture]) -> Rgb {
        let at = at.into();
        Lookup::new(self, at.in_lane(&at.reference()), textures)
            .color()
            .into()
    }

    /// Filtered luminance at a point, for float parameters; of a product, the product of the
    /// luminances.
    ///
    /// As in Mitsuba 3.9.1's `eval_1`, the cells of a checkerboard are swapped against
    /// [`Texture::eval`].
    pub fn eval_float(&self, at: impl Into<TexturePoint>, textures: &[Texture]) -> f32 {
        let at = at.into();
        let value = Lookup::new(self, at.in_lane(&at.reference()), textures).value();
        value.get()
    }

    /// Derivatives of [`Texture::eval_float`] by u and by v, for bump maps. `dp` are those of the
    /// position. As in Mitsuba's `eval_1_grad`, from the four texels of the lookup; 0 for
    /// checkerboards, dots and values of vertices. Products and mixtures follow the rules of
    /// derivatives.
    pub fn gradient(
        &self,
        at: impl Into<TexturePoint>,
        dp: [Vec3; 2],
        textures: &[Texture],
    ) -> Vec2 {
        let at = at.into();
        let reference = at.reference();
        let lookup = Lookup::new(self, at.in_lane(&reference), textures);
        let gradient = lookup.gradient(dp.map(Vector::from));
        Vec2::new(gradient.x.get(), gradient.y.get())
    }

    /// [`Texture::gradient`] in each lane.
    #[inline(always)]
    pub(crate) fn gradient_each<S: Width>(
        &self,
        x: &SurfacePoints<S>,
        textures: &[Texture],
    ) -> Pair<S> {
        Lookup::new(self, x.into(), textures).gradient([x.dp_du, x.dp_dv])
    }
}

impl ColorInput {
    /// Value at a point.
    #[inline]
    pub fn eval(&self, at: impl Into<TexturePoint>, textures: &[Texture]) -> Rgb {
        match *self {
            ColorInput::Constant(c) => c,
            ColorInput::Texture(id) => textures[id.index()].eval(at, textures),
        }
    }

    /// Value in each lane.
    #[inline(always)]
    pub(crate) fn eval_each<S: Width>(
        &self,
        x: &SurfacePoints<S>,
        textures: &[Texture],
    ) -> Color<S> {
        match *self {
            ColorInput::Constant(c) => Color::splat(x.offset.width(), c),
            ColorInput::Texture(id) => {
                Lookup::new(&textures[id.index()], x.into(), textures).color()
            }
        }
    }
}

impl FloatInput {
    /// Value in each lane.
    #[inline(always)]
    pub(crate) fn eval_each<S: Width>(
        &self,
        x: &SurfacePoints<S>,
        textures: &[Texture],
    ) -> Float<S> {
        match *self {
            FloatInput::Constant(c) => Float::splat(x.offset.width(), c),
            FloatInput::Texture(id) => {
                Lookup::new(&textures[id.index()], x.into(), textures).value()
            }
        }
    }

    /// Value at a point.
    #[inline]
    pub fn eval(&self, at: impl Into<TexturePoint>, textures: &[Texture]) -> f32 {
        match *self {
            FloatInput::Constant(v) => v,
            FloatInput::Texture(id) => textures[id.index()].eval_float(at, textures),
        }
    }
}

impl<'a, S: Width> Lookup<'a, S> {
    #[inline(always)]
    fn new(texture: &'a Texture, at: TexturePoints<'a, S>, textures: &'a [Texture]) -> Self {
        Lookup {
            texture,
            at,
            textures,
        }
    }

    #[inline(always)]
    fn width(&self) -> S {
        self.at.uv.x.width()
    }

    #[inline(always)]
    fn color(self) -> Color<S> {
        color(self)
    }

    #[inline(always)]
    fn value(self) -> Float<S> {
        value(self)
    }

    #[inline(always)]
    fn gradient(self, dp: [Vector<S>; 2]) -> Pair<S> {
        gradient(self, dp)
    }

    /// Another texture at the same place.
    #[inline(always)]
    fn of(&self, texture: &'a Texture) -> Self {
        Lookup { texture, ..*self }
    }

    #[inline(always)]
    fn with_uv(self, uv: Pair<S>) -> Self {
        let at = TexturePoints { uv, ..self.at };
        Lookup { at, ..self }
    }

    #[inline(always)]
    fn color_of(&self, input: &ColorInput) -> Color<S> {
        match *input {
            ColorInput::Constant(color) => Color::splat(self.width(), color),
            ColorInput::Texture(id) => self.of(&self.textures[id.index()]).color(),
        }
    }

    #[inline(always)]
    fn value_of(&self, input: &ColorInput) -> Float<S> {
        match *input {
            ColorInput::Constant(color) => Float::splat(self.width(), color.luminance()),
            ColorInput::Texture(id) => self.of(&self.textures[id.index()]).value(),
        }
    }

    #[inline(always)]
    fn gradient_of(&self, input: &ColorInput, dp: [Vector<S>; 2]) -> Pair<S> {
        match *input {
            ColorInput::Constant(_) => self.flat(),
            ColorInput::Texture(id) => self.of(&self.textures[id.index()]).gradient(dp),
        }
    }

    /// No slope.
    #[inline(always)]
    fn flat(&self) -> Pair<S> {
        Pair::splat(self.width(), Vec2::ZERO)
    }

    /// The color of `a` in the lanes of `m`, of `b` elsewhere.
    #[inline(always)]
    fn choose_color(&self, m: Mask<S>, a: &ColorInput, b: &ColorInput) -> Color<S> {
        if m.all() {
            return self.color_of(a);
        }
        let b = self.color_of(b);
        if m.none() {
            return b;
        }
        Color::select(m, self.color_of(a), b)
    }

    /// The value of `a` in the lanes of `m`, of `b` elsewhere.
    #[inline(always)]
    fn choose_value(&self, m: Mask<S>, a: &ColorInput, b: &ColorInput) -> Float<S> {
        if m.all() {
            return self.value_of(a);
        }
        let b = self.value_of(b);
        if m.none() {
            return b;
        }
        m.select(self.value_of(a), b)
    }

    /// Weight of the second input of a mixture, in [0, 1].
    #[inline(always)]
    fn mixing_weight(&self, weight: &FloatInput) -> Float<S> {
        let weight = match *weight {
            FloatInput::Constant(weight) => Float::splat(self.width(), weight),
            FloatInput::Texture(id) => self.of(&self.textures[id.index()]).value(),
        };
        weight.clamp(0.0, 1.0)
    }

    /// The texture `inner` at transformed coordinates.
    #[inline(always)]
    fn at_transformed(&self, uv_transform: &Mat3, inner: TextureId) -> Self {
        let uv = transformed(uv_transform, self.at.uv);
        self.of(&self.textures[inner.index()]).with_uv(uv)
    }

    /// 1 in the lanes in which a texture has at least the value `threshold`, else 0.
    #[inline(always)]
    fn step(&self, base: TextureId, threshold: f32) -> Float<S> {
        let value = self.of(&self.textures[base.index()]).value();
        value.ge(threshold).select(1.0, 0.0)
    }

    /// The lanes with transformed coordinates in a dot.
    #[inline(always)]
    fn in_dot(&self, uv_transform: &Mat3) -> Mask<S> {
        let uv = transformed(uv_transform, self.at.uv);
        let (u, v) = (uv.x.store(), uv.y.store());
        self.mask(|i| is_in_dot(Vec2::new(u.as_ref()[i], v.as_ref()[i])))
    }

    /// The lanes for which `test` holds.
    #[inline(always)]
    fn mask(&self, test: impl Fn(usize) -> bool) -> Mask<S> {
        let bits = (0..S::LANES).fold(0, |bits, i| bits | u32::from(test(i)) << i);
        Mask::from_bits(self.width(), bits)
    }

    /// The position in each lane.
    #[inline(always)]
    fn positions(&self) -> S::Each<Vec3> {
        each_vector(self.at.p)
    }
}

/// The vector in each lane.
#[inline(always)]
fn each_vector<S: Width>(v: Vector<S>) -> S::Each<Vec3> {
    let [x, y, z] = v.store();
    let vector = |i: usize| Vec3::new(x.as_ref()[i], y.as_ref()[i], z.as_ref()[i]);
    v.x.width().each(vector)
}

impl<S: Width> Lookup<'_, S> {
    #[inline(always)]
    fn color_inlined(&self) -> Color<S> {
        let s = self.width();
        match self.texture {
            Texture::Bitmap(bitmap) => bitmap.eval(self.at.uv),
            Texture::Checkerboard {
                color0,
                color1,
                uv_transform,
            } => {
                let is_main = is_main_cell(transformed(uv_transform, self.at.uv));
                self.choose_color(is_main, color0, color1)
            }
            Texture::Product { first, second } => self.color_of(first) * self.color_of(second),
            Texture::VertexColors(colors) => {
                Color::from_fn(s, |i| colors.at(&self.at.at.as_ref()[i]))
            }
            Texture::OtherUv { uvs, inner } => {
                let uv = Pair::from_fn(s, |i| uvs.at(&self.at.at.as_ref()[i]));
                self.of(&self.textures[inner.index()]).with_uv(uv).color()
            }
            Texture::Mix {
                first,
                second,
                weight,
            } => {
                let w = self.mixing_weight(weight);
                self.color_of(first).lerp(self.color_of(second), w)
            }
            Texture::Dots {
                inside,
                outside,
                uv_transform,
            } => self.choose_color(self.in_dot(uv_transform), inside, outside),
            Texture::Power { base, exponent } => {
                let base = self.of(&self.textures[base.index()]).color();
                base.map(|v| power(v, *exponent))
            }
            Texture::Step { base, threshold } => Color::grey(self.step(*base, *threshold)),
            Texture::Transformed {
                uv_transform,
                inner,
            } => self.at_transformed(uv_transform, *inner).color(),
            Texture::Solid(solid) => match &solid.pattern {
                Pattern::Cells { color0, color1 } => {
                    let p = self.positions();
                    let is_even = self.mask(|i| solid.is_even_cell(p.as_ref()[i]));
                    self.choose_color(is_even, color0, color1)
                }
                _ => {
                    let p = self.positions();
                    Color::from_fn(s, |i| solid.color(p.as_ref()[i]))
                }
            },
            Texture::Projected { projection, inner } => {
                let p = self.positions();
                let uv = Pair::from_fn(s, |i| projection.uv(p.as_ref()[i]));
                self.of(&self.textures[inner.index()]).with_uv(uv).color()
            }
        }
    }

    #[inline(always)]
    fn value_inlined(&self) -> Float<S> {
        let s = self.width();
        match self.texture {
            Texture::Bitmap(bitmap) => bitmap.eval_float(self.at.uv),
            Texture::Checkerboard {
                color0,
                color1,
                uv_transform,
            } => {
                let is_main = is_main_cell(transformed(uv_transform, self.at.uv));
                self.choose_value(is_main, color1, color0)
            }
            Texture::Product { first, second } => self.value_of(first) * self.value_of(second),
            Texture::VertexColors(colors) => Float::from_fn(s, |i| {
                let color: Rgb = colors.at(&self.at.at.as_ref()[i]);
                color.luminance()
            }),
            Texture::OtherUv { uvs, inner } => {
                let uv = Pair::from_fn(s, |i| uvs.at(&self.at.at.as_ref()[i]));
                self.of(&self.textures[inner.index()]).with_uv(uv).value()
            }
            Texture::Mix {
                first,
                second,
                weight,
            } => {
                let w = self.mixing_weight(weight);
                self.value_of(first) * (1.0 - w) + self.value_of(second) * w
            }
            Texture::Dots {
                inside,
                outside,
                uv_transform,
            } => self.choose_value(self.in_dot(uv_transform), inside, outside),
            Texture::Power { base, exponent } => {
                power(self.of(&self.textures[base.index()]).value(), *exponent)
            }
            Texture::Step { base, threshold } => self.step(*base, *threshold),
            Texture::Transformed {
                uv_transform,
                inner,
            } => self.at_transformed(uv_transform, *inner).value(),
            Texture::Solid(solid) => match &solid.pattern {
                Pattern::Cells { color0, color1 } => {
                    let p = self.positions();
                    let is_even = self.mask(|i| solid.is_even_cell(p.as_ref()[i]));
                    self.choose_value(is_even, color0, color1)
                }
                _ => {
                    let p = self.positions();
                    Float::from_fn(s, |i| solid.value(p.as_ref()[i]))
                }
            },
            Texture::Projected { projection, inner } => {
                let p = self.positions();
                let uv = Pair::from_fn(s, |i| projection.uv(p.as_ref()[i]));
                self.of(&self.textures[inner.index()]).with_uv(uv).value()
            }
        }
    }

    #[inline(always)]
    fn gradient_inlined(&self, dp: [Vector<S>; 2]) -> Pair<S> {
        let s = self.width();
        match self.texture {
            Texture::Bitmap(bitmap) => bitmap.gradient(self.at.uv),
            Texture::Checkerboard { .. }
            | Texture::VertexColors(_)
            | Texture::OtherUv { .. }
            | Texture::Dots { .. }
            | Texture::Step { .. } => self.flat(),
            Texture::Product { first, second } => {
                self.gradient_of(first, dp) * self.value_of(second)
                    + self.gradient_of(second, dp) * self.value_of(first)
            }
            Texture::Mix {
                first,
                second,
                weight,
            } => {
                let w = self.mixing_weight(weight);
                let slope = match weight {
                    FloatInput::Constant(_) => self.flat(),
                    FloatInput::Texture(id) => self.of(&self.textures[id.index()]).gradient(dp),
                };
                let step = self.value_of(second) - self.value_of(first);
                self.gradient_of(first, dp) * (1.0 - w)
                    + self.gradient_of(second, dp) * w
                    + slope * step
            }
            Texture::Power { base, exponent } => {
                let base = self.of(&self.textures[base.index()]);
                let slope = power(base.value(), exponent - 1.0) * *exponent;
                base.gradient(dp) * slope.is_finite().select(slope, 0.0)
            }
            Texture::Transformed {
                uv_transform: m,
                inner,
            } => {
                let g = self.at_transformed(m, *inner).gradient(dp);
                Pair::new(
                    g.x * m.x_axis.x + g.y * m.x_axis.y,
                    g.x * m.y_axis.x + g.y * m.y_axis.y,
                )
            }
            Texture::Solid(solid) => {
                let (p, du, dv) = (self.positions(), each_vector(dp[0]), each_vector(dp[1]));
                Pair::from_fn(s, |i| {
                    solid.gradient(p.as_ref()[i], [du.as_ref()[i], dv.as_ref()[i]])
                })
            }
            Texture::Projected { projection, inner } => {
                let (p, du, dv) = (self.positions(), each_vector(dp[0]), each_vector(dp[1]));
                let uv = Pair::from_fn(s, |i| projection.uv(p.as_ref()[i]));
                let derivatives = s.each(|i| {
                    projection.derivatives(p.as_ref()[i], [du.as_ref()[i], dv.as_ref()[i]])
                });
                let along = |k: usize| Pair::from_fn(s, |i| derivatives.as_ref()[i][k]);
                let inner = self.of(&self.textures[inner.index()]).with_uv(uv);
                let gradient = inner.gradient(dp);
                Pair::new(gradient.dot(along(0)), gradient.dot(along(1)))
            }
        }
    }
}

/// A power of the positive part.
#[inline(always)]
fn power<S: Width>(base: Float<S>, exponent: f32) -> Float<S> {
    let base_of = base.max(0.0).store();
    Float::from_fn(base.width(), |i| base_of.as_ref()[i].powf(exponent))
}

/// The lanes with coordinates in a cell of `color0`.
#[inline(always)]
fn is_main_cell<S: Width>(p: Pair<S>) -> Mask<S> {
    let (u, v) = (is_upper(p.x), is_upper(p.y));
    (u & v) | !(u | v)
}

/// The lanes with a fraction above 1/2.
#[inline(always)]
fn is_upper<S: Width>(x: Float<S>) -> Mask<S> {
    /// Largest coordinate; larger ones are clamped. From 2²² ≈ 4.2e6 on, `f32` resolves half cells
    /// at best, and [`Float::floor`] is not defined.
    const FARTHEST: f32 = 4e6;
    let x = x.clamp(-FARTHEST, FARTHEST);
    (x - x.floor()).gt(0.5)
}
