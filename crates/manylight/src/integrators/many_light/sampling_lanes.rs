//! Emitters and directions sampled at waiting vertices, in packets of one material.

use super::gather_points::GatherPoint;
use super::gather_vertices::{GatherRole, WaitingVertex};
use super::prepared::PreparedPasses;
use crate::bsdf::{Bsdf, Lobes, Numbers};
use crate::color::Rgb;
use crate::film::Layer;
use crate::geometry::{Derivatives, Ray, Segment, SurfacePoints};
use crate::ids::MaterialId;
use crate::lanes::{Color, Float, Mask, Pair, Vector, Width, lane};
use crate::math::Vec3;
use crate::sampling::LowDiscrepancySequence;
use crate::simd::set_bits;
use crate::transport::direct_lanes::EmitterSamples;
use crate::transport::stream::{PacketShader, lanes_where, used};

/// Light from an emitter that a vertex reflects, visibility not yet tested.
#[derive(Clone, Copy)]
pub(super) struct EmitterTerm {
    /// Index of the pixel in the tile.
    pub(super) pixel: u32,
    pub(super) layer: Layer,
    pub(super) radiance: Rgb,
    /// Transparent surfaces that the shadow ray may cross.
    pub(super) max_crossings: u32,
}

/// A direction sampled at a waiting vertex; the ray is kept apart.
#[derive(Clone, Copy)]
pub(super) struct SampledDirection {
    /// Index among the waiting vertices of the round.
    pub(super) vertex: u32,
    pub(super) throughput: Rgb,
    pub(super) f_cos: Rgb,
    /// Density per solid angle for MIS, in 1/sr.
    pub(super) pdf: f32,
    pub(super) lobe: Lobes,
    pub(super) eta: f32,
}

/// What the vertices of a round sample.
#[derive(Default)]
pub(super) struct SampledRound {
    /// Shadow rays to emitters, and the light that they carry.
    pub(super) shadow_rays: Vec<Segment>,
    pub(super) terms: Vec<EmitterTerm>,
    /// Rays along directions.
    pub(super) rays: Vec<Ray>,
    pub(super) directions: Vec<SampledDirection>,
}

impl SampledRound {
    pub(super) fn clear(&mut self) {
        self.shadow_rays.clear();
        self.terms.clear();
        self.rays.clear();
        self.directions.clear();
    }
}

/// Samples emitters and directions at all waiting vertices.
pub(super) struct Sampling<'a, 'o, 's> {
    pub(super) prepared: &'a PreparedPasses<'s>,
    pub(super) points: &'a [GatherPoint<'s>],
    pub(super) waiting: &'a [WaitingVertex<'s>],
    pub(super) round: &'o mut SampledRound,
}

impl PacketShader for Sampling<'_, '_, '_> {
    #[inline(always)]
    fn shade<S: Width>(&mut self, s: S, material: MaterialId, packet: &[u32]) {
        let packet = self.vertices(s, material, packet);
        self.sample_emitters(&packet);
        self.sample_directions(&packet);
    }
}

/// Emitter samples per direction at a vertex.
fn emitter_samples(prepared: &PreparedPasses, role: GatherRole) -> u32 {
    match role {
        GatherRole::FirstVertex { .. } => prepared.emitter_samples,
        GatherRole::Compensation { .. } | GatherRole::BehindSpecularChain => 1,
    }
}

/// The vertices of a packet.
struct Vertices<'a, S: Width> {
    /// Indices among the waiting vertices; in unused lanes the first.
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
}

impl<'a, 's> Sampling<'a, '_, 's> {
    #[inline(always)]
    fn vertices<S: Width>(&self, s: S, material: MaterialId, packet: &[u32]) -> Vertices<'a, S> {
        let scene = self.prepared.scene;
        let index = s.each(|i| packet[if i < packet.len() { i } else { 0 }]);
        let vertex = |i: usize| &self.waiting[index.as_ref()[i] as usize];
        let point = |i: usize| &self.points[vertex(i).point];
        let derivatives = match scene.materials.has_tilts(material) {
            true => Derivatives::OfPosition,
            false => Derivatives::Unspecified,
        };
        let x = scene
            .geometry
            .surface_points(s, &s.each(|i| point(i).at.x.at), derivatives);
        let counts = s.each(|i| vertex(i).numbers.count);
        let throughput = Color::from_fn(s, |i| {
            vertex(i).path.walk.throughput() / vertex(i).numbers.count as f32
        });
        Vertices {
            bsdf: scene.materials.bsdfs(material, &x, &scene.textures),
            index,
            used: Mask::from_bits(s, used(packet.len())),
            x,
            wo: Vector::from_fn(s, |i| point(i).at.wo),
            counts,
            per_direction: s.each(|i| emitter_samples(self.prepared, vertex(i).role)),
            throughput,
        }
    }

    /// Adds light of sampled emitters; directions are the other half of MIS.
    #[inline(always)]
    fn sample_emitters<S: Width>(&mut self, v: &Vertices<S>) {
        let (prepared, waiting, s) = (self.prepared, self.waiting, v.used.width());
        let vertex = |i: usize| &waiting[v.index.as_ref()[i] as usize];
        let normals = v.bsdf.receiving_normals(v.wo);
        let guides = s.each(|i| vertex(i).environment.as_ref());
        let has_guides = guides.as_ref().iter().any(|guide| guide.is_some());
        let guides = has_guides.then_some(&guides);
        let limits = Float::from_fn(s, |i| vertex(i).role.direction_limit());
        let lit_from = Vector::from_fn(s, |i| vertex(i).role.lit_from().unwrap_or(Vec3::ZERO));
        let is_limited = v.lanes(|i| vertex(i).role.lit_from().is_some());
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
            let is_lit = !is_limited | lit_from.dot(lights.wi).gt(0.0);
            let counts = lights.valid & is_lit & !f_cos.is_black();
            let (from, to) = (lights.from.store(), lights.to.store());
            let radiance = radiance.store();
            for i in set_bits(counts.bits()) {
                let vertex = vertex(i);
                self.round.shadow_rays.push(Segment {
                    from: Vec3::from(lane(&from, i)),
                    to: Vec3::from(lane(&to, i)),
                });
                let segments = self.points[vertex.point].segments;
                self.round.terms.push(EmitterTerm {
                    pixel: vertex.pixel as u32,
                    layer: vertex.path.stage.after(Lobes::DIFFUSE).layer(),
                    radiance: Rgb::from(lane(&radiance, i)),
                    max_crossings: prepared.limits.left_after(segments + 1),
                });
            }
        }
    }

    /// Samples directions of the non-specular lobes.
    #[inline(always)]
    fn sample_directions<S: Width>(&mut self, v: &Vertices<S>) {
        let (waiting, s) = (self.waiting, v.used.width());
        let vertex = |i: usize| &waiting[v.index.as_ref()[i] as usize];
        let per_direction = Float::from_fn(s, |i| v.per_direction.as_ref()[i] as f32);
        let most = v.counts.as_ref().iter().fold(0, |most, &n| n.max(most));
        for k in 0..most {
            let lanes = v.lanes(|i| k < v.counts.as_ref()[i]);
            let (lobe, direction) = triples(s, |i| {
                let numbers = &vertex(i).numbers;
                (numbers.directions, numbers.first + k)
            });
            let numbers = Numbers { lobe, direction };
            let sample = v.bsdf.sample_each_wi(v.wo, numbers, Lobes::NON_SPECULAR);
            let alive = lanes & sample.valid & !sample.weight.is_black();
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
                let ray = Ray::new(Vec3::from(lane(&origin, i)), Vec3::from(lane(&w, i)));
                self.round.rays.push(ray);
                self.round.directions.push(SampledDirection {
                    vertex: v.index.as_ref()[i],
                    throughput: Rgb::from(lane(&throughput, i)),
                    f_cos: Rgb::from(lane(&f_cos, i)),
                    pdf: pdf.as_ref()[i],
                    lobe: Lobes(lobe.as_ref()[i] as u8),
                    eta: eta.as_ref()[i],
                });
            }
        }
    }
}

impl<S: Width> Vertices<'_, S> {
    /// The used lanes for which `test` holds.
    #[inline(always)]
    fn lanes(&self, test: impl Fn(usize) -> bool) -> Mask<S> {
        Mask::from_bits(self.used.width(), lanes_where(self.used.bits(), test))
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
