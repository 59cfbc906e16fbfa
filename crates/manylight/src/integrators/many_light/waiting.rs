//! Vertices that wait for the light of emitters and for directions, and the rounds that serve the vertices of a tile together.
//!
//! ```text
//!   waiting vertices --sort by material--> packets of sixteen --sample--> shadow rays, directions --trace--> next vertices
//! ```
//!
//! A round takes all vertices that wait. Packets of one material are sampled in lanes (`sampling_lanes.rs`). Shadow rays and directions
//! are traced as streams. Then every direction continues on its own (`gathering.rs`); vertices at which it gathers wait for the next
//! round.

use super::gather_points::{PixelGather, TileGather};
use super::gather_vertices::{GatherDirection, WaitingVertex};
use super::prepared::PreparedPasses;
use super::sampling_lanes::{SampledRound, Sampling};
use crate::bsdf::Lobes;
use crate::gather::Subset;
use crate::geometry::Hit;
use crate::transport::stream::shade_packets;
use crate::transport::walk::{Continuation, Previous};

impl<'s> PreparedPasses<'s> {
    /// Serves the waiting vertices of a tile, and those at which their directions gather, until none is left.
    pub(super) fn serve_waiting(&self, lights: Subset, tile: &mut TileGather<'s, '_, '_>) {
        let mut round = SampledRound::default();
        let (mut occluded, mut hits) = (Vec::new(), Vec::new());
        while !tile.waiting.is_empty() {
            let mut waiting = std::mem::take(&mut tile.waiting);
            round.clear();
            let mut sampling = Sampling {
                prepared: self,
                points: &tile.points,
                waiting: &waiting,
                round: &mut round,
            };
            let order = in_order_of_material(&waiting);
            let material = |i: u32| waiting[i as usize].material;
            let runs = order.chunk_by(|&i, &j| material(i) == material(j));
            shade_packets(runs.map(|run| (material(run[0]), run)), &mut sampling);
            let geometry = &self.scene.geometry;
            geometry.occluded_stream(&round.shadow_rays, &mut occluded);
            self.add_emitter_terms(&round, &occluded, tile);
            geometry.intersect_stream(&round.rays, &mut hits);
            for (k, &hit) in hits.iter().enumerate() {
                let vertex = &mut waiting[round.directions[k].vertex as usize];
                self.follow_sampled(lights, vertex, (&round, k), hit, tile);
            }
        }
    }

    /// Adds the light of emitters that nothing blocks.
    fn add_emitter_terms(
        &self,
        round: &SampledRound,
        occluded: &[bool],
        tile: &mut TileGather<'s, '_, '_>,
    ) {
        tile.shadow_rays += round.shadow_rays.len() as u64;
        let rays = round.shadow_rays.iter().zip(occluded);
        for (term, (ray, &is_occluded)) in round.terms.iter().zip(rays) {
            if is_occluded {
                continue;
            }
            let (arriving, crossings) = self.scene.cross_transparent(ray);
            if crossings <= term.max_crossings {
                let radiance = arriving * term.radiance;
                tile.out.add(term.pixel as usize, term.layer, radiance);
            }
        }
    }

    /// Continues along direction `k` of a round, which ends at `hit`.
    fn follow_sampled(
        &self,
        lights: Subset,
        vertex: &mut WaitingVertex<'s>,
        (round, k): (&SampledRound, usize),
        hit: Option<Hit>,
        tile: &mut TileGather<'s, '_, '_>,
    ) {
        let (ray, direction) = (round.rays[k], round.directions[k]);
        let point = &tile.points[vertex.point];
        let at = &point.at;
        let from = GatherDirection {
            x: at.x,
            wo: at.wo,
            segments: point.segments,
            is_glossy: at.bsdf.lobes().has(Lobes::GLOSSY),
            receiver: at.into(),
            point: vertex.point,
            f_cos: direction.f_cos,
            area_per_light: vertex.area_per_light,
            environment: vertex.environment.as_ref(),
            role: vertex.role,
        };
        let mut path = vertex.path.clone();
        path.walk.continue_along(Continuation {
            ray,
            hit,
            throughput: direction.throughput,
            eta: direction.eta,
            previous: Previous {
                p: at.x.p,
                n: at.bsdf.receiving_normal(at.wo),
                event: direction.lobe,
                pdf: direction.pdf,
            },
        });
        let mut gather = PixelGather {
            prepared: self,
            lights,
            sampler: &mut vertex.sampler,
            pixel: vertex.pixel,
            tile,
            first_weight: vertex.first_weight,
        };
        gather.follow_direction(path, &from, ray.d);
    }
}

/// The indices of the vertices, by material; those of one material in their order.
fn in_order_of_material(waiting: &[WaitingVertex]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..waiting.len() as u32).collect();
    order.sort_by_key(|&i| waiting[i as usize].material.0);
    order
}
