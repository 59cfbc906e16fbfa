//! Rays per second and thread of single-ray, stream and block queries, compared with other kernels
//! on the same rays.
//!
//! `MANYLIGHT_BENCH_SCENES=a.xml:b.xml cargo bench -p manylight --bench visibility [-- SET...]`,
//! where SET is part of the name of a ray set: `camera`, `bounce`, `random`, `stream`, `tile`,
//! `block` or a number of lights such as `32k`.
//!
//! If `MANYLIGHT_EMBREE` names the shared library of Embree 4, its kernels are the reference;
//! `MANYLIGHT_EMBREE_ISA=avx2` limits them to this instruction set.
#![allow(
    clippy::print_stdout,
    reason = "a benchmark reports on standard output"
)]

#[path = "../shared/clock.rs"]
mod clock;
mod comparison;
mod embree;
mod path_tile;
#[path = "../shared/scene_list.rs"]
mod scene_list;
mod streams;
mod workload;

use comparison::{Comparison, REPEATS, RayKernel, embree_kernel, median, own_kernels};
use embree::{Coherence, Embree};
use manylight::geometry::{Geometry, Instructions, Ray, Segment};
use manylight::math::Vec3;
use std::path::Path;
use workload::{RayBlock, Workload};

/// Numbers of lights in the sets `tile` and `block`.
const LIGHTS: [usize; 4] = [1 << 12, 1 << 15, 1 << 18, 1 << 20];

fn main() {
    let wanted: Vec<String> = std::env::args()
        .skip(1)
        .filter(|argument| argument != "--bench")
        .collect();
    let is_wanted =
        |set: &str| wanted.is_empty() || wanted.iter().any(|part| set.contains(part.as_str()));
    scene_list::for_each_scene(|path| bench_scene(path, &is_wanted));
}

fn bench_scene(path: &Path, is_wanted: &dyn Fn(&str) -> bool) {
    let mut work = Workload::load(path);
    let embree = builds(&work);
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
    if is_wanted("stream") {
        streams::compare(&mut work, embree.as_ref());
    }
    for lights in LIGHTS {
        let set = format!("{}k lights", lights >> 10);
        if is_wanted(&set) || is_wanted("tile") || is_wanted("block") {
            let blocks = work.blocks(lights);
            if is_wanted("tile") {
                let segments: Vec<Segment> = blocks.iter().flat_map(RayBlock::segments).collect();
                let name = format!("tile, {set}");
                occlusion(&mut work.geometry, embree.as_ref(), &name, &segments);
            }
            if is_wanted("block") {
                block_visibility(&mut work.geometry, embree.as_ref(), &set, &blocks);
            }
        }
    }
}

/// Builds in turns, and prints the median times. Returns Embree's last scene.
fn builds(work: &Workload) -> Option<Embree> {
    let count = work.triangles.len() as f64;
    let (mut own, mut whole, mut other, mut embree) = (vec![], vec![], vec![], None);
    for _ in 0..REPEATS {
        let [hierarchy, geometry] = work.build_seconds();
        own.push(hierarchy);
        whole.push(geometry);
        embree = Embree::new(&work.triangles, 0);
        other.extend(embree.as_ref().map(|embree| embree.seconds));
    }
    let bytes = work.geometry.acceleration_bytes() as f64 / count;
    let (own, whole) = (median(&mut own), median(&mut whole));
    println!("{count} triangles");
    println!(
        "build: own {:.3} ms, with the tables of surface points {:.3} ms, {bytes:.0} B/triangle",
        1e3 * own,
        1e3 * whole
    );
    if let Some(embree) = &embree {
        let other = median(&mut other);
        println!(
            "       Embree {:.3} ms, {:.0} B/triangle (48 of them vertices and indices); own takes {:.2} times as long, {:.2} with the tables",
            1e3 * other,
            embree.bytes as f64 / count,
            own / other,
            whole / other
        );
    }
    embree
}

fn nearest(geometry: &mut Geometry, embree: Option<&Embree>, set: &str, rays: &[Ray]) {
    let mut kernels = Vec::new();
    if let Some(embree) = embree {
        kernels.push(embree_kernel("Embree single", move || {
            rays.iter()
                .filter(|ray| embree.intersect(ray) < f32::INFINITY)
                .count() as u64
        }));
    }
    let references = kernels.len();
    kernels.extend(own_kernels("own", |geometry: &Geometry| {
        rays.iter()
            .filter(|ray| geometry.intersect(ray).is_some())
            .count() as u64
    }));
    let comparison = Comparison {
        set: format!("{set}, nearest"),
        rays: rays.len(),
        references,
        kernels,
    };
    comparison.run(geometry);
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
    let mut kernels = Vec::new();
    if let Some(embree) = embree {
        kernels.push(embree_kernel("Embree single", move || {
            segments
                .iter()
                .filter(|segment| embree.occluded(segment))
                .count() as u64
        }));
    }
    let references = kernels.len();
    kernels.extend(own_kernels("own", |geometry: &Geometry| {
        segments
            .iter()
            .filter(|segment| geometry.occluded(segment))
            .count() as u64
    }));
    let comparison = Comparison {
        set: format!("{set}, any"),
        rays: segments.len(),
        references,
        kernels,
    };
    comparison.run(geometry);
    if let Some(embree) = embree {
        let differing = segments
            .iter()
            .filter(|s| geometry.occluded(s) != embree.occluded(s));
        println!("  {} differ", differing.count());
    }
}

fn block_visibility(
    geometry: &mut Geometry,
    embree: Option<&Embree>,
    set: &str,
    blocks: &[RayBlock],
) {
    let mut kernels = Vec::new();
    if let Some(embree) = embree {
        for coherence in [Coherence::Coherent, Coherence::Incoherent] {
            kernels.extend(embree_packets::<8>(embree, blocks, coherence));
            kernels.extend(embree_packets::<16>(embree, blocks, coherence));
        }
    }
    let references = kernels.len();
    kernels.extend(own_kernels("own block", |geometry: &Geometry| {
        let masks = blocks.iter().map(|block| own_block(geometry, block));
        masks.flatten().map(|m| u64::from(m.count_ones())).sum()
    }));
    let comparison = Comparison {
        set: format!("block, {set}"),
        rays: blocks.iter().map(RayBlock::count).sum(),
        references,
        kernels,
    };
    comparison.run(geometry);
    count_block_differences(geometry, embree, blocks);
}

/// Compares block queries with single rays and with Embree, and prints how many segments differ.
fn count_block_differences(geometry: &mut Geometry, embree: Option<&Embree>, blocks: &[RayBlock]) {
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
                other = by_point::<16>(embree, block, Coherence::Incoherent);
            }
            for (p, &from) in block.origins.iter().enumerate() {
                from_embree += (masks[p] ^ other[p]).count_ones();
                for i in (0..block.targets.len()).filter(|&i| block.wanted[p] >> i & 1 == 1) {
                    from_single += u32::from(single(from, i) != (masks[p] >> i & 1 == 1));
                }
            }
        }
        println!(
            "  {instructions:?}: {from_single} segments differ from single rays, {from_embree} from Embree"
        );
    }
}

fn own_block(geometry: &Geometry, block: &RayBlock) -> [u64; workload::BLOCK] {
    geometry.occluded_block(&block.origins, &block.targets, &block.wanted)
}

/// Packets of `N` rays: from one light to `N` points, and from one point to `N` lights.
fn embree_packets<'a, const N: usize>(
    embree: &'a Embree,
    blocks: &'a [RayBlock],
    coherence: Coherence,
) -> [RayKernel<'a>; 2] {
    [
        embree_kernel(&format!("Embree x{N} {coherence:?}, by light"), move || {
            let masks = blocks.iter().map(|b| by_light::<N>(embree, b, coherence));
            masks.flatten().map(|m| u64::from(m.count_ones())).sum()
        }),
        embree_kernel(&format!("Embree x{N} {coherence:?}, by point"), move || {
            let masks = blocks.iter().map(|b| by_point::<N>(embree, b, coherence));
            masks.flatten().map(|m| u64::from(m.count_ones())).sum()
        }),
    ]
}

/// Groups of `N` points in structure-of-arrays form; missing points repeat the last one.
fn columns<const N: usize>(points: &[Vec3]) -> Vec<[[f32; N]; 3]> {
    let last = points.len() - 1;
    let at = |i: usize| points[i.min(last)];
    let group = |first| std::array::from_fn(|axis| std::array::from_fn(|i| at(first + i)[axis]));
    (0..workload::BLOCK).step_by(N).map(group).collect()
}

/// Occlusion bits per point, from packets of one point and `N` lights.
fn by_point<const N: usize>(
    embree: &Embree,
    block: &RayBlock,
    coherence: Coherence,
) -> [u64; workload::BLOCK] {
    let targets = columns::<N>(&block.targets);
    let mut blocked = [0; workload::BLOCK];
    for ((&from, &wanted), blocked) in block.origins.iter().zip(&block.wanted).zip(&mut blocked) {
        for (group, to) in targets.iter().enumerate() {
            let wanted = (wanted >> (N * group)) as u32 & ((1 << N) - 1);
            if wanted != 0 {
                let found = embree.occluded_packet(from, to, wanted, coherence);
                *blocked |= u64::from(found) << (N * group);
            }
        }
    }
    blocked
}

/// Occlusion bits per point, from packets of one light and `N` points.
fn by_light<const N: usize>(
    embree: &Embree,
    block: &RayBlock,
    coherence: Coherence,
) -> [u64; workload::BLOCK] {
    let points = columns::<N>(&block.origins);
    let mut blocked = [0u64; workload::BLOCK];
    for (light, &from) in block.targets.iter().enumerate() {
        for (group, to) in points.iter().enumerate() {
            let rows = block.wanted.iter().skip(N * group).take(N).rev();
            let wanted = rows.fold(0, |bits, row| bits << 1 | (row >> light & 1) as u32);
            if wanted != 0 {
                let found = embree.occluded_packet(from, to, wanted, coherence);
                for i in (0..N).filter(|i| found >> i & 1 == 1) {
                    blocked[N * group + i] |= 1 << light;
                }
            }
        }
    }
    blocked
}
