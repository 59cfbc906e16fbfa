//! Textures in lanes: against single places, in all instruction sets.

use super::*;
use crate::color::Rgb;
use crate::geometry::{SurfacePoints, SurfaceRef};
use crate::ids::PrimitiveId;
use crate::ids::TextureId;
use crate::image::Image;
use crate::lanes::{Axes, Color, Float, Pair, Vector, Width};
use crate::math::{Affine3A, Frame, Mat3, Vec2, Vec3};
use crate::sampling::rng::Pcg;
use crate::simd::{Instructions, Isa, Simd, SimdKernel};

/// Values of a texture in lanes: color, value, gradient.
struct Values<'a> {
    texture: TextureId,
    textures: &'a [Texture],
    places: &'a [TexturePoint; 16],
    dp: [Vec3; 2],
}

impl SimdKernel for Values<'_> {
    type Output = [(Rgb, f32, Vec2); 16];

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> [(Rgb, f32, Vec2); 16] {
        let s = s.wide();
        let places = self.places;
        let x = SurfacePoints {
            p: Vector::from_fn(s, |i| places[i].p),
            ng: Vector::splat(s, Vec3::Z),
            frame: Axes::splat(s, &Frame::from_normal(Vec3::Z)),
            uv: Pair::from_fn(s, |i| places[i].uv),
            dp_du: Vector::splat(s, self.dp[0]),
            dp_dv: Vector::splat(s, self.dp[1]),
            offset: Float::splat(s, 0.0),
            at: s.each(|i| SurfaceRef {
                primitive: PrimitiveId(3),
                element: places[i].element,
                instance: SurfaceRef::NO_INSTANCE,
                coordinates: places[i].coordinates,
            }),
        };
        let color: Color<_> = ColorInput::Texture(self.texture).eval_each(&x, self.textures);
        let value = FloatInput::Texture(self.texture).eval_each(&x, self.textures);
        let gradient = self.textures[self.texture.index()].gradient_each(&x, self.textures);
        let (color, value) = (color.store(), value.store());
        let (du, dv) = (gradient.x.store(), gradient.y.store());
        std::array::from_fn(|i| {
            let color = Rgb::new(color[0][i], color[1][i], color[2][i]);
            (color, value[i], Vec2::new(du[i], dv[i]))
        })
    }
}

fn image(random: &mut Pcg, width: usize, height: usize, channels: usize) -> Image {
    let count = width * height * channels;
    Image {
        width,
        height,
        channels,
        data: (0..count).map(|_| random.next_f32()).collect(),
    }
}

/// Bitmaps of all formats, filterings and wrap modes, then all other textures over them.
fn all_textures() -> Vec<Texture> {
    let random = &mut Pcg::new(4);
    let mut textures = Vec::new();
    let transform = Mat3::from_cols_array(&[1.5, -0.4, 0.0, 0.3, 2.1, 0.0, 0.2, 0.7, 1.0]);
    let wraps = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];
    for filtering in [Filtering::Bilinear, Filtering::Nearest] {
        for channels in 1..=4 {
            for (i, wrap) in wraps.into_iter().enumerate() {
                let size = [(7, 5), (1, 1), (64, 3)][(i + channels) % 3];
                textures.push(Texture::Bitmap(Bitmap {
                    image: image(random, size.0, size.1, channels),
                    filtering,
                    wrap: [wrap, wraps[(i + channels) % 3]],
                    uv_transform: [Mat3::IDENTITY, transform][channels % 2],
                }));
            }
        }
    }
    let bitmap = |i: usize| ColorInput::Texture(TextureId::from(i));
    let (picture, other) = (bitmap(6), bitmap(2));
    let white = ColorInput::Constant(Rgb::new(0.2, 0.9, 1.0));
    let triangles = vec![[0, 1, 2], [2, 1, 3]];
    let colors = [0.1, 0.4, 0.9, 0.2].map(|v| Rgb::new(v, 1.0 - v, 0.3));
    let uvs = [(0.1, 0.2), (0.9, 0.1), (0.2, 1.3), (-0.8, 0.5)].map(Vec2::from);
    let cell = |color0, color1| Texture::Checkerboard {
        color0,
        color1,
        uv_transform: transform,
    };
    let solid = |pattern| {
        Texture::Solid(Solid {
            pattern_from_world: Affine3A::from_scale(Vec3::new(2.0, 1.0, 0.5)),
            pattern,
        })
    };
    let projected = |kind| Texture::Projected {
        projection: Projection {
            from_world: Affine3A::from_scale(Vec3::splat(0.4)),
            kind,
        },
        inner: TextureId::from(7),
    };
    textures.extend([
        cell(picture, other),
        cell(white, picture),
        Texture::Product {
            first: picture,
            second: other,
        },
        Texture::Mix {
            first: picture,
            second: white,
            weight: FloatInput::Texture(TextureId::from(0)),
        },
        Texture::VertexColors(VertexValues {
            triangles: triangles.clone(),
            values: colors.to_vec(),
        }),
        Texture::OtherUv {
            uvs: VertexValues {
                triangles,
                values: uvs.to_vec(),
            },
            inner: TextureId::from(6),
        },
        Texture::Dots {
            inside: picture,
            outside: white,
            uv_transform: transform,
        },
        Texture::Power {
            base: TextureId::from(6),
            exponent: 0.7,
        },
        Texture::Transformed {
            uv_transform: transform,
            inner: TextureId::from(6),
        },
        Texture::Step {
            base: TextureId::from(6),
            threshold: 0.4,
        },
        solid(Pattern::Cells {
            color0: white,
            color1: picture,
        }),
        solid(Pattern::Windy),
        solid(Pattern::Marble {
            octaves: 4,
            roughness: 0.5,
            variation: 0.2,
        }),
        projected(ProjectionKind::Spherical),
        projected(ProjectionKind::Cylindrical),
        projected(ProjectionKind::Planar {
            axes: [Vec3::new(0.7, 0.1, 0.0), Vec3::new(0.0, 0.3, 0.9)],
            offset: Vec2::new(0.1, 0.2),
        }),
    ]);
    textures
}

fn places(random: &mut Pcg) -> [TexturePoint; 16] {
    std::array::from_fn(|_| {
        let mut number = || random.next_f32();
        TexturePoint {
            uv: Vec2::new(number() * 4.0 - 1.5, number() * 4.0 - 1.5),
            p: Vec3::new(number(), number(), number()) * 3.0 + 0.2,
            element: (number() * 2.0) as u32,
            coordinates: Vec2::new(number() * 0.5, number() * 0.5),
        }
    })
}

/// Places at which a rounding in another order may choose other texels or cells are rare. This many
/// may differ.
const JUMPS: usize = 6;

#[test]
fn values_in_lanes_are_those_of_single_places() {
    let textures = all_textures();
    let dp = [Vec3::new(0.3, 1.0, -0.2), Vec3::new(-0.4, 0.2, 2.0)];
    let random = &mut Pcg::new(9);
    for set in Instructions::available() {
        let isa = Isa::new(set).expect("available");
        for (index, texture) in textures.iter().enumerate() {
            let mut jumps = 0;
            for _ in 0..50 {
                let places = places(random);
                let found = isa.run(Values {
                    texture: TextureId::from(index),
                    textures: &textures,
                    places: &places,
                    dp,
                });
                for ((color, value, gradient), place) in found.into_iter().zip(places) {
                    let expected = texture.eval(place, &textures);
                    let of_color = (color - expected).to_array().map(f32::abs);
                    let of_value = (value - texture.eval_float(place, &textures)).abs();
                    let slope = texture.gradient(place, dp, &textures);
                    let of_gradient = gradient.distance(slope) / slope.length().max(1.0);
                    let error = of_color.into_iter().fold(of_value, f32::max);
                    jumps += usize::from(!(error < 2e-5 && of_gradient < 2e-3));
                }
            }
            assert!(jumps <= JUMPS, "{jumps} of {index} in {set:?}");
        }
    }
}

/// Bilinear interpolation and wrapping by their definitions, in `f64`.
#[test]
fn bitmaps_follow_their_definition() {
    let random = &mut Pcg::new(1);
    for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
        for channels in [1, 3, 4] {
            let bitmap = Bitmap {
                image: image(random, 7, 5, channels),
                filtering: Filtering::Bilinear,
                wrap: [wrap; 2],
                uv_transform: Mat3::IDENTITY,
            };
            let index = |i: i64, n: i64| match wrap {
                Wrap::Repeat => i.rem_euclid(n),
                Wrap::Clamp => i.clamp(0, n - 1),
                Wrap::Mirror if i.div_euclid(n) % 2 == 0 => i.rem_euclid(n),
                Wrap::Mirror => n - 1 - i.rem_euclid(n),
            };
            let texel =
                |x: i64, y: i64| bitmap.image.rgb(index(x, 7) as usize, index(y, 5) as usize);
            let texture = Texture::Bitmap(bitmap.clone());
            for _ in 0..2000 {
                let uv = Vec2::new(random.next_f32(), random.next_f32()) * 8.0 - 4.0;
                let (x, y) = (f64::from(uv.x) * 7.0 - 0.5, f64::from(uv.y) * 5.0 - 0.5);
                let (left, above) = (x.floor(), y.floor());
                let mut expected = [0.0; 3];
                for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let wx = 1.0 - (left + f64::from(dx) - x).abs();
                    let wy = 1.0 - (above + f64::from(dy) - y).abs();
                    let color = texel(left as i64 + i64::from(dx), above as i64 + i64::from(dy));
                    for (sum, v) in expected.iter_mut().zip(color.to_array()) {
                        *sum += wx * wy * f64::from(v);
                    }
                }
                let found = texture.eval(uv, &[]).to_array();
                for (found, expected) in found.into_iter().zip(expected) {
                    assert!((f64::from(found) - expected).abs() < 1e-5, "{wrap:?} {uv}");
                }
            }
        }
    }
}
