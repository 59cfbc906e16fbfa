//! Streams of the rays of path tracers beside Embree's packets of sixteen, in the order of the
//! paths.

use super::comparison::{Comparison, RayKernel, embree_kernel, own_kernels};
use super::embree::{Coherence, Embree};
use super::path_tile::{PathTile, path_tiles};
use super::workload::Workload;
use manylight::geometry::{Geometry, Ray, Segment};

/// Rays of a packet of Embree.
const PACKET: usize = 16;

/// A set of rays or segments of a tile.
type OfTile<T> = fn(&PathTile) -> &[T];

/// Compares all sets of the rays of path tracers.
pub(crate) fn compare(work: &mut Workload, embree: Option<&Embree>) {
    let tiles = path_tiles(work);
    let geometry = &mut work.geometry;
    let rays: [(&str, OfTile<Ray>); 3] = [
        ("camera", |tile| &tile.camera),
        ("bounce", |tile| &tile.bounce),
        ("late", |tile| &tile.late),
    ];
    for (set, of_tile) in rays {
        let streams: Vec<&[Ray]> = tiles.iter().map(of_tile).collect();
        nearest(geometry, embree, set, &streams);
    }
    let segments: [(&str, OfTile<Segment>); 2] = [
        ("shadow", |tile| &tile.shadow),
        ("late shadow", |tile| &tile.late_shadow),
    ];
    for (set, of_tile) in segments {
        let streams: Vec<&[Segment]> = tiles.iter().map(of_tile).collect();
        occlusion(geometry, embree, set, &streams);
    }
}

fn nearest(geometry: &mut Geometry, embree: Option<&Embree>, set: &str, streams: &[&[Ray]]) {
    let mut kernels: Vec<RayKernel> = Vec::new();
    if let Some(embree) = embree {
        for coherence in [Coherence::Incoherent, Coherence::Coherent] {
            let name = format!("Embree x16 {coherence:?}");
            kernels.push(embree_kernel(&name, move || {
                let packets = streams.iter().flat_map(|rays| rays.chunks(PACKET));
                let hits = packets.map(|packet| {
                    let distances = embree.intersect16(packet, coherence);
                    let hits = distances[..packet.len()].iter();
                    hits.filter(|&&t| t < f32::INFINITY).count() as u64
                });
                hits.sum()
            }));
        }
    }
    let references = kernels.len();
    kernels.extend(own_kernels("own stream", |geometry: &Geometry| {
        let mut hits = Vec::new();
        let counts = streams.iter().map(|rays| {
            geometry.intersect_stream(rays, &mut hits);
            hits.iter().flatten().count() as u64
        });
        counts.sum()
    }));
    kernels.extend(own_kernels("own single", |geometry: &Geometry| {
        let rays = streams.iter().copied().flatten();
        rays.filter(|ray| geometry.intersect(ray).is_some()).count() as u64
    }));
    report(
        geometry,
        format!("stream of {set} rays, nearest"),
        streams,
        references,
        kernels,
    );
}

fn occlusion(geometry: &mut Geometry, embree: Option<&Embree>, set: &str, streams: &[&[Segment]]) {
    let mut kernels: Vec<RayKernel> = Vec::new();
    if let Some(embree) = embree {
        for coherence in [Coherence::Incoherent, Coherence::Coherent] {
            let name = format!("Embree x16 {coherence:?}");
            kernels.push(embree_kernel(&name, move || {
                let packets = streams.iter().flat_map(|segments| segments.chunks(PACKET));
                let blocked =
                    packets.map(|packet| embree.occluded16(packet, coherence).count_ones());
                blocked.map(u64::from).sum()
            }));
        }
    }
    let references = kernels.len();
    kernels.extend(own_kernels("own stream", |geometry: &Geometry| {
        let mut occluded = Vec::new();
        let counts = streams.iter().map(|segments| {
            geometry.occluded_stream(segments, &mut occluded);
            occluded.iter().filter(|&&occluded| occluded).count() as u64
        });
        counts.sum()
    }));
    kernels.extend(own_kernels("own single", |geometry: &Geometry| {
        let segments = streams.iter().copied().flatten();
        segments
            .filter(|segment| geometry.occluded(segment))
            .count() as u64
    }));
    report(
        geometry,
        format!("stream of {set} rays, any"),
        streams,
        references,
        kernels,
    );
}

fn report<T>(
    geometry: &mut Geometry,
    set: String,
    streams: &[&[T]],
    references: usize,
    kernels: Vec<RayKernel>,
) {
    let comparison = Comparison {
        set,
        rays: streams.iter().map(|rays| rays.len()).sum(),
        references,
        kernels,
    };
    comparison.run(geometry);
}
