//! Next-event estimation in lanes against single vertices.

use super::direct::{EmitterSample, emitted_with_mis, environment_with_mis};
use super::direct_lanes::{
    EmitterSamples, PreviousEvents, emitted_with_mis_lanes, environment_with_mis_lanes,
};
use super::walk::Previous;
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::emitters::{Emitter, Receivers};
use crate::geometry::{Ray, SurfacePoint, SurfacePoints};
use crate::lanes::{Float, LANES, Mask, Pair, Sixteen, Vector};
use crate::math::{Vec2, Vec3};
use crate::sampling::{Sampler, Stream, warp};
use crate::scene::Scene;
use crate::simd::{Instructions, Isa, Simd, SimdKernel};
use crate::testing::scenes::glossy_box;

/// Lanes in which samples and rays are wanted.
const LANES_IN_USE: u32 = 0xf7ef;

/// Sixteen vertices, their previous events, random numbers and directions.
struct Vertices<'s> {
    scene: &'s Scene,
    x: [SurfacePoint; LANES],
    previous: [Previous; LANES],
    numbers: [(f32, Vec2); LANES],
    w: [Vec3; LANES],
}

/// What single functions give at one vertex.
struct Single {
    sample: Option<(EmitterSample, f32)>,
    emitted: Rgb,
    environment: Rgb,
}

impl<'s> Vertices<'s> {
    fn new(scene: &'s Scene, numbers: &mut Sampler) -> Self {
        let mut x = Vec::new();
        while x.len() < LANES {
            let o = Vec3::new(0.1, 0.1, 0.1) * (numbers.next_1d() - 0.5);
            let ray = Ray::new(o, warp::sphere(numbers.next_2d()));
            x.extend(scene.intersect(&ray).map(|(_, x)| x));
        }
        let events = [Lobes::DIFFUSE, Lobes::DELTA, Lobes::NONE, Lobes::GLOSSY];
        Vertices {
            scene,
            x: x.try_into().expect("sixteen points"),
            previous: std::array::from_fn(|i| Previous {
                p: Vec3::splat(0.05 * i as f32 - 0.4),
                n: (i % 5 != 0).then(|| warp::sphere(numbers.next_2d())),
                event: events[i % 4],
                pdf: numbers.next_1d() * 2.0,
            }),
            numbers: std::array::from_fn(|_| (numbers.next_1d(), numbers.next_2d())),
            w: std::array::from_fn(|_| warp::sphere(numbers.next_2d())),
        }
    }

    fn single(&self, i: usize) -> Single {
        let (x, n) = (&self.x[i], self.previous[i].n);
        let sample = EmitterSample::new(self.scene, x, n, self.numbers[i]);
        Single {
            sample: sample.map(|sample| (sample, sample.mis_weight(0.7))),
            emitted: emitted_with_mis(self.scene, &self.previous[i], x, self.w[i]),
            environment: environment_with_mis(self.scene, &self.previous[i], self.w[i], None),
        }
    }
}

impl SimdKernel for &Vertices<'_> {
    /// Number of lanes that differ.
    type Output = usize;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> usize {
        let s = Sixteen(s.wide());
        let lanes = Mask::from_bits(s, LANES_IN_USE);
        let bits = |test: fn(&Previous) -> bool| {
            let set = (0..LANES).filter(|&i| test(&self.previous[i]));
            Mask::from_bits(s, set.map(|i| 1 << i).sum())
        };
        let x = SurfacePoints::load(s, &self.x);
        let n = Vector::from_fn(s, |i| self.previous[i].n.unwrap_or(Vec3::X));
        let has_normal = bits(|previous| previous.n.is_some());
        let numbers = (
            Float::from_fn(s, |i| self.numbers[i].0),
            Pair::from_fn(s, |i| self.numbers[i].1),
        );
        let samples = EmitterSamples::new(self.scene, &x, (n, has_normal), numbers, None, lanes);
        let mis = samples.mis_weight(Float::splat(s, 0.7)).store();
        let previous = PreviousEvents {
            receivers: Receivers {
                p: Vector::from_fn(s, |i| self.previous[i].p),
                n,
                has_normal,
            },
            pdf: Float::from_fn(s, |i| self.previous[i].pdf),
            has_next_event: bits(|p| p.event != Lobes::NONE && p.event != Lobes::DELTA),
        };
        let w = Vector::from_fn(s, |i| self.w[i]);
        let emitted = emitted_with_mis_lanes(self.scene, &previous, &x, w, lanes).store();
        let environment = environment_with_mis_lanes(self.scene, &previous, w, None, lanes).store();
        let (weight, from) = (samples.weight.store(), samples.from.store());
        let is_same = |i: usize| {
            let one = self.single(i);
            let near = |a: [[f32; LANES]; 3], b: [f32; 3]| {
                (0..3).all(|c| (a[c][i] - b[c]).abs() <= 1e-2 * b[c].abs() + 1e-5)
            };
            let is_in_use = LANES_IN_USE >> i & 1 != 0;
            let within = |color: Rgb| if is_in_use { color } else { Rgb::BLACK };
            let same_sample = match one.sample.filter(|_| is_in_use) {
                Some((sample, weight_of_one)) => {
                    let start = self.x[i].offset_towards(sample.wi);
                    samples.valid.bits() >> i & 1 != 0
                        && near(weight, sample.weight.to_array())
                        && near(from, start.to_array())
                        && (mis[i] - weight_of_one).abs() < 1e-3
                }
                None => samples.valid.bits() >> i & 1 == 0,
            };
            same_sample
                && near(emitted, within(one.emitted).to_array())
                && near(environment, within(one.environment).to_array())
        };
        (0..LANES).filter(|&i| !is_same(i)).count()
    }
}

#[test]
fn vertices_in_lanes_are_single_ones() {
    let mut builder = glossy_box(16);
    builder.emitter(Emitter::Constant {
        radiance: Rgb::new(0.3, 0.2, 0.1),
    });
    let scene = builder.build();
    let mut numbers = Sampler::new(31, 0, Stream::Test, 0);
    let (mut different, mut count) = (0, 0);
    for _ in 0..200 {
        let vertices = Vertices::new(&scene, &mut numbers);
        for isa in Instructions::available().into_iter().filter_map(Isa::new) {
            different += isa.run(&vertices);
            count += LANES;
        }
    }
    assert!(different * 500 <= count, "{different} of {count} differ");
}
