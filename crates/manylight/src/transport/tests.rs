//! Next-event estimation in lanes against single vertices.

use super::direct::{EmitterSamples, PreviousEvents, emitted_with_mis, environment_with_mis};
use super::walk::Previous;
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::emitters::{Emitter, Receivers};
use crate::geometry::{Ray, SurfacePoint, SurfacePoints};
use crate::lanes::{Float, LANES, Mask, One, Pair, Vector, Width};
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

/// What next-event estimation gives, by lane.
struct Estimates<S: Width> {
    weight: [S::Each<f32>; 3],
    from: [S::Each<f32>; 3],
    mis: S::Each<f32>,
    valid: u32,
    emitted: [S::Each<f32>; 3],
    environment: [S::Each<f32>; 3],
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
                inside: None,
            }),
            numbers: std::array::from_fn(|_| (numbers.next_1d(), numbers.next_2d())),
            w: std::array::from_fn(|_| warp::sphere(numbers.next_2d())),
        }
    }

    /// The estimates of vertex `vertex(i)` in each lane `i` of `lanes`.
    #[inline(always)]
    fn estimates<S: Width>(
        &self,
        s: S,
        lanes: u32,
        vertex: impl Fn(usize) -> usize,
    ) -> Estimates<S> {
        let previous = |i: usize| &self.previous[vertex(i)];
        let bits = |test: fn(&Previous) -> bool| {
            let set = (0..S::LANES).filter(|&i| test(previous(i)));
            Mask::from_bits(s, set.map(|i| 1 << i).sum())
        };
        let lanes = Mask::from_bits(s, lanes);
        let x = SurfacePoints::load(s, &s.each(|i| self.x[vertex(i)]));
        let n = Vector::from_fn(s, |i| previous(i).n.unwrap_or(Vec3::X));
        let has_normal = bits(|previous| previous.n.is_some());
        let numbers = (
            Float::from_fn(s, |i| self.numbers[vertex(i)].0),
            Pair::from_fn(s, |i| self.numbers[vertex(i)].1),
        );
        let samples = EmitterSamples::new(self.scene, &x, (n, has_normal), numbers, None, lanes);
        let previous = PreviousEvents {
            receivers: Receivers {
                p: Vector::from_fn(s, |i| previous(i).p),
                n,
                has_normal,
            },
            pdf: Float::from_fn(s, |i| previous(i).pdf),
            has_next_event: bits(|p| p.event != Lobes::NONE && p.event != Lobes::DELTA),
        };
        let w = Vector::from_fn(s, |i| self.w[vertex(i)]);
        Estimates {
            weight: samples.weight.store(),
            from: samples.from.store(),
            mis: samples.mis_weight(Float::splat(s, 0.7)).store(),
            valid: samples.valid.bits(),
            emitted: emitted_with_mis(self.scene, &previous, &x, w, lanes).store(),
            environment: environment_with_mis(self.scene, &previous, w, None, lanes).store(),
        }
    }
}

impl SimdKernel for &Vertices<'_> {
    /// Number of lanes that differ from single vertices.
    type Output = usize;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> usize {
        let all = self.estimates(s.wide(), LANES_IN_USE, |i| i);
        let is_same = |i: usize| {
            let one = self.estimates(One, LANES_IN_USE >> i & 1, |_| i);
            let near = |a: [[f32; LANES]; 3], b: [[f32; 1]; 3]| {
                (0..3).all(|c| (a[c][i] - b[c][0]).abs() <= 1e-2 * b[c][0].abs() + 1e-5)
            };
            let is_valid = all.valid >> i & 1 != 0;
            let same_sample = is_valid == (one.valid != 0)
                && (!is_valid
                    || near(all.weight, one.weight)
                        && near(all.from, one.from)
                        && (all.mis[i] - one.mis[0]).abs() < 1e-3);
            same_sample && near(all.emitted, one.emitted) && near(all.environment, one.environment)
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
