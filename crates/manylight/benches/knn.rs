//! Rate of k-nearest-neighbor queries among the photons of a scene, compared with the crate kiddo.
//!
//! `cargo bench -p manylight --bench knn [-- PHOTONS...]`; by default one and ten million photons.
//! The scene is `scenes/glossy-room`, or the file that `MANYLIGHT_BENCH_SCENE` names.
//!
//! Both trees hold the same points and answer the same queries, in alternating parts. A reported
//! ratio is the median over the parts; the time of a part is the shortest of several runs, which
//! other load on the machine hardly changes. kiddo answers sorted (its default) and unsorted; the
//! unsorted time is the comparable one. Every answer is checked: the distance of the k-th neighbor
//! is the same, and so are all nearer neighbors.
#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a benchmark reports on standard output and may panic"
)]
#![allow(missing_docs, reason = "a program")]

#[path = "shared/default_scene.rs"]
mod default_scene;

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use manylight::maps::{KdTree, Neighbors};
use manylight::math::{Aabb, Vec3};
use manylight::particles::{trace_photons, usable_by_virtual_lights};
use manylight::sampling::{Pass, rng::Pcg};
use manylight::scene::Scene;
use rayon::prelude::*;
use std::num::NonZero;
use std::time::Instant;

type Kiddo = ImmutableKdTree<f32, 3>;

/// Number of query points.
const QUERIES: usize = 16_384;
/// Queries per thread that one tree answers before the trees alternate.
const PART: usize = 512;
/// Runs of a part; the shortest time is used.
const RUNS: usize = 3;

fn main() {
    let counts: Vec<usize> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let counts = if counts.is_empty() {
        vec![1_000_000, 10_000_000]
    } else {
        counts
    };
    let photons = photons(*counts.iter().max().unwrap());
    for count in counts {
        compare(&photons[..count]);
    }
}

/// Positions of the first `count` photons of successive passes.
fn photons(count: usize) -> Vec<Vec3> {
    let path = default_scene::default_scene();
    let desc = manylight_io::load_scene(&path, &Default::default())
        .unwrap()
        .desc;
    let limits = desc.limits;
    let scene = Scene::build(desc, 0).unwrap();
    let mut points = Vec::with_capacity(count);
    for index in 0.. {
        let photons = trace_photons(
            &scene,
            &scene.infinite_light_guide(),
            limits,
            1 << 18,
            Pass { seed: 0, index },
            usable_by_virtual_lights,
        );
        points.extend(
            photons
                .iter()
                .take(count - points.len())
                .map(|photon| photon.p),
        );
        assert!(!points.is_empty(), "the scene has no photons");
        if points.len() == count {
            break;
        }
    }
    println!("photons of {}", path.display());
    points
}

fn compare(points: &[Vec3]) {
    let arrays: Vec<[f32; 3]> = points.iter().map(|p| p.to_array()).collect();
    println!("\n{} photons", points.len());
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let items = || points.to_vec();
        let copied = seconds(items).0;
        let own = seconds(|| pool.install(|| KdTree::build(items()))).0 - copied;
        let kiddo = seconds(|| pool.install(|| Kiddo::new_from_slice(&arrays).unwrap())).0;
        println!(
            "build, {threads} threads: {own:.3} s, kiddo {kiddo:.3} s, {:.2} times",
            kiddo / own
        );
    }
    let own = KdTree::build(points.to_vec());
    let bytes = own.bytes() - size_of_val(points);
    println!(
        "{:.2} bytes per photon in addition to the photons",
        bytes as f64 / points.len() as f64
    );
    let kiddo = Kiddo::new_from_slice(&arrays).unwrap();

    // Shading points lie near surfaces but not on photons: jitter photon positions a little.
    let mut rng = Pcg::new(1);
    let jitter = 1e-4 * Aabb::from_points(points.iter().copied()).diagonal();
    let random: Vec<Vec3> = (0..QUERIES)
        .map(|_| {
            let at = (f64::from(rng.next_f32()) * points.len() as f64) as usize;
            let step = Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) - 0.5;
            points[at.min(points.len() - 1)] + jitter * step
        })
        .collect();
    let coherent = KdTree::build_ordered(random.clone()).into_items();
    for k in [50, 150, 500] {
        for (order, queries) in [("random", &random), ("coherent", &coherent)] {
            for threads in [1, 2] {
                let pool = rayon::ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .build()
                    .unwrap();
                pool.install(|| {
                    measure(&own, &kiddo, queries, k, &format!("{order:8} {threads}T"))
                });
            }
        }
    }
}

/// Measures both trees with the same queries, checks the answers and prints one line.
fn measure(own: &KdTree<Vec3>, kiddo: &Kiddo, queries: &[Vec3], k: usize, name: &str) {
    let threads = rayon::current_num_threads();
    let (mut times, mut sorted_times, mut own_times) = (Vec::new(), Vec::new(), Vec::new());
    for part in queries.chunks(PART * threads) {
        let (own_time, ours) = seconds(|| {
            let runs = part.par_chunks(PART).flat_map_iter(|run| {
                let mut found = Neighbors::new(k);
                run.iter().map(move |&p| {
                    own.nearest(p, f32::INFINITY, &mut found);
                    (found.radius_squared(), found.iter().collect::<Vec<_>>())
                })
            });
            runs.collect::<Vec<_>>()
        });
        let ask = |sorted: bool| {
            let runs = part.par_chunks(PART).flat_map_iter(|run| {
                run.iter().map(move |p| {
                    let at = p.to_array();
                    let query = kiddo.query(&at);
                    let query = query.nearest_n::<SquaredEuclidean<f32>>(NonZero::new(k).unwrap());
                    if sorted {
                        query.execute()
                    } else {
                        query.unsorted().execute()
                    }
                })
            });
            runs.collect::<Vec<_>>()
        };
        let (time, theirs) = seconds(|| ask(false));
        let (sorted_time, _) = seconds(|| ask(true));
        for (ours, theirs) in ours.iter().zip(&theirs) {
            let inside = |d2: f32| d2 < ours.0;
            let mut a: Vec<u32> = ours.1.iter().filter(|n| inside(n.1)).map(|n| n.0).collect();
            let mut b: Vec<u32> = theirs
                .iter()
                .filter(|n| inside(n.distance))
                .map(|n| n.item)
                .collect();
            a.sort_unstable();
            b.sort_unstable();
            assert_eq!(a, b);
            assert_eq!(ours.0, theirs.iter().fold(0.0f32, |r, n| r.max(n.distance)));
        }
        own_times.push(own_time / part.len() as f64);
        times.push(time / own_time);
        sorted_times.push(sorted_time / own_time);
    }
    println!(
        "K = {k:3} {name}: {:7.1} thousand per second; {:5.2} times kiddo, {:5.2} times kiddo sorted",
        1e-3 / median(own_times),
        median(times),
        median(sorted_times)
    );
}

/// The shortest time of [`RUNS`] runs in seconds, and the result. Other load only adds time, and
/// more to the slower tree.
fn seconds<T>(work: impl Fn() -> T) -> (f64, T) {
    let run = || {
        let start = Instant::now();
        let result = work();
        (start.elapsed().as_secs_f64(), result)
    };
    let runs = (1..RUNS).map(|_| run());
    runs.fold(
        run(),
        |best, next| if next.0 < best.0 { next } else { best },
    )
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
