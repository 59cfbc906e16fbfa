//! Surface per light, from the spacing of the lights: the area `A` that bounds the geometry term of
//! a point light.

use super::clusters::PhotonClusters;
use crate::maps::{KdTree, Neighbors};
use crate::math::Vec3;
use rayon::prelude::*;
use std::f32::consts::PI;

/// Number of neighbors in the density estimate around a light; the light itself is one of them.
/// More neighbors give less noisy and more blurred areas. At 5 and 18 (2 passes of 128 lights at
/// 72x40, 3 seeds; Kitchen, Glossy Room, U-Shape): relMSE +1.3 and -0.6 % (standard error 2 %).
const AREA_NEIGHBORS: usize = 9;

/// The density of lights around any position.
#[derive(Debug)]
pub(super) struct LightAreas {
    /// Positions of the lights.
    positions: KdTree<Vec3>,
    /// See [`PhotonClusters::unassigned_surface`].
    unassigned_surface: f32,
}

impl LightAreas {
    /// The density of lights at `positions`.
    pub(super) fn new(positions: Vec<Vec3>, unassigned_surface: f32) -> Self {
        LightAreas {
            positions: KdTree::build(positions),
            unassigned_surface,
        }
    }

    /// See [`PhotonClusters::unassigned_surface`].
    pub(super) fn unassigned_surface(&self) -> f32 {
        self.unassigned_surface
    }

    /// The surface represented by each light, in m².
    pub(super) fn of_lights(&self, clusters: &PhotonClusters) -> Vec<f32> {
        let mut areas: Vec<f32> = self
            .positions
            .items()
            .par_iter()
            .map_init(
                || Neighbors::new(AREA_NEIGHBORS),
                // The nearest is the light itself.
                |found, &p| self.area_per_light(p, 1, found),
            )
            .collect();
        for (k, area) in areas.iter_mut().enumerate() {
            *area *= clusters.surface(k);
        }
        areas
    }

    /// See [`VirtualLights::unassigned_area`](super::VirtualLights::unassigned_area).
    pub(super) fn unassigned(&self, p: Vec3) -> f32 {
        self.unassigned_surface * self.surface_per_light(p)
    }

    /// Surface per light around `p`, in m².
    pub(super) fn surface_per_light(&self, p: Vec3) -> f32 {
        self.area_per_light(p, 0, &mut Neighbors::new(AREA_NEIGHBORS - 1))
    }

    /// Area of the disc that reaches to the last neighbor, divided by the number of neighbors, of
    /// which the first `own` are not counted.
    fn area_per_light(&self, p: Vec3, own: usize, found: &mut Neighbors) -> f32 {
        self.positions.nearest(p, f32::INFINITY, found);
        let others = (found.len() as f32 - own as f32).max(1.0);
        PI * found.radius_squared() / others
    }
}
