//! Gathering at a non-specular vertex `x` of a camera path: light of emitters, the sum over virtual lights, and directions
//! that account for the rest.
//!
//! Emitters are estimated by next-event estimation and by directions, combined by MIS. Directions are sampled from the
//! non-specular lobes at `x`, emitter samples of the environment also from where its photons arrive. A direction that meets a
//! surface continues in two ways:
//!
//! * by bias compensation of the sum over virtual lights (`compensation.rs`);
//! * by specular events, if a glossy lobe at `x` meets a specular surface (`specular_chains.rs`).
//!
//! Both gather again at the vertex where they end, on a sparse subset of the lights.

use super::axes::Compensation;
use super::compensation_photons::direction_fraction;
use super::gather_points::{GatherPoint, PixelGather};
use super::gather_vertices::{
    DirectionNumbers, GatherDirection, GatherPath, GatherRole, WaitingVertex,
};
use crate::bsdf::Lobes;
use crate::emitters::EnvironmentLobes;
use crate::gather::{ShadingPoint, Subset};
use crate::integrators::guiding::environment_guide;
use crate::math::Vec3;
use crate::transport::{Vertex, next_scattering_vertex};

/// Directions at the first gather points of the camera paths of a pixel, together. Unmeasured: they cost
/// little beside the sum over all lights.
pub(super) const DIRECTIONS: u32 = 16;
/// Fewest directions at a point for which a query of the area per light pays. Unmeasured.
const AREA_QUERY_DIRECTIONS: u32 = 4;
/// Growth of the largest radius of density estimates per length of segments after a non-specular event, in rad: caustics seen
/// by such events may be blurred more. Unmeasured.
const INDIRECT_RADIUS_ANGLE: f32 = 0.02;

/// How light that emitters send along a direction is estimated.
#[derive(Clone, Copy)]
pub(super) enum EmittedLight<'g> {
    /// By directions, up to this fraction; only on the side of the normal, if given. The environment as in [`GatherDirection`].
    Directions {
        fraction: f32,
        lit_from: Option<Vec3>,
        environment: Option<&'g EnvironmentLobes>,
    },
    /// By photons.
    Photons,
}

impl<'s> PixelGather<'_, 's, '_, '_> {
    /// Estimates all light that the non-specular lobes of `v`, the end of `path`, reflect: the sum over `lights`, as a gather point;
    /// emitters, and what directions account for, as a vertex that waits (`waiting.rs`).
    pub(super) fn gather(
        &mut self,
        v: &Vertex<'s>,
        path: GatherPath<'s>,
        role: GatherRole,
        lights: Subset,
        numbers: DirectionNumbers,
    ) {
        let prepared = self.prepared;
        let compensates = prepared.compensation == Compensation::KolligKeller;
        let area_per_light = (compensates && numbers.count >= AREA_QUERY_DIRECTIONS)
            .then(|| self.area_per_light(v.x.p));
        let environment = environment_guide(&prepared.incident, v, &mut self.tile.found);
        let primitive = &prepared.scene.geometry.primitives()[v.x.at.primitive.index()];
        let vertex = WaitingVertex {
            pixel: self.pixel,
            point: self.add_gather_point(v, &path, role, lights),
            material: primitive.material,
            path,
            role,
            numbers,
            sampler: self.sampler.branch(),
            first_weight: self.first_weight,
            area_per_light,
            environment,
        };
        self.tile.waiting.push(vertex);
    }

    /// The vertex `v` becomes a gather point. Returns its index in the tile.
    fn add_gather_point(
        &mut self,
        v: &Vertex<'s>,
        path: &GatherPath<'s>,
        role: GatherRole,
        lights: Subset,
    ) -> usize {
        let limits = self.prepared.limits;
        let at = ShadingPoint {
            x: v.x,
            wo: v.w_prev,
            bsdf: v.bsdf,
            max_photon_depth: limits.max_depth.map(|max| max - (v.segments + 1)),
            u: self.sampler.next_1d(),
            lights,
            tolerance: 0.0,
            lit_from: role.lit_from(),
        };
        self.tile.points.push(GatherPoint {
            pixel: self.pixel,
            throughput: path.walk.throughput(),
            segments: v.segments,
            at,
            stage: path.stage,
            max_photon_radius: path.max_photon_radius,
            direction_limit: role.direction_limit(),
            photon_weight: role.photon_weight(),
        });
        self.tile.points.len() - 1
    }

    /// Follows a path along the direction `w` sampled at a gather point: adds the emitter there, compensates clamping, and follows
    /// specular events.
    pub(super) fn follow_direction(
        &mut self,
        mut path: GatherPath<'s>,
        from: &GatherDirection,
        w: Vec3,
    ) {
        path.stage = path.stage.after(Lobes::DIFFUSE);
        let max_photon_radius = path.max_photon_radius;
        let emitted = EmittedLight::Directions {
            fraction: direction_fraction(from.role.direction_limit(), from.f_cos),
            lit_from: from.role.lit_from(),
            environment: from.environment,
        };
        let Some(y) = self.next_vertex(&mut path, emitted) else {
            return;
        };
        if from.is_glossy && y.bsdf.lobes().has(Lobes::SPECULAR) {
            let by_photons = self.chain_fraction_of_photons(from, w, max_photon_radius);
            let bsdf = &self.tile.points[from.point].at.bsdf;
            let f = |lobes| bsdf.f(w, from.wo, lobes);
            let glossy_fraction = f(Lobes::GLOSSY).zip(f(Lobes::NON_SPECULAR), |part, all| {
                if all > 0.0 { part / all } else { 0.0 }
            });
            let fraction = glossy_fraction * (1.0 - by_photons);
            self.follow_specular_chain(y.clone(), path.clone(), fraction);
        }
        if y.bsdf.lobes().has(Lobes::NON_SPECULAR)
            && self.prepared.compensation == Compensation::KolligKeller
        {
            self.compensate(&y, path, from);
        }
    }

    /// Follows a path to the next vertex that scatters, and adds the light of emitters on the way. `None`: the path ends.
    pub(super) fn next_vertex(
        &mut self,
        path: &mut GatherPath<'s>,
        emitted: EmittedLight,
    ) -> Option<Vertex<'s>> {
        let limits = self.prepared.limits;
        let GatherPath {
            walk,
            stage,
            max_photon_radius,
        } = path;
        let (out, pixel, layer) = (&mut *self.tile.out, self.pixel, stage.layer());
        let environment = match emitted {
            EmittedLight::Directions { environment, .. } => environment,
            EmittedLight::Photons => None,
        };
        let sampler = &mut *self.sampler;
        next_scattering_vertex(limits, walk, environment, sampler, |step, throughput, _| {
            if let EmittedLight::Directions {
                fraction, lit_from, ..
            } = emitted
            {
                if lit_from.is_some_and(|n| step.wi.dot(n) <= 0.0) {
                    return false;
                }
                out.add(pixel, layer, throughput * (step.emitted * fraction));
            }
            if let Some(y) = &step.vertex {
                *max_photon_radius += INDIRECT_RADIUS_ANGLE * y.distance;
            }
            true
        })
    }
}
