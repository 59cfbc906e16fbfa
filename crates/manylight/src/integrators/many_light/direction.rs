//! Sampled directions: camera paths that leave a gather point along a direction drawn from its
//! non-specular lobes. They look for emitters, for light that clamping removes from the sum over
//! virtual lights, and for specular surfaces.
//!
//! Directions and samples of emitters are drawn at the new gather points of a round, in packets of
//! one material. The directions are paths of the next round.

use super::Compensation;
use super::PreparedPasses;
use super::compensation::{DirectionEnd, compensate};
use super::compensation_photons::{direction_fraction, direction_fractions};
use super::gather_point::{GatherPoint, GatherRole, TileGather};
use super::paths::GroupScales;
use super::paths::{Direction, PathPart, PathState};
use crate::bsdf::{BsdfSamples, Lobes, Numbers};
use crate::color::Rgb;
use crate::film::Layer;
use crate::ids::{LightGroup, MaterialId};
use crate::integrators::camera_round::Arrived;
use crate::integrators::connections::{
    Connections, EmitterQuery, EmitterReflection, ReflectingPath,
};
use crate::lanes::{Color, Float, Mask, Pair, Vector, Width, lane};
use crate::math::Vec3;
use crate::sampling::LowDiscrepancySequence;
use crate::scene::LimitedScene;
use crate::simd::set_bits;
use crate::transport::direct::EmitterSamples;
use crate::transport::stream::{
    Bits, PacketShader, SegmentEnd, Vertices, Walks, by_lane, lanes_where, used,
};

/// Samples emitters and directions at gather points.
pub(super) struct Sampling<'a, 's> {
    pub(super) prepared: &'a PreparedPasses<'s>,
    pub(super) points: &'a mut [GatherPoint<'s>],
    pub(super) connections: &'a mut Connections,
    pub(super) scales: &'a GroupScales,
    /// The paths along the directions.
    pub(super) next: &'a mut Walks<PathState>,
}

/// The gather points of a tile from index `first` on, by material; those of one material in their
/// order.
pub(super) fn in_order_of_material(points: &[GatherPoint], first: usize) -> Vec<u32> {
    let mut order: Vec<u32> = (first as u32..points.len() as u32).collect();
    order.sort_by_key(|&i| points[i as usize].material.0);
    order
}

/// Emitter samples per direction at a gather point.
fn emitter_samples(prepared: &PreparedPasses, role: GatherRole) -> u32 {
    match role {
        GatherRole::FirstVertex(_) => prepared.emitter_samples,
        GatherRole::Compensation { .. } | GatherRole::BehindSpecularChain => 1,
    }
}

/// The gather points of a packet.
struct Packet<'v, S: Width> {
    v: &'v Vertices<'v, S>,
    used: Mask<S>,
    /// Number of directions.
    counts: S::Each<u32>,
    /// Emitter samples per direction.
    per_direction: S::Each<u32>,
    /// Throughput over the number of directions.
    throughput: Color<S>,
    /// Normals of the sides from which light counts, and the lanes where only one side counts.
    lit_from: (Vector<S>, Mask<S>),
}

impl PacketShader for Sampling<'_, '_> {
    #[inline(always)]
    fn shade<S: Width>(&mut self, s: S, material: MaterialId, packet: &[u32]) {
        let mut v = vertices(s, self.prepared, self.points, material, packet);
        v.add_leaves(self.prepared.scene, material);
        let packet = Packet::new(s, self.prepared, self.points, &v, packet.len());
        self.sample_emitters(&packet);
        self.sample_directions(&packet);
    }
}

impl Sampling<'_, '_> {
    /// Next-event estimation; directions are the other half of MIS.
    #[inline(always)]
    fn sample_emitters<S: Width>(&mut self, packet: &Packet<S>) {
        let (prepared, points, s) = (self.prepared, &*self.points, packet.used.width());
        let point = |i: usize| &points[packet.v.index.as_ref()[i] as usize];
        let guides = s.each(|i| point(i).environment.as_ref());
        let has_guides = guides.as_ref().iter().any(|guide| guide.is_some());
        let per_direction = packet.emitters_per_direction();
        let reflection = AtGatherPoints {
            packet,
            points,
            scales: self.scales,
            per_direction,
            throughput: packet.throughput / per_direction,
            limits: Float::from_fn(s, |i| point(i).role.direction_limit()),
        };
        let count = |i: usize| packet.counts.as_ref()[i] * packet.per_direction.as_ref()[i];
        let most = (0..S::LANES).fold(0, |most, i| most.max(count(i)));
        for k in 0..most {
            let numbers = triples(s, |i| {
                let numbers = &point(i).numbers;
                let first = numbers.first * packet.per_direction.as_ref()[i];
                (numbers.emitters, first + k)
            });
            let query = EmitterQuery {
                numbers,
                guides: has_guides.then_some(&guides),
                lanes: packet.lanes(|i| k < count(i)),
            };
            let scene = LimitedScene {
                scene: prepared.scene,
                limits: prepared.limits,
            };
            (self.connections).connect_emitters(scene, packet.v, query, &reflection);
        }
    }

    /// Samples directions of the non-specular lobes.
    #[inline(always)]
    fn sample_directions<S: Width>(&mut self, packet: &Packet<S>) {
        let (v, s) = (packet.v, packet.used.width());
        let index = |i: usize| v.index.as_ref()[i];
        let per_direction = packet.emitters_per_direction();
        let path_eta_squared = Float::from_fn(s, |i| {
            let point = &self.points[index(i) as usize];
            point.path.eta_squared
        });
        let counts = packet.counts.as_ref();
        let most = counts.iter().fold(0, |most, &n| n.max(most));
        for k in 0..most {
            let lanes = packet.lanes(|i| k < counts[i]);
            let (lobe, direction) = triples(s, |i| {
                let numbers = &self.points[index(i) as usize].numbers;
                (numbers.directions, numbers.first + k)
            });
            let numbers = Numbers { lobe, direction };
            let sample = v
                .bsdf
                .sample_each_wi(v.w_prev, numbers, Lobes::NON_SPECULAR);
            let alive = lanes & sample.valid & !sample.weight.is_black() & packet.is_lit(sample.w);
            if alive.none() {
                continue;
            }
            let (f_cos, _) = v.bsdf.responses(sample.w, v.w_prev, Lobes::NON_SPECULAR);
            let f_cos = f_cos.store();
            // For MIS against several emitter samples per direction.
            let sample = BsdfSamples {
                pdf: sample.pdf / per_direction,
                ..sample
            };
            let throughput = packet.throughput * sample.weight;
            let eta_squared = path_eta_squared * sample.eta * sample.eta;
            let segments = v.next_camera_segments(&sample, throughput, eta_squared);
            for i in set_bits(alive.bits()) {
                let point = &mut self.points[index(i) as usize];
                let path = PathState {
                    pixel: point.path.pixel,
                    stage: point.path.stage_of_directions(),
                    part: PathPart::Direction(Direction {
                        from: index(i),
                        f_cos: Rgb::from(lane(&f_cos, i)),
                        max_photon_radius: point.path.max_photon_radius,
                    }),
                };
                self.next
                    .push(segments.row(i, point.sampler.branch(), path));
            }
        }
    }
}

/// The gather points `packet` as the ends of segments, before [`Vertices::add_leaves`].
#[inline(always)]
fn vertices<'s, S: Width>(
    s: S,
    prepared: &PreparedPasses<'s>,
    points: &[GatherPoint],
    material: MaterialId,
    packet: &[u32],
) -> Vertices<'s, S> {
    let index = by_lane(s, packet);
    let point = |i: usize| &points[index.as_ref()[i] as usize];
    let ends = s.each(|i| SegmentEnd {
        at: point(i).at.x.at,
        distance: 0.0,
        w_prev: point(i).at.wo,
        segments: point(i).path.segments,
    });
    Vertices::at_ends(s, prepared.scene, material, index, &ends)
}

impl<'v, S: Width> Packet<'v, S> {
    /// The first `count` of the gather points `v`.
    #[inline(always)]
    fn new(
        s: S,
        prepared: &PreparedPasses,
        points: &[GatherPoint],
        v: &'v Vertices<'v, S>,
        count: usize,
    ) -> Self {
        let point = |i: usize| &points[v.index.as_ref()[i] as usize];
        let used = used(count);
        let is_limited = lanes_where(used, |i| point(i).at.lit_from.is_some());
        Packet {
            used: Mask::from_bits(s, used),
            counts: s.each(|i| point(i).numbers.count),
            per_direction: s.each(|i| emitter_samples(prepared, point(i).role)),
            throughput: Color::from_fn(s, |i| {
                point(i).path.throughput / point(i).numbers.count as f32
            }),
            lit_from: (
                Vector::from_fn(s, |i| point(i).at.lit_from.unwrap_or(Vec3::ZERO)),
                Mask::from_bits(s, is_limited),
            ),
            v,
        }
    }

    #[inline(always)]
    fn emitters_per_direction(&self) -> Float<S> {
        Float::from_fn(self.used.width(), |i| self.per_direction.as_ref()[i] as f32)
    }

    /// The used lanes for which `test` holds.
    #[inline(always)]
    fn lanes(&self, test: impl Fn(usize) -> bool) -> Mask<S> {
        Mask::from_bits(self.used.width(), lanes_where(self.used.bits(), test))
    }

    /// The lanes where light from the directions `wi` counts.
    #[inline(always)]
    fn is_lit(&self, wi: Vector<S>) -> Mask<S> {
        let (n, is_limited) = self.lit_from;
        !is_limited | n.dot(wi).gt(0.0)
    }
}

/// Reflection by the non-specular lobes at gather points.
struct AtGatherPoints<'k, 's, S: Width> {
    packet: &'k Packet<'k, S>,
    points: &'k [GatherPoint<'s>],
    scales: &'k GroupScales,
    /// Emitter samples per direction.
    per_direction: Float<S>,
    /// Throughput over the number of emitter samples.
    throughput: Color<S>,
    /// Direction limits, in 1/sr.
    limits: Float<S>,
}

impl<S: Width> EmitterReflection<S> for AtGatherPoints<'_, '_, S> {
    #[inline(always)]
    fn reflect(&self, lights: &EmitterSamples<S>) -> [Color<S>; 2] {
        let v = self.packet.v;
        let (f_cos, pdf) = (v.bsdf).responses(lights.wi, v.w_prev, Lobes::NON_SPECULAR);
        let fraction = direction_fractions(self.limits, f_cos);
        let weight = fraction * lights.mis_weight(pdf / self.per_direction);
        let radiance = self.throughput * lights.weight * f_cos * weight;
        let is_lit = self.packet.is_lit(lights.wi) & !f_cos.is_black();
        [radiance.within(is_lit), Color::black(weight.width())]
    }

    #[inline(always)]
    fn path(&self, i: usize) -> ReflectingPath {
        let path = &self.points[self.packet.v.index.as_ref()[i] as usize].path;
        ReflectingPath {
            pixel: path.pixel,
            layers: [path.stage_of_directions().layer(), Layer::Direct],
        }
    }

    #[inline(always)]
    fn group_weight(&self, i: usize, group: LightGroup) -> f32 {
        let path = &self.points[self.packet.v.index.as_ref()[i] as usize].path;
        self.scales.of(path.scales, group)
    }
}

/// A point of a sequence per lane.
#[inline(always)]
fn triples<S: Width>(
    s: S,
    point: impl Fn(usize) -> (LowDiscrepancySequence, u32),
) -> (Float<S>, Pair<S>) {
    let all = s.each(|i| {
        let (sequence, index) = point(i);
        sequence.triple(index)
    });
    let all = all.as_ref();
    (
        Float::from_fn(s, |i| all[i].0),
        Pair::from_fn(s, |i| all[i].1),
    )
}

/// Part of the light of an emitter at its end for which a direction accounts.
pub(super) fn emission_fraction(direction: &Direction, points: &[GatherPoint]) -> f32 {
    let limit = points[direction.from as usize].role.direction_limit();
    direction_fraction(limit, direction.f_cos)
}

/// Compensates clamping at the vertices in `lanes` where directions arrive.
#[inline(always)]
pub(super) fn end<S: Width>(tile: &mut TileGather, at: &mut Arrived<S, PathState>, lanes: Bits) {
    let lanes = lanes & at.v.bsdf.has(Lobes::NON_SPECULAR).bits();
    let lanes = lanes_where(lanes, |i| at.paths.as_ref()[i].direction().is_some());
    if lanes == 0 || tile.prepared.compensation == Compensation::None {
        return;
    }
    let v = at.v;
    let n = v.x.normals_towards(v.w_prev);
    let transmits = v.bsdf.transmitting().bits();
    let is_glossy = v.bsdf.has(Lobes::GLOSSY).bits();
    let diffuse_f = match lanes & !is_glossy & !transmits {
        0 => Color::black(n.x.width()),
        _ => v.bsdf.responses(n, v.w_prev, Lobes::DIFFUSE).0,
    };
    let (n, diffuse_f, values) = (n.store(), diffuse_f.store(), at.values());
    for i in set_bits(lanes) {
        let path = at.paths.as_ref()[i];
        let Some(&direction) = path.direction() else {
            continue;
        };
        let end = DirectionEnd {
            path,
            direction,
            throughput: values.throughput(i),
            eta_squared: values.eta_squared(i),
            segments: at.v.segments.as_ref()[i],
            x: *values.x(i),
            material: at.material,
            w_prev: values.w_prev(i),
            n: Vec3::from(lane(&n, i)),
            transmits: transmits >> i & 1 != 0,
            is_glossy: is_glossy >> i & 1 != 0,
            diffuse_f: Rgb::from(lane(&diffuse_f, i)),
        };
        compensate(tile, &end, &mut at.generators.get(i));
    }
}
