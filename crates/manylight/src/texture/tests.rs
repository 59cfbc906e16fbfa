//! Values of Mitsuba 3.9.1's `bitmap` and `checkerboard` at the same coordinates.

use super::bounds::TextureBounds;
use super::*;
use crate::color::Rgb;
use crate::ids::TextureId;
use crate::image::Image;
use crate::math::{Affine3A, Mat3, Vec2, Vec3};

/// Three rows of four texels with the values 0 to 11.
fn ramp(filtering: Filtering, wrap: Wrap, uv_transform: Mat3) -> Texture {
    let image = Image {
        width: 4,
        height: 3,
        channels: 1,
        data: (0..12).map(|i| i as f32).collect(),
    };
    Texture::Bitmap(Bitmap {
        image,
        filtering,
        wrap: [wrap; 2],
        uv_transform,
    })
}

const POINTS: [(f32, f32); 6] = [
    (0.05, 0.03),
    (0.3, 0.6),
    (1.23, -0.41),
    (-2.62, 3.77),
    (0.97, 0.99),
    (1.0, 1.0),
];

/// Upper bound of the luminance over all uv.
fn max_luminance(texture: &Texture, textures: &[Texture]) -> f32 {
    TextureBounds::new(textures).luminance_of(texture)
}

#[test]
fn lookups_match_mitsuba() {
    use Filtering::{Bilinear, Nearest};
    let expected: [(Filtering, Wrap, [f32; 6]); 6] = [
        (Nearest, Wrap::Repeat, [0.0, 5.0, 4.0, 9.0, 11.0, 0.0]),
        (Nearest, Wrap::Mirror, [0.0, 5.0, 7.0, 2.0, 11.0, 11.0]),
        (Nearest, Wrap::Clamp, [0.0, 5.0, 3.0, 8.0, 11.0, 11.0]),
        (Bilinear, Wrap::Repeat, [4.18, 5.9, 5.5, 8.26, 6.1, 5.5]),
        (Bilinear, Wrap::Mirror, [0.0, 5.9, 5.5, 2.74, 11.0, 11.0]),
        (Bilinear, Wrap::Clamp, [0.0, 5.9, 3.0, 8.0, 11.0, 11.0]),
    ];
    for (filtering, wrap, values) in expected {
        let texture = ramp(filtering, wrap, Mat3::IDENTITY);
        for ((u, v), value) in POINTS.into_iter().zip(values) {
            let uv = Vec2::new(u, v);
            assert!(
                (texture.eval(uv, &[]).g - value).abs() < 1e-4,
                "{filtering:?} {wrap:?} {uv}"
            );
            assert!((texture.eval_float(uv, &[]) - value).abs() < 1e-4);
        }
    }
}

#[test]
fn gradients_match_mitsuba() {
    let expected: [(Wrap, [[f32; 2]; 6]); 3] = [
        (
            Wrap::Repeat,
            [
                [-12.0, -24.0],
                [4.0, 12.0],
                [4.0, 12.0],
                [4.0, 12.0],
                [-12.0, -24.0],
                [-12.0, -24.0],
            ],
        ),
        (
            Wrap::Mirror,
            [
                [0.0, 0.0],
                [4.0, 12.0],
                [-4.0, -12.0],
                [-4.0, -12.0],
                [0.0, 0.0],
                [0.0, 0.0],
            ],
        ),
        (
            Wrap::Clamp,
            [
                [0.0, 0.0],
                [4.0, 12.0],
                [0.0, 0.0],
                [0.0, 0.0],
                [0.0, 0.0],
                [0.0, 0.0],
            ],
        ),
    ];
    for (wrap, values) in expected {
        let texture = ramp(Filtering::Bilinear, wrap, Mat3::IDENTITY);
        for ((u, v), value) in POINTS.into_iter().zip(values) {
            let gradient = texture.gradient(Vec2::new(u, v), [Vec3::ZERO; 2], &[]);
            assert!(
                (gradient - Vec2::from(value)).length() < 1e-4,
                "{wrap:?} ({u}, {v}): {gradient}"
            );
        }
    }
    let nearest = ramp(Filtering::Nearest, Wrap::Repeat, Mat3::IDENTITY);
    assert_eq!(
        nearest.gradient(Vec2::new(0.3, 0.6), [Vec3::ZERO; 2], &[]),
        Vec2::ZERO
    );
}

#[test]
fn the_transform_acts_before_the_lookup_as_in_mitsuba() {
    // Rows (1.5, 0.3, 0.2) and (-0.4, 2.1, 0.7).
    let transform = Mat3::from_cols_array(&[1.5, -0.4, 0.0, 0.3, 2.1, 0.0, 0.2, 0.7, 1.0]);
    let texture = ramp(Filtering::Bilinear, Wrap::Repeat, transform);
    let expected = [
        ((0.3, 0.6), 10.66, [18.8, -49.5]),
        ((0.13, 0.41), 5.68, [-0.4, 26.1]),
    ];
    for ((u, v), value, gradient) in expected {
        let uv = Vec2::new(u, v);
        assert!((texture.eval_float(uv, &[]) - value).abs() < 1e-4);
        assert!(
            (texture.gradient(uv, [Vec3::ZERO; 2], &[]) - Vec2::from(gradient)).length() < 1e-3
        );
    }
}

#[test]
fn checkerboards_match_mitsuba() {
    let (color0, color1) = (Rgb::splat(0.1), Rgb::splat(0.9));
    let plain = Texture::Checkerboard {
        color0: ColorInput::Constant(color0),
        color1: ColorInput::Constant(color1),
        uv_transform: Mat3::IDENTITY,
    };
    for ((u, v), expected) in [
        ((0.1, 0.1), color0),
        ((0.6, 0.1), color1),
        ((0.1, 0.6), color1),
        ((0.5, 0.1), color0),
        ((0.6, 0.6), color0),
    ] {
        let uv = Vec2::new(u, v);
        assert_eq!(plain.eval(uv, &[]), expected);
        let swapped = color0 + color1 - expected;
        assert!((plain.eval_float(uv, &[]) - swapped.r).abs() < 1e-6);
    }
    let uv_transform =
        Mat3::from_translation(Vec2::new(0.2, 0.7)) * Mat3::from_scale(Vec2::new(2.0, 3.0));
    let moved = Texture::Checkerboard {
        color0: ColorInput::Constant(color0),
        color1: ColorInput::Constant(color1),
        uv_transform,
    };
    for ((u, v), expected) in [
        ((0.1, 0.1), color0),
        ((0.3, 0.1), color1),
        ((0.1, 0.3), color1),
        ((0.45, 0.35), color1),
    ] {
        assert_eq!(moved.eval(Vec2::new(u, v), &[]), expected);
    }
}

#[test]
fn nested_textures_match_mitsuba() {
    let scaled = |by: f32| Mat3::from_scale(Vec2::splat(by));
    let image = Image {
        width: 4,
        height: 4,
        channels: 3,
        data: (0..16)
            .flat_map(|i| [i as f32, 16.0, (i / 4 + i % 4 * 4) as f32].map(|v| v / 16.0))
            .collect(),
    };
    let picture = Texture::Bitmap(Bitmap {
        image,
        filtering: Filtering::Nearest,
        wrap: [Wrap::Repeat; 2],
        uv_transform: Mat3::IDENTITY,
    });
    let inner = Texture::Checkerboard {
        color0: ColorInput::Constant(Rgb::new(0.1, 0.2, 0.3)),
        color1: ColorInput::Constant(Rgb::splat(0.2)),
        uv_transform: scaled(8.0),
    };
    let outer = Texture::Checkerboard {
        color0: ColorInput::Texture(TextureId(0)),
        color1: ColorInput::Texture(TextureId(1)),
        uv_transform: scaled(2.0),
    };
    let textures = [picture, inner, outer.clone()];
    for ((u, v), color, value) in [
        ((0.1, 0.1), [0.0, 1.0, 0.0], 0.2),
        ((0.3, 0.1), [0.2, 0.2, 0.2], 0.746_494),
        ((0.7, 0.2), [0.125, 1.0, 0.5], 0.2),
        ((0.33, 0.05), [0.2, 0.2, 0.2], 0.746_494),
        ((0.9, 0.9), [0.9375, 1.0, 0.9375], 0.2),
    ] {
        let uv = Vec2::new(u, v);
        let found = outer.eval(uv, &textures).to_array();
        assert!(
            (0..3).all(|c| (found[c] - color[c]).abs() < 1e-6),
            "{uv}: {found:?}"
        );
        assert!(
            (outer.eval_float(uv, &textures) - value).abs() < 1e-5,
            "{uv}"
        );
    }
    assert!((max_luminance(&outer, &textures) - 0.982_19).abs() < 1e-4);
}

#[test]
fn extreme_coordinates_are_harmless() {
    for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
        let texture = ramp(Filtering::Bilinear, wrap, Mat3::IDENTITY);
        for c in [f32::NAN, f32::INFINITY, -1e30] {
            texture.eval(Vec2::splat(c), &[]);
            texture.gradient(Vec2::splat(c), [Vec3::ZERO; 2], &[]);
        }
    }
}

/// Values at the corners of two triangles over four vertices.
fn corners<T>(values: [T; 4]) -> VertexValues<T> {
    VertexValues {
        triangles: vec![[0, 1, 2], [2, 1, 3]],
        values: values.into(),
    }
}

fn in_triangle(element: u32, x: f32, y: f32) -> TexturePoint {
    TexturePoint {
        p: Vec3::ZERO,
        uv: Vec2::splat(9.0),
        element,
        coordinates: Vec2::new(x, y),
    }
}

#[test]
fn vertex_values_are_interpolated_over_their_triangles() {
    let gray = [0.0, 1.0, 2.0, 4.0].map(Rgb::splat);
    let colors = Texture::VertexColors(corners(gray));
    let value = |at: TexturePoint| colors.eval_float(at, &[]);
    assert!((value(in_triangle(0, 0.25, 0.5)) - 1.25).abs() < 1e-5);
    assert!((value(in_triangle(1, 0.0, 1.0)) - 4.0).abs() < 1e-5);
    assert_eq!(value(in_triangle(2, 0.0, 0.0)), 0.0);
    assert_eq!(max_luminance(&colors, &[]), 4.0 * Rgb::WHITE.luminance());

    let uvs = [(0.125, 0.5), (0.375, 0.5), (0.625, 0.5), (0.875, 0.5)].map(Vec2::from);
    let textures = [
        ramp(Filtering::Nearest, Wrap::Clamp, Mat3::IDENTITY),
        Texture::OtherUv {
            uvs: corners(uvs),
            inner: TextureId(0),
        },
    ];
    let found = [0.0, 1.0].map(|x| textures[1].eval_float(in_triangle(1, x, 0.0), &textures));
    assert_eq!(found, [6.0, 5.0]);
}

#[test]
fn products_multiply_their_factors() {
    let textures = [
        ramp(Filtering::Nearest, Wrap::Clamp, Mat3::IDENTITY),
        Texture::Product {
            first: ColorInput::Texture(TextureId(0)),
            second: ColorInput::Constant(Rgb::new(1.0, 0.5, 2.0)),
        },
    ];
    let uv = Vec2::new(0.3, 0.6);
    assert_eq!(textures[1].eval(uv, &textures), Rgb::new(5.0, 2.5, 10.0));
    let tint = Rgb::new(1.0, 0.5, 2.0).luminance();
    assert_eq!(textures[1].eval_float(uv, &textures), 5.0 * tint);
    assert!(max_luminance(&textures[1], &textures) >= 11.0 * tint);
}

#[test]
fn products_and_mixtures_follow_their_inputs() {
    let picture = ramp(Filtering::Bilinear, Wrap::Clamp, Mat3::IDENTITY);
    let bitmap = ColorInput::Texture(TextureId(0));
    let product = Texture::Product {
        first: bitmap,
        second: ColorInput::Constant(Rgb::new(0.5, 1.0, 2.0)),
    };
    let square = Texture::Product {
        first: bitmap,
        second: bitmap,
    };
    let mix = Texture::Mix {
        first: ColorInput::Constant(Rgb::WHITE),
        second: bitmap,
        weight: FloatInput::Constant(0.25),
    };
    let textures = [picture.clone()];
    for (u, v) in POINTS {
        let uv = Vec2::new(u, v);
        let value = picture.eval_float(uv, &[]);
        let color = product.eval(uv, &textures);
        assert_eq!(color, Rgb::new(0.5 * value, value, 2.0 * value));
        assert_eq!(square.eval_float(uv, &textures), value * value);
        assert!((mix.eval_float(uv, &textures) - (0.75 + 0.25 * value)).abs() < 1e-5);
        // Derivatives of f² and of the mixture.
        let slope = picture.gradient(uv, [Vec3::ZERO; 2], &[]);
        let of_square = square.gradient(uv, [Vec3::ZERO; 2], &textures);
        assert!(of_square.abs_diff_eq(slope * (2.0 * value), 1e-3), "{uv}");
        assert!(
            mix.gradient(uv, [Vec3::ZERO; 2], &textures)
                .abs_diff_eq(slope * 0.25, 1e-4)
        );
        for texture in [&product, &square, &mix] {
            let luminance = texture.eval(uv, &textures).luminance();
            assert!(luminance <= max_luminance(texture, &textures) * 1.0001);
        }
    }
    assert_eq!(mix.nested().collect::<Vec<_>>(), [TextureId(0)]);
    assert_eq!(square.nested().count(), 2);
}

/// A pattern in world space.
fn solid(pattern: Pattern) -> Texture {
    Texture::Solid(Solid {
        pattern_from_world: Affine3A::from_scale(Vec3::new(2.0, 1.0, 0.5)),
        pattern,
    })
}

fn at(p: Vec3) -> TexturePoint {
    TexturePoint {
        p,
        ..TexturePoint::default()
    }
}

const FRACTAL: Pattern = Pattern::Fractal {
    octaves: 4,
    roughness: 0.5,
};

#[test]
fn patterns_follow_the_position_in_their_space() {
    let (black, white) = (Rgb::BLACK, Rgb::WHITE);
    let cells = solid(Pattern::Cells {
        color0: ColorInput::Constant(black),
        color1: ColorInput::Constant(white),
    });
    assert_eq!(cells.eval(at(Vec3::new(0.2, 0.3, 0.4)), &[]), black);
    assert_eq!(cells.eval(at(Vec3::new(0.7, 0.3, 0.4)), &[]), white);
    assert_eq!(cells.eval(at(Vec3::new(0.7, -0.3, 0.4)), &[]), black);
    assert_eq!(cells.eval(at(Vec3::new(0.2, 0.3, 2.4)), &[]), white);
    // Colors are not negative, numbers may be.
    let fractal = solid(FRACTAL);
    let points = (0..500).map(|i| Vec3::new(0.31, -0.17, 0.57) * i as f32);
    let values: Vec<f32> = points
        .clone()
        .map(|p| fractal.eval_float(at(p), &[]))
        .collect();
    assert!(values.iter().any(|v| *v < -0.3) && values.iter().any(|v| *v > 0.3));
    let is_bounded = |texture: &Texture, p| {
        let color = texture.eval(at(p), &[]);
        color.to_array().iter().all(|v| *v >= 0.0)
            && color.luminance() <= max_luminance(texture, &[])
    };
    let marble = solid(Pattern::Marble {
        octaves: 8,
        roughness: 0.5,
        variation: 0.2,
    });
    let wrinkled = solid(Pattern::Wrinkled {
        octaves: 8,
        roughness: 0.5,
    });
    for texture in [&fractal, &marble, &wrinkled, &solid(Pattern::Windy)] {
        assert!(points.clone().all(|p| is_bounded(texture, p)));
    }
    // At a phase of -π/2, marble has its first color.
    let plain = solid(Pattern::Marble {
        octaves: 0,
        roughness: 0.5,
        variation: 0.2,
    });
    let first = plain.eval(at(Vec3::Y * -std::f32::consts::FRAC_PI_2), &[]);
    assert!(
        (first - Rgb::new(0.58, 0.58, 0.6) * 1.5)
            .to_array()
            .iter()
            .all(|d| d.abs() < 1e-5)
    );
}

#[test]
fn gradients_of_patterns_are_slopes_along_the_surface() {
    let dp = [Vec3::new(0.3, 1.0, -0.2), Vec3::new(-0.4, 0.2, 2.0)];
    let image = ramp(Filtering::Bilinear, Wrap::Clamp, Mat3::IDENTITY);
    let projected = |kind| Texture::Projected {
        projection: Projection {
            from_world: Affine3A::from_scale(Vec3::splat(0.4)),
            kind,
        },
        inner: TextureId::from(0),
    };
    let planar = ProjectionKind::Planar {
        axes: [Vec3::new(0.7, 0.1, 0.0), Vec3::new(0.0, 0.3, 0.9)],
        offset: Vec2::new(0.1, 0.2),
    };
    let textures = [
        solid(FRACTAL),
        solid(Pattern::Windy),
        projected(planar),
        projected(ProjectionKind::Spherical),
        projected(ProjectionKind::Cylindrical),
    ];
    let p = Vec3::new(0.71, 0.53, 0.62);
    let nested = [image];
    for texture in textures {
        let found = texture.gradient(at(p), dp, &nested);
        let value = |d: Vec3| texture.eval_float(at(p + d), &nested);
        let slope = |d: Vec3| (value(d * 1e-3) - value(d * -1e-3)) / 2e-3;
        let expected = Vec2::from(dp.map(slope));
        let tolerance = 0.02 * expected.length() + 0.01;
        assert!(
            found.distance(expected) < tolerance,
            "{found} for {expected}: {texture:?}"
        );
    }
}

#[test]
fn projections_have_the_coordinates_of_pbrt() {
    let uv = |kind, p| {
        let from_world = Affine3A::IDENTITY;
        Projection { from_world, kind }.uv(p)
    };
    let close = |a: Vec2, b: Vec2| assert!(a.distance(b) < 1e-5, "{a} for {b}");
    close(uv(ProjectionKind::Spherical, Vec3::X), Vec2::new(0.5, 0.0));
    close(
        uv(ProjectionKind::Spherical, Vec3::new(0.0, -1.0, -1.0)),
        Vec2::new(0.75, 0.75),
    );
    close(
        uv(ProjectionKind::Cylindrical, Vec3::new(0.0, 2.0, 0.3)),
        Vec2::new(0.75, 0.3),
    );
}

/// About half of the cells have a dot, each with the area of its disc.
#[test]
fn dots_cover_a_fifth_of_the_plane() {
    let dots = Texture::Dots {
        inside: ColorInput::Constant(Rgb::WHITE),
        outside: ColorInput::Constant(Rgb::BLACK),
        uv_transform: Mat3::from_diagonal(Vec3::new(100.0, 100.0, 1.0)),
    };
    let steps = 500;
    let points = (0..steps * steps).map(|i| Vec2::new((i % steps) as f32, (i / steps) as f32));
    let covered = points
        .map(|p| dots.eval((p + 0.5) / steps as f32, &[]).r)
        .sum::<f32>();
    let share = covered / (steps * steps) as f32;
    let disc = std::f32::consts::PI * 0.35 * 0.35;
    assert!((0.35..0.65).contains(&(share / disc)), "{share}");
}

#[test]
fn powers_are_of_the_values_after_filtering() {
    let root = Texture::Power {
        base: TextureId::from(0),
        exponent: 0.5,
    };
    let textures = [ramp(Filtering::Bilinear, Wrap::Clamp, Mat3::IDENTITY)];
    let uv = Vec2::new(0.3, 0.6);
    let value = textures[0].eval_float(uv, &[]);
    assert!((root.eval_float(uv, &textures) - value.sqrt()).abs() < 1e-6);
    let slope = textures[0].gradient(uv, [Vec3::ZERO; 2], &[]) * 0.5 / value.sqrt();
    let found = root.gradient(uv, [Vec3::ZERO; 2], &textures);
    assert!(found.distance(slope) < 1e-5, "{found} for {slope}");
    assert!((max_luminance(&root, &textures) - 11f32.sqrt()).abs() < 1e-5);
}
