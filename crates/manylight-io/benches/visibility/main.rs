//! Rays per second and thread, as ratios to other kernels on the same rays:
//! `MANYLIGHT_BENCH_SCENES=a.xml:b.xml cargo bench --bench visibility [-- WHAT]`, where WHAT is a part of the name of a set.
//!
//! The variable `MANYLIGHT_EMBREE` may name the shared library of Embree 4, which is then compared with.
#![allow(
    clippy::print_stdout,
    reason = "reporting is all that this program does"
)]

mod clock;
mod embree;
mod workload;

use embree::Embree;
use manylight::geometry::{Geometry, Instructions, Ray, Segment};
use manylight::math::Vec3;
use std::hint::black_box;
use std::path::Path;
use workload::{Block, Workload};

const REPEATS: usize = 9;
const LIGHTS: [usize; 4] = [1 << 12, 1 << 15, 1 << 18, 1 << 20];

fn main() {
    let wanted: Vec<String> = std::env::args()
        .skip(1)
        .filter(|argument| argument != "--bench")
        .collect();
    let is_wanted =
        |set: &str| wanted.is_empty() || wanted.iter().any(|part| set.contains(part.as_str()));
    let Some(scenes) = std::env::var_os("MANYLIGHT_BENCH_SCENES") else {
        println!("MANYLIGHT_BENCH_SCENES names no scene files (separated by colons)");
        return;
    };
    for path in std::env::split_paths(&scenes) {
        bench_scene(&path, &is_wanted);
    }
}

fn bench_scene(path: &Path, is_wanted: &dyn Fn(&str) -> bool) {
    let mut work = Workload::load(path);
    let count = work.triangles.len() as f64;
    println!("\n# {}: {count} triangles", path.display());
    let embree = Embree::new(&work.triangles, 0);
    let bytes = work.geometry.acceleration_bytes() as f64 / count;
    println!(
        "build: own {:.3} s, {bytes:.0} B/triangle",
        work.build_seconds
    );
    if let Some(embree) = &embree {
        println!(
            "       Embree {:.3} s, {:.0} B/triangle (with vertices and indices, 48)",
            embree.seconds,
            embree.bytes as f64 / count
        );
    }
    if is_wanted("camera") {
        let rays = work.camera();
        nearest(&mut work.geometry, embree.as_ref(), "camera", &rays);
    }
    if is_wanted("bounce") {
        let rays = work.bounce();
        nearest(&mut work.geometry, embree.as_ref(), "bounce", &rays);
    }
    if is_wanted("random") {
        let segments = work.random_segments();
        occlusion(&mut work.geometry, embree.as_ref(), "random", &segments);
    }
    for lights in LIGHTS {
        let set = format!("{}k lights", lights >> 10);
        if is_wanted(&set) || is_wanted("tile") || is_wanted("block") {
            let blocks = work.blocks(lights);
            if is_wanted("tile") {
                let segments: Vec<Segment> = blocks.iter().flat_map(Block::segments).collect();
                let name = format!("tile, {set}");
                occlusion(&mut work.geometry, embree.as_ref(), &name, &segments);
            }
            if is_wanted("block") {
                block_visibility(&mut work.geometry, embree.as_ref(), &set, &blocks);
            }
        }
    }
}

/// One way to trace a set, and what it finds.
struct Way<'a> {
    name: String,
    trace: Box<dyn Fn(&Geometry) -> u64 + 'a>,
    instructions: Instructions,
}

/// Ways of the same name in all instruction sets that the machine has.
fn own<'a>(name: &str, trace: impl Fn(&Geometry) -> u64 + Clone + 'a) -> Vec<Way<'a>> {
    let all = Instructions::available().into_iter();
    all.map(|instructions| Way {
        name: format!("{name} {instructions:?}"),
        trace: Box::new(trace.clone()),
        instructions,
    })
    .collect()
}

fn foreign<'a>(name: &str, trace: impl Fn() -> u64 + 'a) -> Way<'a> {
    Way {
        name: name.to_owned(),
        trace: Box::new(move |_| trace()),
        instructions: Instructions::Portable,
    }
}

/// Traces in turns and prints the median rates, as ratios to the best of the first `opponents` or to the last.
fn compare(geometry: &mut Geometry, set: &str, rays: usize, opponents: usize, ways: &[Way]) {
    let mut seconds = vec![Vec::new(); ways.len()];
    let mut found = vec![0; ways.len()];
    for _ in 0..=REPEATS {
        for (i, way) in ways.iter().enumerate() {
            geometry.use_instructions(way.instructions);
            let start = clock::thread_seconds();
            found[i] = black_box((way.trace)(geometry));
            seconds[i].push(clock::thread_seconds() - start);
        }
    }
    let medians: Vec<f64> = seconds
        .iter_mut()
        .map(|times| {
            // The first round is for the caches.
            times.remove(0);
            times.sort_by(f64::total_cmp);
            times[times.len() / 2]
        })
        .collect();
    let reference = medians[..opponents]
        .iter()
        .copied()
        .min_by(f64::total_cmp)
        .unwrap_or(medians[medians.len() - 1]);
    println!("{set}: {rays} rays");
    for ((way, median), found) in ways.iter().zip(&medians).zip(&found) {
        let rate = rays as f64 / median * 1e-6;
        println!(
            "  {:32} {rate:8.2} M/s {:6.2}x  {found} hits",
            way.name,
            reference / median
        );
    }
}

fn nearest(geometry: &mut Geometry, embree: Option<&Embree>, set: &str, rays: &[Ray]) {
    let mut ways = Vec::new();
    if let Some(embree) = embree {
        ways.push(foreign("Embree single", move || {
            rays.iter()
                .filter(|ray| embree.intersect(ray) < f32::INFINITY)
                .count() as u64
        }));
    }
    let opponents = ways.len();
    ways.extend(own("own", |geometry: &Geometry| {
        rays.iter()
            .filter(|ray| geometry.intersect(ray).is_some())
            .count() as u64
    }));
    compare(
        geometry,
        &format!("{set}, nearest"),
        rays.len(),
        opponents,
        &ways,
    );
    if let Some(embree) = embree {
        let differing = rays.iter().filter(|ray| {
            let (t, e) = (
                geometry.intersect(ray).map(|hit| hit.t),
                embree.intersect(ray),
            );
            t.map_or(e < f32::INFINITY, |t| (t - e).abs() > 1e-3 * t)
        });
        println!("  {} differ", differing.count());
    }
}

fn occlusion(geometry: &mut Geometry, embree: Option<&Embree>, set: &str, segments: &[Segment]) {
    let mut ways = Vec::new();
    if let Some(embree) = embree {
        ways.push(foreign("Embree single", move || {
            segments
                .iter()
                .filter(|segment| embree.occluded(segment))
                .count() as u64
        }));
    }
    let opponents = ways.len();
    ways.extend(own("own", |geometry: &Geometry| {
        segments
            .iter()
            .filter(|segment| geometry.occluded(segment))
            .count() as u64
    }));
    compare(
        geometry,
        &format!("{set}, any"),
        segments.len(),
        opponents,
        &ways,
    );
    if let Some(embree) = embree {
        let differing = segments
            .iter()
            .filter(|s| geometry.occluded(s) != embree.occluded(s));
        println!("  {} differ", differing.count());
    }
}

fn block_visibility(geometry: &mut Geometry, embree: Option<&Embree>, set: &str, blocks: &[Block]) {
    let mut ways = Vec::new();
    if let Some(embree) = embree {
        for coherent in [true, false] {
            ways.extend(embree_packets::<8>(embree, blocks, coherent));
            ways.extend(embree_packets::<16>(embree, blocks, coherent));
        }
    }
    let opponents = ways.len();
    ways.extend(own("own block", |geometry: &Geometry| {
        let masks = blocks.iter().map(|block| own_block(geometry, block));
        masks.flatten().map(|m| u64::from(m.count_ones())).sum()
    }));
    ways.extend(own("own packet", |geometry: &Geometry| {
        let masks = blocks.iter().map(|block| own_packets(geometry, block));
        masks.flatten().map(|m| u64::from(m.count_ones())).sum()
    }));
    let rays = blocks.iter().map(Block::count).sum();
    compare(geometry, &format!("block, {set}"), rays, opponents, &ways);
    for instructions in Instructions::available() {
        geometry.use_instructions(instructions);
        let (mut from_single, mut from_embree) = (0, 0);
        for block in blocks {
            let masks = own_block(geometry, block);
            let single = |from: Vec3, i: usize| {
                let to = block.targets[i];
                geometry.occluded(&Segment { from, to })
            };
            let mut other = [0; workload::BLOCK];
            if let Some(embree) = embree {
                other = by_point::<16>(embree, block, false);
            }
            for (p, &from) in block.origins.iter().enumerate() {
                from_embree += (masks[p] ^ other[p]).count_ones();
                for i in (0..block.targets.len()).filter(|&i| block.wanted[p] >> i & 1 == 1) {
                    from_single += u32::from(single(from, i) != (masks[p] >> i & 1 == 1));
                }
            }
        }
        println!(
            "  {instructions:?}: {from_single} of single rays differ, {from_embree} of Embree"
        );
    }
}

fn own_block(geometry: &Geometry, block: &Block) -> [u64; workload::BLOCK] {
    geometry.occluded_block(&block.origins, &block.targets, &block.wanted)
}

fn own_packets(geometry: &Geometry, block: &Block) -> [u64; workload::BLOCK] {
    let mut blocked = [0; workload::BLOCK];
    for ((&from, &wanted), blocked) in block.origins.iter().zip(&block.wanted).zip(&mut blocked) {
        let mut targets = [Vec3::ZERO; workload::BLOCK];
        let mut count = 0;
        for i in (0..block.targets.len()).filter(|i| wanted >> i & 1 == 1) {
            targets[count] = block.targets[i];
            count += 1;
        }
        // Which bit is which does not matter here.
        *blocked = geometry.occluded_packet(from, &targets[..count]);
    }
    blocked
}

/// Packets of `N` rays from common points, and to common lights.
fn embree_packets<'a, const N: usize>(
    embree: &'a Embree,
    blocks: &'a [Block],
    coherent: bool,
) -> [Way<'a>; 2] {
    let kind = if coherent { "coherent" } else { "incoherent" };
    [
        foreign(&format!("Embree x{N} {kind}, by light"), move || {
            let masks = blocks.iter().map(|b| by_light::<N>(embree, b, coherent));
            masks.flatten().map(|m| u64::from(m.count_ones())).sum()
        }),
        foreign(&format!("Embree x{N} {kind}, by point"), move || {
            let masks = blocks.iter().map(|b| by_point::<N>(embree, b, coherent));
            masks.flatten().map(|m| u64::from(m.count_ones())).sum()
        }),
    ]
}

/// Groups of `N` points, coordinate by coordinate; the last point stands in for those that lack.
fn columns<const N: usize>(points: &[Vec3]) -> Vec<[[f32; N]; 3]> {
    let last = points.len() - 1;
    let at = |i: usize| points[i.min(last)];
    let group = |first| std::array::from_fn(|axis| std::array::from_fn(|i| at(first + i)[axis]));
    (0..workload::BLOCK).step_by(N).map(group).collect()
}

fn by_point<const N: usize>(
    embree: &Embree,
    block: &Block,
    coherent: bool,
) -> [u64; workload::BLOCK] {
    let targets = columns::<N>(&block.targets);
    let mut blocked = [0; workload::BLOCK];
    for ((&from, &wanted), blocked) in block.origins.iter().zip(&block.wanted).zip(&mut blocked) {
        for (group, to) in targets.iter().enumerate() {
            let wanted = (wanted >> (N * group)) as u32 & ((1 << N) - 1);
            if wanted != 0 {
                let found = embree.occluded_packet(from, to, wanted, coherent);
                *blocked |= u64::from(found) << (N * group);
            }
        }
    }
    blocked
}

fn by_light<const N: usize>(
    embree: &Embree,
    block: &Block,
    coherent: bool,
) -> [u64; workload::BLOCK] {
    let points = columns::<N>(&block.origins);
    let mut blocked = [0u64; workload::BLOCK];
    for (light, &from) in block.targets.iter().enumerate() {
        for (group, to) in points.iter().enumerate() {
            let rows = block.wanted.iter().skip(N * group).take(N).rev();
            let wanted = rows.fold(0, |bits, row| bits << 1 | (row >> light & 1) as u32);
            if wanted != 0 {
                let found = embree.occluded_packet(from, to, wanted, coherent);
                for i in (0..N).filter(|i| found >> i & 1 == 1) {
                    blocked[N * group + i] |= 1 << light;
                }
            }
        }
    }
    blocked
}
