//! Emitters and directions sampled at gather points, in packets of one material.

use super::gather_points::GatherPoint;
use super::gather_vertices::{GatherRole, GatherVertex};
use super::paths::{Direction, PathPart, PathState};
use super::prepared::PreparedPasses;
use crate::bsdf::{Bsdf, Lobes, Numbers};
use crate::color::Rgb;
use crate::film::Layer;
use crate::geometry::{Derivatives, Ray, SurfacePoints};
use crate::ids::MaterialId;
use crate::integrators::connections::{Connection, Connections};
use crate::lanes::{Color, Float, Mask, Pair, Vector, Width, lane};
use crate::math::Vec3;
use crate::sampling::LowDiscrepancySequence;
use crate::simd::set_bits;
use crate::transport::direct::EmitterSamples;
use crate::transport::stream::{PacketShader, WalkRow, Walks, lanes_where, used};
use crate::transport::walk::Previous;

/// Samples emitters and directions at gather points.
pub(super) struct Sampling<'a, 's> {
    pub(super) prepared: &'a PreparedPasses<'s>,
    pub(super) points: &'a [GatherPoint<'s>],
    pub(super) vertices: &'a mut [GatherVertex],
    pub(super) connections: &'a mut Connections,
    /// The paths along the directions.
    pub(super) next: &'a mut Walks<PathState>,
}

impl PacketShader for Sampling<'_, '_> {
    #[inline(always)]
    fn shade<S: Width>(&mut self, s: S, material: MaterialId, packet: &[u32]) {
        let packet = self.packet(s, material, packet);
        self.sample_emitters(&packet);
        self.sample_directions(&packet);
    }
}

/// The gather points of a tile from index `first` on, by material; those of one material in their order.
pub(super) fn in_order_of_material(points: &[GatherPoint], first: usize) -> Vec<u32> {
    let mut order: Vec<u32> = (first as u32..points.len() as u32).collect();
    order.sort_by_key(|&i| points[i as usize].material.0);
    order
}

/// Emitter samples per direction at a gather point.
fn emitter_samples(prepared: &PreparedPasses, role: GatherRole) -> u32 {
    match role {
        GatherRole::FirstVertex { .. } => prepared.emitter_samples,
        GatherRole::Compensation { .. } | GatherRole::BehindSpecularChain => 1,
    }
}

/// The gather points of a packet.
struct Packet<'a, S: Width> {
    /// Indices in the tile; in unused lanes the first.
    index: S::Each<u32>,
    used: Mask<S>,
    x: SurfacePoints<S>,
    bsdf: Bsdf<'a, S>,
    wo: Vector<S>,
    /// Number of directions.
    counts: S::Each<u32>,
    /// Emitter samples per direction.
    per_direction: S::Each<u32>,
    /// Throughput over the number of directions.
    throughput: Color<S>,
    /// Normals of the sides from which light counts, and the lanes where only one side counts.
    lit_from: (Vector<S>, Mask<S>),
}

impl<'a, 's> Sampling<'a, 's> {
    #[inline(always)]
    fn packet<S: Width>(&self, s: S, material: MaterialId, packet: &[u32]) -> Packet<'a, S> {
        let scene = self.prepared.scene;
        let index = s.each(|i| packet[if i < packet.len() { i } else { 0 }]);
        let vertex = |i: usize| &self.vertices[index.as_ref()[i] as usize];
        let point = |i: usize| &self.points[index.as_ref()[i] as usize];
        let derivatives = match scene.materials.has_tilts(material) {
            true => Derivatives::OfPosition,
            false => Derivatives::Unspecified,
        };
        let x = scene
            .geometry
            .surface_points(s, &s.each(|i| point(i).at.x.at), derivatives);
        let lit_from = |i: usize| vertex(i).role.lit_from();
        let used = used(packet.len());
        let is_limited = lanes_where(used, |i| lit_from(i).is_some());
        Packet {
            bsdf: scene.materials.bsdfs(material, &x, &scene.textures),
            used: Mask::from_bits(s, used),
            x,
            wo: Vector::from_fn(s, |i| point(i).at.wo),
            counts: s.each(|i| vertex(i).numbers.count),
            per_direction: s.each(|i| emitter_samples(self.prepared, vertex(i).role)),
            throughput: Color::from_fn(s, |i| point(i).throughput / vertex(i).numbers.count as f32),
            lit_from: (
                Vector::from_fn(s, |i| lit_from(i).unwrap_or(Vec3::ZERO)),
                Mask::from_bits(s, is_limited),
            ),
            index,
        }
    }

    /// Adds light of sampled emitters; directions are the other half of MIS.
    #[inline(always)]
    fn sample_emitters<S: Width>(&mut self, v: &Packet<S>) {
        let (prepared, points, s) = (self.prepared, self.points, v.used.width());
        let vertices = &*self.vertices;
        let vertex = |i: usize| &vertices[v.index.as_ref()[i] as usize];
        let normals = v.bsdf.receiving_normals(v.wo);
        let guides = s.each(|i| vertex(i).environment.as_ref());
        let has_guides = guides.as_ref().iter().any(|guide| guide.is_some());
        let guides = has_guides.then_some(&guides);
        let limits = Float::from_fn(s, |i| vertex(i).role.direction_limit());
        let per_direction = Float::from_fn(s, |i| v.per_direction.as_ref()[i] as f32);
        let throughput = v.throughput / per_direction;
        let count = |i: usize| v.counts.as_ref()[i] * v.per_direction.as_ref()[i];
        let most = (0..S::LANES).fold(0, |most, i| most.max(count(i)));
        for k in 0..most {
            let lanes = v.lanes(|i| k < count(i));
            let numbers = triples(s, |i| {
                let numbers = &vertex(i).numbers;
                let first = numbers.first * v.per_direction.as_ref()[i];
                (numbers.emitters, first + k)
            });
            let scene = prepared.scene;
            let lights = EmitterSamples::new(scene, &v.x, normals, numbers, guides, lanes);
            if lights.valid.none() {
                continue;
            }
            let (f_cos, pdf) = v.bsdf.responses(lights.wi, v.wo, Lobes::NON_SPECULAR);
            let fraction = (limits / f_cos.max_channel()).min(1.0);
            let weight = fraction * lights.mis_weight(pdf / per_direction);
            let radiance = throughput * lights.weight * f_cos * weight;
            let counts = lights.valid & v.is_lit(lights.wi) & !f_cos.is_black();
            let radiance = radiance.store();
            let connection = |i: usize| {
                let layer = vertex(i).stage_of_directions().layer();
                let segments = points[v.index.as_ref()[i] as usize].segments;
                Connection {
                    pixel: vertex(i).path.pixel,
                    max_crossings: prepared.limits.left_after(segments + 1),
                    terms: [
                        (layer, Rgb::from(lane(&radiance, i))),
                        (Layer::Direct, Rgb::BLACK),
                    ],
                }
            };
            (self.connections).push_lanes(&lights, counts.bits(), connection);
        }
    }

    /// Samples directions of the non-specular lobes.
    #[inline(always)]
    fn sample_directions<S: Width>(&mut self, v: &Packet<S>) {
        let s = v.used.width();
        let n = v.bsdf.receiving_normals(v.wo);
        let (p, normal, one_sided) = (v.x.p.store(), n.0.store(), n.1.bits());
        let per_direction = Float::from_fn(s, |i| v.per_direction.as_ref()[i] as f32);
        let most = v.counts.as_ref().iter().fold(0, |most, &n| n.max(most));
        for k in 0..most {
            let lanes = v.lanes(|i| k < v.counts.as_ref()[i]);
            let (lobe, direction) = triples(s, |i| {
                let numbers = &self.vertices[v.index.as_ref()[i] as usize].numbers;
                (numbers.directions, numbers.first + k)
            });
            let numbers = Numbers { lobe, direction };
            let sample = v.bsdf.sample_each_wi(v.wo, numbers, Lobes::NON_SPECULAR);
            let alive = lanes & sample.valid & !sample.weight.is_black() & v.is_lit(sample.w);
            if alive.none() {
                continue;
            }
            let (f_cos, _) = v.bsdf.responses(sample.w, v.wo, Lobes::NON_SPECULAR);
            let (f_cos, throughput) = (f_cos.store(), (v.throughput * sample.weight).store());
            let (origin, w) = (v.x.offset_towards(sample.w).store(), sample.w.store());
            // For MIS against several emitter samples per direction.
            let pdf = (sample.pdf / per_direction).store();
            let (lobe, eta) = (sample.lobe.store(), sample.eta.store());
            for i in set_bits(alive.bits()) {
                let from = v.index.as_ref()[i];
                let point = &self.points[from as usize];
                let vertex = &mut self.vertices[from as usize];
                let eta = eta.as_ref()[i];
                self.next.push(WalkRow {
                    ray: Ray::new(Vec3::from(lane(&origin, i)), Vec3::from(lane(&w, i))),
                    throughput: lane(&throughput, i),
                    eta_squared: vertex.path.eta_squared * eta * eta,
                    segments: point.segments,
                    previous: Previous {
                        p: Vec3::from(lane(&p, i)),
                        n: (one_sided >> i & 1 != 0).then(|| Vec3::from(lane(&normal, i))),
                        event: Lobes(lobe.as_ref()[i] as u8),
                        pdf: pdf.as_ref()[i],
                    },
                    sampler: vertex.sampler.branch(),
                    kept: PathState {
                        pixel: vertex.path.pixel,
                        stage: vertex.stage_of_directions(),
                        part: PathPart::Direction(Direction {
                            from,
                            f_cos: Rgb::from(lane(&f_cos, i)),
                            max_photon_radius: vertex.path.max_photon_radius,
                        }),
                    },
                });
            }
        }
    }
}

impl<S: Width> Packet<'_, S> {
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
