//! Time of next-event estimation: emitter samples and their densities, per sample and thread.
//!
//! `MANYLIGHT_BENCH_SCENES=a.xml:b.xml cargo bench -p manylight --bench emitters [-- WHAT [REPEATS]]`,
//! with WHAT one of `one`, `pdf`, `environment`, and `sixteen`, `pdf16`, `environment16` for
//! sixteen receivers at a time; by default all.
//!
//! Receivers are the surfaces seen through random tiles of 8 x 8 pixels of a 512 x 512 image, and
//! where one diffuse reflection there leads. For instructions per sample,
//! `perf stat -e instructions:u` with two numbers of repeats gives a difference without the start.
#![allow(
    clippy::print_stdout,
    reason = "a benchmark reports on standard output"
)]

#[path = "../shared/clock.rs"]
mod clock;
#[path = "../shared/scene_list.rs"]
mod scene_list;
#[path = "../shared/tiles.rs"]
#[allow(dead_code, reason = "shared by several benchmarks")]
mod tiles;

use manylight::emitters::DirectSample;
use manylight::geometry::{Ray, SurfacePoint};
use manylight::lanes::{LANES, LaneMask, Lanes3};
use manylight::math::{Frame, Vec2, Vec3};
use manylight::sampling::{rng::Pcg, warp};
use manylight::scene::Scene;
use manylight::testing::sixteen_receivers::{
    SixteenReceivers, environment_sixteen, pdf_direct_sixteen, sample_sixteen,
};
use std::hint::black_box;

/// Number of tiles.
const TILES: usize = 256;
/// Runs per measurement, if the command line does not say; the median is reported.
const REPEATS: usize = 31;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let what = arguments.first().filter(|a| !a.starts_with("--"));
    let repeats = arguments.get(1).and_then(|a| a.parse().ok());
    scene_list::for_each_scene(|path| {
        let scene = tiles::load(path);
        let run = Workload::new(&scene);
        let repeats = repeats.unwrap_or(REPEATS);
        let wanted = |name: &str| what.is_none_or(|what| what == name);
        if wanted("one") {
            run.report("one", repeats, || run.sample_each());
        }
        if wanted("sixteen") {
            run.report("sixteen", repeats, || run.sample_sixteen());
        }
        if wanted("pdf16") && !run.hits.is_empty() {
            run.report("pdf16", repeats, || run.densities_sixteen());
        }
        if wanted("environment16") && scene.emitters.has_environment() {
            run.report("environment16", repeats, || run.environment_sixteen());
        }
        if wanted("pdf") && !run.hits.is_empty() {
            run.report("pdf", repeats, || run.densities());
        }
        if wanted("environment") && scene.emitters.has_environment() {
            run.report("environment", repeats, || run.environment());
        }
    });
}

/// A receiver and the random numbers of its sample.
struct Receiver {
    p: Vec3,
    n: Vec3,
    u_choice: f32,
    u: Vec2,
}

impl Receiver {
    fn sample(&self, scene: &Scene) -> Option<DirectSample> {
        let (geometry, textures) = (&scene.geometry, &scene.textures);
        let (receiver, numbers) = ((self.p, Some(self.n)), (self.u_choice, self.u));
        (scene.emitters).sample(geometry, textures, receiver, numbers, None)
    }
}

struct Workload<'s> {
    scene: &'s Scene,
    receivers: Vec<Receiver>,
    /// Points of emitters, with the index of the receiver that sampled them.
    hits: Vec<(usize, SurfacePoint)>,
    /// Directions to the environment, with the index of a receiver.
    directions: Vec<(usize, Vec3)>,
    /// The receivers and their numbers, sixteen at a time.
    packets: Vec<(SixteenReceivers, Lanes3)>,
    /// The hits, sixteen at a time.
    hit_packets: Vec<(SixteenReceivers, [SurfacePoint; LANES])>,
    /// The directions, sixteen at a time.
    direction_packets: Vec<(SixteenReceivers, Lanes3)>,
}

/// Sixteen receivers with normals.
fn sixteen(receivers: &[&Receiver]) -> SixteenReceivers {
    SixteenReceivers {
        p: Lanes3::from_fn(|i| receivers[i].p),
        n: Lanes3::from_fn(|i| receivers[i].n),
        has_normal: LaneMask::MAX,
    }
}

impl<'s> Workload<'s> {
    fn new(scene: &'s Scene) -> Self {
        let mut random = Pcg::new(7);
        let mut number = move || random.next_f32();
        let mut receivers = Vec::new();
        for tile in tiles::tiles(scene, TILES) {
            let facing = |x: &SurfacePoint, wo: Vec3| x.normal_towards(wo);
            let seen: Vec<(SurfacePoint, Vec3)> =
                tile.iter().map(|x| (x.x, facing(&x.x, x.wo))).collect();
            let reflected: Vec<(SurfacePoint, Vec3)> = seen
                .iter()
                .filter_map(|(x, n)| {
                    let local = warp::cosine_hemisphere(Vec2::new(number(), number()));
                    let wi = Frame::from_normal(*n).to_world(local);
                    let ray = Ray::new(x.offset_towards(wi), wi);
                    let (_, y) = scene.intersect(&ray)?;
                    Some((y, facing(&y, -wi)))
                })
                .collect();
            receivers.extend(seen.into_iter().chain(reflected).map(|(x, n)| Receiver {
                p: x.p,
                n,
                u_choice: number(),
                u: Vec2::new(number(), number()),
            }));
        }
        let mut run = Workload {
            scene,
            receivers,
            hits: Vec::new(),
            directions: Vec::new(),
            packets: Vec::new(),
            hit_packets: Vec::new(),
            direction_packets: Vec::new(),
        };
        for (i, r) in run.receivers.iter().enumerate() {
            let Some(sample) = r.sample(scene) else {
                continue;
            };
            run.directions.push((i, sample.wi));
            if let Some((_, y)) = scene.intersect(&Ray::new(r.p + sample.wi * 1e-3, sample.wi)) {
                let primitive = &scene.geometry.primitives()[y.at.primitive.index()];
                if primitive.emitter.is_some() {
                    run.hits.push((i, y));
                }
            }
        }
        run.fill_packets();
        run
    }

    fn fill_packets(&mut self) {
        let all = &self.receivers;
        for some in all.chunks_exact(LANES) {
            let numbers = |i: usize| Vec3::new(some[i].u_choice, some[i].u.x, some[i].u.y);
            let some: Vec<&Receiver> = some.iter().collect();
            (self.packets).push((sixteen(&some), Lanes3::from_fn(numbers)));
        }
        for some in self.hits.chunks_exact(LANES) {
            let of: Vec<&Receiver> = some.iter().map(|(i, _)| &all[*i]).collect();
            let points = std::array::from_fn(|i| some[i].1);
            self.hit_packets.push((sixteen(&of), points));
        }
        for some in self.directions.chunks_exact(LANES) {
            let of: Vec<&Receiver> = some.iter().map(|(i, _)| &all[*i]).collect();
            let directions = Lanes3::from_fn(|i| some[i].1);
            self.direction_packets.push((sixteen(&of), directions));
        }
    }

    /// Prints the median time per sample over several runs; `run` returns a number of samples and a
    /// sum.
    fn report(&self, name: &str, repeats: usize, run: impl Fn() -> (usize, f32)) {
        let mut times = Vec::new();
        let mut last = (0, 0.0);
        for _ in 0..repeats {
            let start = clock::thread_seconds();
            last = black_box(run());
            times.push((clock::thread_seconds() - start) / last.0 as f64);
        }
        times.sort_by(f64::total_cmp);
        println!(
            "{name:12} {:7.1} ns, {} per run, mean {}",
            times[times.len() / 2] * 1e9,
            last.0,
            last.1 / last.0 as f32
        );
    }

    /// Samples receiver by receiver.
    fn sample_each(&self) -> (usize, f32) {
        let mut sum = 0.0;
        for sample in self.receivers.iter().filter_map(|r| r.sample(self.scene)) {
            sum += sample.weight.g * sample.wi.x.abs() + sample.pdf.min(1.0);
        }
        (self.receivers.len(), sum)
    }

    /// Densities of points that were hit.
    fn densities(&self) -> (usize, f32) {
        let mut sum = 0.0;
        for (i, y) in &self.hits {
            let r = &self.receivers[*i];
            sum += self.scene.emitters.pdf_direct(r.p, Some(r.n), y).min(1.0);
        }
        (self.hits.len(), sum)
    }

    /// Look-ups of the environment.
    fn environment(&self) -> (usize, f32) {
        let mut sum = 0.0;
        for (i, wi) in &self.directions {
            let r = &self.receivers[*i];
            let (radiance, pdf) = self.scene.emitters.environment(Some(r.n), *wi, None);
            sum += radiance.g + pdf.min(1.0);
        }
        (self.directions.len(), sum)
    }

    /// As [`Workload::sample_each`], sixteen at a time.
    fn sample_sixteen(&self) -> (usize, f32) {
        let scene = self.scene;
        let (geometry, textures) = (&scene.geometry, &scene.textures);
        let mut sum = 0.0;
        for (receivers, u) in &self.packets {
            let samples = sample_sixteen(
                &scene.emitters,
                geometry,
                textures,
                receivers,
                u,
                LaneMask::MAX,
            );
            for i in 0..LANES {
                if samples.valid >> i & 1 != 0 {
                    let (g, x) = (samples.weight.0[1][i], samples.wi.0[0][i]);
                    sum += g * x.abs() + samples.pdf[i].min(1.0);
                }
            }
        }
        (self.packets.len() * LANES, sum)
    }

    fn densities_sixteen(&self) -> (usize, f32) {
        let mut sum = 0.0;
        for (receivers, y) in &self.hit_packets {
            let pdf = pdf_direct_sixteen(&self.scene.emitters, receivers, y, LaneMask::MAX);
            sum += pdf.iter().map(|pdf| pdf.min(1.0)).sum::<f32>();
        }
        (self.hit_packets.len() * LANES, sum)
    }

    fn environment_sixteen(&self) -> (usize, f32) {
        let mut sum = 0.0;
        for (receivers, wi) in &self.direction_packets {
            let (radiance, pdf) = environment_sixteen(&self.scene.emitters, receivers, wi);
            sum += radiance.0[1].iter().sum::<f32>();
            sum += pdf.iter().map(|pdf| pdf.min(1.0)).sum::<f32>();
        }
        (self.direction_packets.len() * LANES, sum)
    }
}
