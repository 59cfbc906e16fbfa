//! Gathering at a non-specular vertex `x` of a camera path: light of emitters, the sum over virtual lights, and directions
//! that account for the rest.
//!
//! Emitters are estimated by next-event estimation and by directions, combined by MIS. Directions are sampled from the
//! non-specular lobes at `x`, emitter samples of the environment also from where its photons arrive (`sampling_lanes.rs`). A direction that
//! meets a surface continues in two ways:
//!
//! * by bias compensation of the sum over virtual lights (`compensation.rs`);
//! * by specular events, if a glossy lobe at `x` meets a specular surface (`specular_chains.rs`).
//!
//! Both gather again at the vertex where they end, on a sparse subset of the lights.

use super::gather_points::{GatherPoint, TileGather};
use super::gather_vertices::{DirectionNumbers, GatherPath, GatherRole, GatherVertex};
use super::settings::Compensation;
use crate::gather::{ShadingPoint, Subset};
use crate::integrators::guiding::environment_guide;
use crate::sampling::Sampler;
use crate::transport::Vertex;

/// Directions at the first gather points of the camera paths of a pixel, together. Unmeasured: they cost
/// little beside the sum over all lights.
pub(super) const DIRECTIONS: u32 = 16;
/// Fewest directions at a point for which a query of the area per light pays. Unmeasured.
const AREA_QUERY_DIRECTIONS: u32 = 4;

/// What is gathered at a vertex.
pub(super) struct GatherTask {
    /// The path that ends there.
    pub(super) path: GatherPath,
    pub(super) role: GatherRole,
    pub(super) lights: Subset,
    pub(super) numbers: DirectionNumbers,
}

impl<'s> TileGather<'s, '_, '_> {
    /// The vertex `v` becomes a gather point: all light that its non-specular lobes reflect is estimated later, with that of the other
    /// points of the tile.
    pub(super) fn gather(&mut self, v: &Vertex<'s>, task: GatherTask, sampler: &mut Sampler) {
        let GatherTask {
            path,
            role,
            lights,
            numbers,
        } = task;
        let prepared = self.prepared;
        let compensates = prepared.compensation == Compensation::KolligKeller;
        let area_per_light = (compensates && numbers.count >= AREA_QUERY_DIRECTIONS)
            .then(|| self.area_per_light(v.x.p));
        let primitive = &prepared.scene.geometry.primitives()[v.x.at.primitive.index()];
        self.points.push(GatherPoint {
            pixel: path.pixel as usize,
            throughput: path.throughput,
            segments: v.segments,
            material: primitive.material,
            at: ShadingPoint {
                x: v.x,
                wo: v.w_prev,
                bsdf: v.bsdf,
                max_photon_depth: prepared.limits.max_depth.map(|max| max - (v.segments + 1)),
                u: sampler.next_1d(),
                lights,
                tolerance: 0.0,
                lit_from: role.lit_from(),
            },
            stage: path.stage,
            max_photon_radius: path.max_photon_radius,
            direction_limit: role.direction_limit(),
            photon_weight: role.photon_weight(),
        });
        self.vertices.push(GatherVertex {
            path,
            role,
            numbers,
            sampler: sampler.branch(),
            area_per_light,
            environment: environment_guide(&prepared.incident, v, &mut self.found),
        });
    }
}
