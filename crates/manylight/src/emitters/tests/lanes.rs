//! Sixteen receivers at a time against single ones, in all instruction sets.

use super::*;
use crate::geometry::{Ray, SurfacePoint, SurfacePoints};
use crate::lanes::{LANES, LaneMask, Lanes3, Mask, Vector, Width};
use crate::sampling::warp;
use crate::simd::{Instructions, Isa, Simd, SimdKernel};
use crate::testing::sixteen_receivers::{
    DensityKernel, EnvironmentKernel, SampleKernel, SixteenReceivers,
};

/// Largest fraction of samples that may differ, because rounding changes a choice.
const DIFFERENT: f64 = 2e-3;

/// Emitters of all kinds, many of them.
fn mixed() -> World {
    let mut placed = Vec::new();
    let shapes = [
        Shape::Mesh(Mesh::rectangle()),
        Shape::Mesh(Mesh::cube()),
        sphere_shape(),
        Shape::Disk,
        cylinder(),
        Shape::Mesh(smooth_ball()),
    ];
    for (i, shape) in shapes.iter().cycle().take(24).enumerate() {
        let turn = i as f32 * 0.9;
        let at = Vec3::new(4.0 * turn.cos(), 4.0 * turn.sin(), (i % 5) as f32 - 2.0);
        let scale = if i % 4 == 0 {
            Vec3::new(0.2, 0.4, 0.3)
        } else {
            Vec3::splat(0.3)
        };
        let transform = Affine3A::from_translation(at)
            * Affine3A::from_axis_angle(Vec3::new(0.3, 1.0, 0.2).normalize(), turn)
            * Affine3A::from_scale(scale);
        let one = Placed::new(shape.clone(), transform);
        placed.push(if i % 3 == 1 { one.textured() } else { one });
    }
    let point = |x: f32| Emitter::Point {
        position: Vec3::new(x, 1.0, 2.0),
        intensity: Rgb::new(3.0, 2.0, 1.0),
    };
    let spot = Emitter::Spot {
        position: Vec3::new(0.0, 0.0, 5.0),
        direction: -Vec3::Z,
        intensity: Rgb::splat(5.0),
        cutoff: 0.8,
        beam_width: 0.5,
        falloff: SpotFalloff::LinearAngle,
        projector: Some(projector()),
    };
    let mut others = infinite_emitters();
    others.extend([point(1.0), point(-2.0), spot]);
    world(placed, others)
}

/// Worlds of one emitter, of many, of infinite lights alone and of one environment alone.
fn worlds() -> Vec<(&'static str, World)> {
    let mut worlds = emissive_worlds();
    let infinite = infinite_emitters();
    for (name, emitters) in [
        ("constant", vec![infinite[0].clone()]),
        ("parallel light", vec![infinite[1].clone()]),
        ("environment", vec![infinite[2].clone()]),
        ("infinite lights", infinite),
    ] {
        let ground = Placed::new(Shape::Mesh(Mesh::rectangle()), Affine3A::IDENTITY).dark();
        worlds.push((name, world(vec![ground], emitters)));
    }
    worlds.push(("mixed", mixed()));
    worlds
}

/// Sixteen receivers, some of them without a normal.
fn random_receivers(numbers: &mut Sampler) -> SixteenReceivers {
    let mut receivers = SixteenReceivers {
        p: Lanes3::ZERO,
        n: Lanes3::ZERO,
        has_normal: (numbers.next_1d() * 65536.0) as LaneMask | 0x0f0f,
    };
    for i in 0..LANES {
        let p = numbers.next_2d().extend(numbers.next_1d()) * 5.0 - 2.5;
        receivers.p.set(i, p);
        receivers.n.set(i, warp::sphere(numbers.next_2d()));
    }
    receivers
}

fn receiver(all: &SixteenReceivers, i: usize) -> (Vec3, Option<Vec3>) {
    let has_normal = all.has_normal >> i & 1 != 0;
    (all.p.vec(i), has_normal.then(|| all.n.vec(i)))
}

fn is_near(a: f32, b: f32, tolerance: f32) -> bool {
    (a - b).abs() <= tolerance * a.abs().max(b.abs()) + 1e-6
}

fn is_same(a: &DirectSample, b: &DirectSample) -> bool {
    let size = a.target.abs().max_element();
    a.wi.abs_diff_eq(b.wi, 1e-4)
        && a.target.abs_diff_eq(b.target, 1e-4 * (1.0 + size))
        && is_near(a.pdf, b.pdf, 1e-2)
        && (0..3).all(|c| is_near(a.weight.to_array()[c], b.weight.to_array()[c], 1e-2))
}

/// Emitted radiance of sixteen points.
struct RadianceKernel<'a> {
    world: &'a World,
    x: &'a [SurfacePoint; LANES],
    wo: &'a Lanes3,
    lanes: LaneMask,
}

impl SimdKernel for RadianceKernel<'_> {
    type Output = Lanes3;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Lanes3 {
        let s = s.wide();
        let World {
            geometry,
            textures,
            emitters,
            ..
        } = self.world;
        let (x, wo) = (
            SurfacePoints::load(s, &s.each(|i| self.x[i])),
            Vector::load(s, &self.wo.0),
        );
        let lanes = Mask::from_bits(s, self.lanes.into());
        Lanes3(
            emitters
                .radiance_lanes(geometry, textures, &x, wo, lanes)
                .store(),
        )
    }
}

fn isas() -> impl Iterator<Item = Isa> {
    Instructions::available().into_iter().filter_map(Isa::new)
}

#[test]
fn sixteen_samples_are_single_ones() {
    check_samples([None; LANES]);
}

#[test]
fn sixteen_guided_samples_are_single_ones() {
    let directions = [0.1, 0.3, 0.5, 0.7].map(|x| Vec3::new(x, 0.4, 0.8).normalize());
    let four = EnvironmentLobes::new(directions.into_iter()).expect("four directions");
    let many = (0..40).map(|i| warp::sphere(Vec2::new(i as f32 * 0.03, 0.4)));
    let many = EnvironmentLobes::new(many).expect("more than four directions");
    check_samples(std::array::from_fn(|i| {
        [None, Some(&four), Some(&many)][i % 3]
    }));
}

fn check_samples(lobes: [Option<&EnvironmentLobes>; LANES]) {
    for (name, world) in worlds() {
        let mut numbers = Sampler::new(21, 0, Stream::Test, 0);
        let (mut different, mut valid, mut count) = (0, 0, 0);
        for packet in 0..300 {
            let receivers = random_receivers(&mut numbers);
            let mut u = Lanes3::ZERO;
            for i in 0..LANES {
                u.set(i, numbers.next_2d().extend(numbers.next_1d()));
            }
            let lanes: LaneMask = if packet % 3 == 0 { 0xffff } else { 0xb3a9 };
            for isa in isas() {
                let samples = isa.run(SampleKernel {
                    emitters: &world.emitters,
                    scene: (&world.geometry, &world.textures),
                    receivers: &receivers,
                    u: &u,
                    lobes,
                    lanes,
                });
                assert_eq!(samples.valid & !lanes, 0);
                for i in (0..LANES).filter(|i| lanes >> i & 1 != 0) {
                    let (p, n) = receiver(&receivers, i);
                    let [u_choice, x, y] = u.vec(i).into();
                    let u = Vec2::new(x, y);
                    let one = match lobes[i] {
                        Some(lobes) => world.sample_guided((p, n), lobes, (u_choice, u)),
                        None => world.sample(p, n, u_choice, u),
                    };
                    let same = match (samples.get(i), one) {
                        (None, None) => true,
                        (Some(a), Some(b)) => is_same(&a, &b),
                        _ => false,
                    };
                    count += 1;
                    valid += usize::from(one.is_some());
                    different += usize::from(!same);
                }
            }
        }
        assert!(valid * 10 > count, "{name}: {valid} samples of {count}");
        assert!(
            different as f64 <= DIFFERENT * count as f64,
            "{name}: {different} of {count} samples differ"
        );
    }
}

#[test]
fn sixteen_densities_and_radiances_are_single_ones() {
    for (name, world) in worlds() {
        let mut numbers = Sampler::new(22, 0, Stream::Test, 0);
        let (mut emitting, mut different, mut count) = (0, 0, 0);
        for _ in 0..300 {
            let receivers = random_receivers(&mut numbers);
            let mut hits = Vec::new();
            while hits.len() < LANES && !world.geometry.primitives().is_empty() {
                let o = numbers.next_2d().extend(numbers.next_1d()) * 8.0 - 4.0;
                let ray = Ray::new(o, warp::sphere(numbers.next_2d()));
                if let Some(hit) = world.geometry.intersect(&ray) {
                    hits.push(world.geometry.surface_point(hit.at));
                }
            }
            let y = hits.try_into().expect("sixteen points");
            let mut wi = Lanes3::ZERO;
            for i in 0..LANES {
                wi.set(i, warp::sphere(numbers.next_2d()));
            }
            let lanes: LaneMask = 0xfbdf;
            for isa in isas() {
                let densities = isa.run(DensityKernel {
                    emitters: &world.emitters,
                    receivers: &receivers,
                    y: &y,
                    lanes,
                });
                let emitted = isa.run(RadianceKernel {
                    world: &world,
                    x: &y,
                    wo: &wi,
                    lanes,
                });
                let (radiance, pdf) = isa.run(EnvironmentKernel {
                    emitters: &world.emitters,
                    receivers: &receivers,
                    wi: &wi,
                });
                for i in 0..LANES {
                    let (p, n) = receiver(&receivers, i);
                    let (mut one, mut one_emitted) = (0.0, Rgb::BLACK);
                    if lanes >> i & 1 != 0 {
                        let (geometry, textures) = (&world.geometry, &world.textures);
                        let emitters = &world.emitters;
                        one = emitters.pdf_direct(p, n, &y[i]);
                        one_emitted = emitters.radiance(geometry, textures, &y[i], wi.vec(i));
                    }
                    assert_eq!(emitted.rgb(i), one_emitted);
                    let (one_radiance, one_pdf) = world.emitters.environment(n, wi.vec(i), None);
                    let difference = (radiance.rgb(i) - one_radiance).map(f32::abs);
                    let same = is_near(densities[i], one, 1e-2)
                        && is_near(pdf[i], one_pdf, 1e-2)
                        && difference.max_channel() <= 1e-3;
                    count += 1;
                    different += usize::from(!same);
                    emitting += usize::from(one > 0.0 || one_pdf > 0.0);
                }
            }
        }
        assert!(
            emitting > 0 || name == "parallel light",
            "{name}: nothing emits"
        );
        assert!(
            different as f64 <= DIFFERENT * count as f64,
            "{name}: {different} of {count} densities differ"
        );
    }
}
