//! Spots and projector textures against Mitsuba 3.9.1, and the falloff of Blender.

use super::*;
use crate::emitters::elements::point_power;
use crate::texture::TextureBounds;

#[test]
fn spots_match_mitsuba_and_blender() {
    use SpotFalloff::{LinearAngle, QuarticCosine, SmoothCosine};
    let degrees = [0.0f32, 5.0, 12.0, 16.0, 19.9, 25.0, 29.0, 31.0];
    let cases = [
        (
            LinearAngle,
            20.0f32,
            15.0f32,
            [2.0, 2.0, 2.0, 1.6, 0.04, 0.0, 0.0, 0.0],
        ),
        (
            LinearAngle,
            30.0,
            10.0,
            [2.0, 2.0, 1.8, 1.4, 1.01, 0.5, 0.1, 0.0],
        ),
        (
            LinearAngle,
            30.0,
            30.0,
            [2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 0.0],
        ),
        // By hand, from the formula.
        (
            SmoothCosine,
            30.0,
            10.0,
            [2.0, 2.0, 1.9818, 1.7954, 1.3677, 0.534, 0.0299, 0.0],
        ),
        (
            QuarticCosine,
            30.0,
            10.0,
            [2.0, 2.0, 1.5878, 0.8265, 0.3056, 0.0265, 0.0001, 0.0],
        ),
    ];
    for (falloff, cutoff, beam_width, values) in cases {
        let spot = Emitter::Spot {
            position: Vec3::ZERO,
            direction: Vec3::Z,
            intensity: Rgb::splat(2.0),
            cutoff: cutoff.to_radians(),
            beam_width: beam_width.to_radians(),
            falloff,
            projector: None,
        };
        let intensity = |angle: f32| {
            spot.point_intensity(&[], Vec3::new(angle.sin(), 0.0, angle.cos()))
                .r
        };
        for (angle, value) in degrees.into_iter().zip(values) {
            assert!(
                (intensity(angle.to_radians()) - value).abs() < 1e-3,
                "{cutoff} {beam_width} at {angle}"
            );
        }
        let n = 20_000;
        let step = PI / n as f32;
        let power: f64 = (0..n)
            .map(|i| (i as f32 + 0.5) * step)
            .map(|angle| f64::from(intensity(angle) * angle.sin() * 2.0 * PI * step))
            .sum();
        assert!(
            (f64::from(point_power(&spot, &TextureBounds::new(&[])).g) / power - 1.0).abs() < 1e-3
        );
    }
}

#[test]
fn projector_textures_match_mitsuba() {
    let image = Image {
        width: 4,
        height: 4,
        channels: 3,
        data: (0..16)
            .map(|i| {
                (
                    i as f32 / 16.0 + 0.05,
                    (i / 4 + i % 4 * 4) as f32 / 16.0 + 0.05,
                )
            })
            .flat_map(|(r, b)| [r, 1.0, b])
            .collect(),
    };
    let picture = Texture::Bitmap(Bitmap {
        image,
        filtering: Filtering::Nearest,
        wrap: [Wrap::Repeat; 2],
        uv_transform: Mat3::IDENTITY,
    });
    let spot = Emitter::Spot {
        position: Vec3::new(1.0, 2.0, 3.0),
        direction: Vec3::Z,
        intensity: Rgb::new(1.0, 2.0, 3.0),
        cutoff: 30f32.to_radians(),
        beam_width: 20f32.to_radians(),
        falloff: SpotFalloff::LinearAngle,
        projector: Some(projector()),
    };
    for (w, expected) in [
        ([0.1, 0.05], [0.675, 2.0, 2.025]),
        ([-0.2, 0.3], [0.8625, 2.0, 1.4625]),
        ([0.3, -0.3], [0.166_493, 1.402_048, 1.682_457]),
        ([-0.5, 0.0], [0.188_923, 0.686_993, 0.180_336]),
    ] {
        let w = Vec2::from(w).extend(1.0).normalize();
        let found = spot
            .point_intensity(std::slice::from_ref(&picture), w)
            .to_array();
        assert!(
            (0..3).all(|c| (found[c] - expected[c]).abs() < 1e-4),
            "{w}: {found:?}"
        );
    }
}

/// A map with the values of 1 + d.z in four rows and 1 to 8 in columns.
#[test]
fn goniometric_points_look_up_directions_in_their_frame() {
    let (width, height) = (8, 4);
    let value = |i: usize| {
        let theta = (i / width) as f32 + 0.5;
        1.0 + (theta / height as f32 * PI).cos() + (i % width) as f32
    };
    let map = Texture::Bitmap(Bitmap {
        image: Image {
            width,
            height,
            channels: 1,
            data: (0..width * height).map(value).collect(),
        },
        filtering: Filtering::Nearest,
        wrap: [Wrap::Repeat, Wrap::Clamp],
        uv_transform: Mat3::IDENTITY,
    });
    // The frame of the map has its z axis along y of the world.
    let emitter_from_world = Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::Y);
    let point = Emitter::Goniometric {
        position: Vec3::ZERO,
        intensity: Rgb::new(1.0, 2.0, 3.0),
        emitter_from_world,
        distribution: TextureId::from(0),
    };
    let maps = std::slice::from_ref(&map);
    for (row, column) in [(0, 0), (1, 3), (2, 7), (3, 5)] {
        let theta = (row as f32 + 0.4) / height as f32 * PI;
        let phi = (column as f32 + 0.7) / width as f32 * 2.0 * PI;
        let d = Vec3::new(
            theta.sin() * phi.cos(),
            theta.sin() * phi.sin(),
            theta.cos(),
        );
        let found = point.point_intensity(maps, emitter_from_world.transpose() * d);
        let expected = Rgb::new(1.0, 2.0, 3.0) * value(row * width + column);
        assert_eq!(found, expected, "{row} {column}");
    }
    // ∫ (1 + cosθ + column) dω, with the cosines of the rows' centers.
    let solid_angle = |row: usize| {
        let cos = |k: usize| (k as f32 / height as f32 * PI).cos();
        (cos(row) - cos(row + 1)) * 2.0 * PI / width as f32
    };
    let power: f32 = (0..width * height)
        .map(|i| value(i) * solid_angle(i / width))
        .sum();
    let found = point_power(&point, &TextureBounds::new(maps)).r;
    assert!((found / power - 1.0).abs() < 0.01, "{found} for {power}");
}

#[test]
fn the_window_of_a_projector_limits_its_light_and_gives_equal_irradiance() {
    let halves = Texture::Checkerboard {
        color0: ColorInput::Constant(Rgb::WHITE),
        color1: ColorInput::Constant(Rgb::splat(0.25)),
        uv_transform: Mat3::from_diagonal(Vec3::new(1.0, 1e-3, 1.0)),
    };
    let half = Vec2::new(0.8, 0.3);
    let spot = Emitter::Spot {
        position: Vec3::ZERO,
        direction: Vec3::Z,
        intensity: Rgb::splat(2.0),
        cutoff: half.length().atan(),
        beam_width: 0.1,
        falloff: SpotFalloff::FlatIrradiance,
        projector: Some(ProjectorTexture {
            window: Some(half),
            ..projector()
        }),
    };
    let textures = [halves];
    // Irradiance on the plane at distance 1: intensity cos³.
    for (x, y, irradiance) in [
        (-0.79, 0.0, 2.0),
        (-0.1, 0.29, 2.0),
        (0.1, -0.29, 0.5),
        (0.79, 0.29, 0.5),
        (0.81, 0.0, 0.0),
        (0.0, 0.31, 0.0),
    ] {
        let w = Vec3::new(x, y, 1.0).normalize();
        let found = spot.point_intensity(&textures, w).g * w.z.powi(3);
        assert!((found - irradiance).abs() < 1e-4, "{x} {y}: {found}");
    }
    assert!(spot.point_intensity(&textures, -Vec3::Z).is_black());
    let power = 4.0 * half.x * half.y * 0.5 * (2.0 + 0.5);
    assert!((point_power(&spot, &TextureBounds::new(&textures)).g / power - 1.0).abs() < 0.05);
}
