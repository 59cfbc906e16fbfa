//! Samplers against their densities, and values of Mitsuba 3.9.1.

use super::distant::{BoundingSphere, Distant, EmissionPoint};
use super::environment::EnvironmentSampler;
use super::light_tree::LightTree;
use super::parts::PartBounds;
use super::*;
use crate::image::Image;
use crate::math::{Cone, Mat3, octahedral};

fn picture() -> Image {
    let data = (0..72).map(|i| ((i * 37) % 64) as f32 / 64.0).collect();
    Image {
        width: 6,
        height: 4,
        channels: 3,
        data,
    }
}

/// 50 degrees around (1, 2, 3).
fn rotation() -> Mat3 {
    Mat3::from_axis_angle(Vec3::new(1.0, 2.0, 3.0).normalize(), 50f32.to_radians())
}

/// Compares frequencies over cells of the sphere with the integral of the density: Pearson's statistic over cells with at
/// least ten expected samples must stay within six deviations of its mean.
fn check_directions(
    n: usize,
    mut sample: impl FnMut(Vec2) -> Option<Vec3>,
    pdf: impl Fn(Vec3) -> f32,
) {
    const SIDE: usize = 12;
    const SUB: usize = 24;
    let cell = |w: Vec3| {
        let q = octahedral::square_from_direction(w) * SIDE as f32;
        (q.y as usize).min(SIDE - 1) * SIDE + (q.x as usize).min(SIDE - 1)
    };
    let mut observed = vec![0.0f64; SIDE * SIDE];
    let mut sampler = Sampler::new(3, 0, Stream::Test, 0);
    for _ in 0..n {
        if let Some(w) = sample(sampler.next_2d()) {
            assert!((w.length() - 1.0).abs() < 1e-4);
            observed[cell(w)] += 1.0;
        }
    }
    let mut expected = vec![0.0f64; SIDE * SIDE];
    let side = SIDE * SUB;
    for i in 0..side * side {
        let uv = Vec2::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5) / side as f32;
        let w = octahedral::direction_from_square(uv);
        let share = f64::from(octahedral::solid_angle_density(uv)) / (side * side) as f64;
        expected[cell(w)] += f64::from(pdf(w)) * share * n as f64;
    }
    let (mut chi2, mut cells) = (0.0, 0.0f64);
    for (o, e) in observed.iter().zip(&expected) {
        if *e >= 10.0 {
            chi2 += (o - e).powi(2) / e;
            cells += 1.0;
        } else {
            assert!(
                *o <= e + 6.0 * e.sqrt() + 6.0,
                "{o} samples where {e} are expected"
            );
        }
    }
    assert!(cells > 3.0, "the density is spread over cells");
    let deviation = (chi2 - cells) / (2.0 * cells).sqrt();
    assert!(deviation < 6.0, "chi² {chi2} over {cells} cells");
}

#[test]
fn environment_lookups_match_mitsuba() {
    let mut environment = Environment {
        image: picture(),
        scale: 1.5,
        world_from_emitter: Mat3::IDENTITY,
    };
    let upright = [
        (
            [0.618984, -0.7751, 0.126804],
            [0.954825, 0.511041, 0.769253],
        ),
        (
            [-0.749577, -0.597593, -0.284634],
            [0.945529, 0.422132, 1.121876],
        ),
        (
            [-0.914149, -0.104961, -0.391554],
            [0.727529, 0.694093, 0.961904],
        ),
        (
            [-0.587884, 0.724993, -0.358857],
            [0.551554, 1.007036, 0.589688],
        ),
        ([0.0, 1.0, 0.0], [0.503906, 0.621094, 0.738281]),
        ([0.0001, 0.0, -1.0], [0.668016, 0.785203, 0.902391]),
    ];
    let rotated = [
        (
            [-0.090628, 0.267923, 0.959168],
            [0.951603, 0.438022, 0.840337],
        ),
        (
            [-0.252895, -0.22845, 0.940136],
            [0.71637, 0.560864, 0.950745],
        ),
        ([0.651207, 0.10269, 0.75192], [0.747354, 0.894906, 0.445967]),
        ([0.0, 1.0, 0.0], [0.476208, 0.923307, 0.710583]),
    ];
    let check = |environment: &Environment, cases: &[([f32; 3], [f32; 3])]| {
        for &(w, value) in cases {
            let difference = environment.radiance(Vec3::from(w)) - Rgb::from(value);
            assert!(
                difference.map(f32::abs).max_channel() < 1e-4,
                "at {w:?}: off by {difference:?}"
            );
        }
    };
    check(&environment, &upright);
    environment.world_from_emitter = rotation();
    check(&environment, &rotated);
}

#[test]
fn environment_samples_follow_their_density() {
    let environment = Environment {
        image: picture(),
        scale: 1.5,
        world_from_emitter: rotation(),
    };
    let sampler = EnvironmentSampler::new(&environment).unwrap();
    check_directions(
        200_000,
        |u| Some(sampler.sample(&environment, u)),
        |w| sampler.pdf(&environment, w),
    );
}

#[test]
fn a_small_sun_is_sampled_well() {
    let mut image = Image::new(64, 32, 3);
    image.data.fill(0.1);
    image.data[(9 * 64 + 20) * 3..][..3].fill(2e4);
    let environment = Environment {
        image,
        scale: 1.0,
        world_from_emitter: rotation(),
    };
    let sampler = EnvironmentSampler::new(&environment).unwrap();
    let mut numbers = Sampler::new(5, 0, Stream::Test, 0);
    let total = sampler.total().g;
    for _ in 0..5000 {
        let wi = sampler.sample(&environment, numbers.next_2d());
        let weight = environment.radiance(wi).g / sampler.pdf(&environment, wi);
        assert!(
            (0.6..1.5).contains(&(weight / total)),
            "weight {weight} for {total}"
        );
    }
}

#[test]
fn pictures_without_extent_or_light_are_harmless() {
    for (width, height) in [(1, 1), (1, 5), (5, 1), (4, 2)] {
        let mut image = Image::new(width, height, 3);
        let black = Environment {
            image: image.clone(),
            scale: 1.0,
            world_from_emitter: Mat3::IDENTITY,
        };
        assert!(EnvironmentSampler::new(&black).is_none());
        image.data.fill(2.0);
        let bright = Environment {
            image,
            scale: 1.0,
            world_from_emitter: Mat3::IDENTITY,
        };
        let sampler = EnvironmentSampler::new(&bright).unwrap();
        assert!((sampler.total().r - 8.0 * PI).abs() < 1e-3);
        check_directions(
            20_000,
            |u| Some(sampler.sample(&bright, u)),
            |w| sampler.pdf(&bright, w),
        );
    }
}

fn sphere() -> BoundingSphere {
    BoundingSphere::new(Aabb {
        min: Vec3::new(-1.0, 0.0, 2.0),
        max: Vec3::new(2.0, 1.0, 4.0),
    })
}

fn distant_emitters() -> Vec<Emitter> {
    vec![
        Emitter::Constant {
            radiance: Rgb::new(0.2, 0.3, 0.1),
        },
        Emitter::Directional {
            direction: Vec3::new(0.3, -0.8, 0.1).normalize(),
            irradiance: Rgb::splat(2.0),
        },
        Emitter::Environment(Environment {
            image: picture(),
            scale: 1.5,
            world_from_emitter: rotation(),
        }),
    ]
}

#[test]
fn distant_directions_follow_their_density() {
    let emitters = distant_emitters();
    let distant = Distant::new(&emitters, sphere());
    for n in [None, Some(Vec3::new(0.2, 0.9, -0.3).normalize())] {
        let mut choice = Sampler::new(4, 0, Stream::Test, 1);
        check_directions(
            200_000,
            |u| {
                let sample = distant.sample(&emitters, n, choice.next_1d(), u);
                sample.parallel.is_none().then_some(sample.wi)
            },
            |w| distant.pdf(&emitters, n, w),
        );
    }
}

#[test]
fn distant_emission_crosses_the_sphere_evenly() {
    let emitters = distant_emitters();
    let distant = Distant::new(&emitters, sphere());
    let BoundingSphere { center, radius } = sphere();
    let mut numbers = Sampler::new(6, 0, Stream::Test, 0);
    for (emitter, power) in distant.powers() {
        let n = 40_000;
        let (mut flux, mut inner) = (0.0f64, 0.0f64);
        for _ in 0..n {
            let u = EmissionPoint {
                position: numbers.next_2d(),
                direction: numbers.next_2d(),
                guide: 0.5,
            };
            let (ray, sample_flux) = distant.emit(&emitters, emitter, u).unwrap();
            let to_center = center - ray.o;
            let along = to_center.dot(ray.d);
            let miss = (to_center - ray.d * along).length();
            assert!(along > 0.0 && to_center.length() > 0.999 * radius && miss < 1.001 * radius);
            flux += f64::from(sample_flux.g) / f64::from(n);
            inner += f64::from(u8::from(miss < 0.5 * radius)) / f64::from(n);
        }
        assert!(
            (flux / f64::from(power.g) - 1.0).abs() < 0.02,
            "{emitter:?}: {flux} for {power:?}"
        );
        assert!((inner - 0.25).abs() < 0.015, "{emitter:?}: {inner}");
    }
}

#[test]
fn bounding_spheres_never_vanish() {
    for bounds in [
        Aabb::EMPTY,
        Aabb::from_points([Vec3::ZERO]),
        Aabb::from_points([Vec3::splat(1e4)]),
    ] {
        assert!(BoundingSphere::new(bounds).radius > 0.0);
    }
}

#[test]
fn spots_match_mitsuba() {
    let degrees = [0.0f32, 5.0, 12.0, 16.0, 19.9, 25.0, 29.0, 31.0];
    let cases = [
        (20.0f32, 15.0f32, [2.0, 2.0, 2.0, 1.6, 0.04, 0.0, 0.0, 0.0]),
        (30.0, 10.0, [2.0, 2.0, 1.8, 1.4, 1.01, 0.5, 0.1, 0.0]),
        (30.0, 30.0, [2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 0.0]),
    ];
    for (cutoff, beam_width, values) in cases {
        let spot = Emitter::Spot {
            position: Vec3::ZERO,
            direction: Vec3::Z,
            intensity: Rgb::splat(2.0),
            cutoff: cutoff.to_radians(),
            beam_width: beam_width.to_radians(),
        };
        let intensity =
            |angle: f32| point_intensity(&spot, Vec3::new(angle.sin(), 0.0, angle.cos())).r;
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
        assert!((f64::from(point_power(&spot).g) / power - 1.0).abs() < 1e-3);
    }
}

/// Small facets of unit strength scattered over a plate, some shining up, some down, and a few points.
fn facets(count: usize) -> Vec<PartBounds> {
    let mut sampler = Sampler::new(7, 0, Stream::Test, 0);
    (0..count)
        .map(|i| {
            let at = sampler.next_2d() * 20.0 - Vec2::splat(10.0);
            let p = at.extend(sampler.next_1d());
            let normals = match i % 7 {
                0 => Cone::FULL,
                1 => Cone {
                    axis: -Vec3::Z,
                    half_angle: 0.4,
                },
                _ => Cone::from_axis((Vec3::Z + warp::sphere(sampler.next_2d()) * 0.5).normalize()),
            };
            PartBounds {
                bounds: Aabb {
                    min: p - Vec3::splat(0.02),
                    max: p + Vec3::splat(0.02),
                },
                normals,
                emission: if i % 7 == 0 { 0.0 } else { PI * 0.5 },
                power: Rgb::splat(0.1 + sampler.next_1d()),
            }
        })
        .collect()
}

/// What the center of a facet sends to `p`, up to a constant.
fn arriving(part: &PartBounds, p: Vec3, n: Vec3) -> f32 {
    let d = p - part.bounds.center();
    let cos = (part.normals.angle_to_axis(d.normalize()) - part.normals.half_angle)
        .max(0.0)
        .cos()
        .max(0.0);
    part.power.r * cos * (-n.dot(d.normalize())).max(0.0) / d.length_squared()
}

#[test]
fn tree_probabilities_match_frequencies() {
    for count in [1, 2, 3, 5, 40] {
        let parts = facets(count);
        let tree = LightTree::new(&parts);
        for (p, n) in [
            (Vec3::new(1.0, 2.0, 3.0), Some(-Vec3::Z)),
            (Vec3::new(0.0, 0.0, 0.5), None),
        ] {
            let n_samples = 40_000;
            let mut counts = vec![0.0f32; count];
            for i in 0..n_samples {
                let Some((part, pmf)) = tree.sample(p, n, (i as f32 + 0.5) / n_samples as f32)
                else {
                    continue;
                };
                assert!((pmf / tree.pmf(p, n, part) - 1.0).abs() < 1e-4);
                counts[part] += 1.0 / n_samples as f32;
            }
            let pmfs: Vec<f32> = (0..count).map(|i| tree.pmf(p, n, i)).collect();
            // Less than 1 where a cluster that might shine here turns out to hold nothing that does.
            assert!(pmfs.iter().sum::<f32>() < 1.001, "{count} pieces: {pmfs:?}");
            for (frequency, pmf) in counts.iter().zip(&pmfs) {
                assert!((frequency - pmf).abs() < 1e-3, "{frequency} for {pmf}");
            }
        }
    }
}

#[test]
fn the_tree_never_forgets_what_arrives() {
    let parts = facets(300);
    let tree = LightTree::new(&parts);
    let mut sampler = Sampler::new(8, 0, Stream::Test, 0);
    for _ in 0..200 {
        let p = Vec3::new(
            sampler.next_1d() * 24.0 - 12.0,
            sampler.next_1d() * 24.0 - 12.0,
            sampler.next_1d() * 6.0 - 3.0,
        );
        let n = warp::sphere(sampler.next_2d());
        for (i, part) in parts.iter().enumerate() {
            if arriving(part, p, n) > 0.0 || arriving(part, p, -n) > 0.0 {
                assert!(
                    tree.pmf(p, Some(n), i) > 0.0 && tree.pmf(p, None, i) > 0.0,
                    "piece {i} from {p}"
                );
            }
        }
    }
}

#[test]
fn the_tree_beats_choice_by_power() {
    let parts = facets(10_000);
    let tree = LightTree::new(&parts);
    let total: f64 = parts.iter().map(|p| f64::from(p.power.r)).sum();
    let mut ratio = 0.0;
    let receivers = [
        Vec3::new(1.0, 2.0, 1.5),
        Vec3::new(-7.0, 3.0, 4.0),
        Vec3::new(0.0, 9.0, 1.2),
    ];
    for p in receivers {
        let n = -Vec3::Z;
        // Exact second moments of value over probability.
        let (mut by_tree, mut by_power) = (0.0f64, 0.0f64);
        let mut sum = 0.0f64;
        for (i, part) in parts.iter().enumerate() {
            let value = f64::from(arriving(part, p, n));
            if value > 0.0 {
                sum += value;
                by_tree += value * value / f64::from(tree.pmf(p, Some(n), i));
                by_power += value * value / (f64::from(part.power.r) / total);
            }
        }
        ratio += (by_power - sum * sum) / (by_tree - sum * sum) / receivers.len() as f64;
    }
    assert!(ratio > 10.0, "variance reduced by {ratio}");
}

#[test]
fn few_pieces_are_chosen_at_least_as_well_as_by_power() {
    for count in 2..=4 {
        let parts = facets(count);
        let tree = LightTree::new(&parts);
        let total: f64 = parts.iter().map(|p| f64::from(p.power.r)).sum();
        let (mut by_tree, mut by_power) = (0.0f64, 0.0f64);
        let mut sampler = Sampler::new(9, 0, Stream::Test, 0);
        for _ in 0..200 {
            let p = Vec3::new(
                sampler.next_1d() * 20.0 - 10.0,
                sampler.next_1d() * 20.0 - 10.0,
                2.0 + sampler.next_1d(),
            );
            let n = -Vec3::Z;
            let values: Vec<f64> = parts
                .iter()
                .map(|part| f64::from(arriving(part, p, n)))
                .collect();
            let sum2 = values.iter().sum::<f64>().powi(2);
            if sum2 == 0.0 {
                continue;
            }
            for (i, (value, part)) in values
                .iter()
                .zip(&parts)
                .enumerate()
                .filter(|(_, (v, _))| **v > 0.0)
            {
                by_tree += value * value / sum2 / f64::from(tree.pmf(p, Some(n), i));
                by_power += value * value / sum2 / (f64::from(part.power.r) / total);
            }
        }
        assert!(
            by_tree <= by_power,
            "{count} pieces: {by_tree} for {by_power}"
        );
    }
}
