//! Sums over virtual lights at shading points. [`Kernel`] is the shape with which a light is evaluated, [`Strategy`] the choice
//! of lights that are evaluated.

mod block;
mod clamping;
mod connect;
mod cut;
mod gather_tree;
mod light_index;
mod light_points;
mod occlusion;
mod pairs;
mod points;
mod product_cut;
#[cfg(test)]
mod product_tests;
mod roulette;
mod shading_point;
mod sphere;
mod subset;
#[cfg(test)]
mod tests;

pub use clamping::{Clamp, ClampReceiver};
pub use cut::CutLimits;
pub use light_index::{Assignment, LightIndex};
pub use shading_point::{Gathered, ShadingPoint, WeightedPoint};
pub use subset::Subset;

use crate::scene::Scene;
use points::{BATCHES, Batch};

/// The shape with which a light is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// One point.
    Point,
    /// The disc with the second moment of the light's photons, as sixteen points from near, four from farther, and one from far.
    Disc,
    /// The sphere with that moment, integrated over its solid angle. The radius of a light of one photon follows from
    /// the area that it represents. Source: Hašan, Křivánek, Walter, Bala, "Virtual Spherical Lights for Many-Light Rendering of
    /// Glossy Scenes", SIGGRAPH Asia 2009.
    Sphere,
}

/// The choice of lights that are evaluated at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Strategy {
    /// All lights of a [`Subset`].
    All,
    /// A cut through the light tree, common to up to 64 points. At points with a subset of one light in `n`, the cut has at most
    /// `max_lights / n` terms.
    Cuts(CutLimits),
    /// A cut through the pairs of the gather points of a pixel and the lights: [`Gather::sum_of_pixel`]. [`Gather::sum`] makes
    /// the same cuts as for [`Strategy::Cuts`].
    Bidirectional(CutLimits),
}

impl Strategy {
    /// The limits of cuts; `None` without cuts.
    pub fn cut_limits(self) -> Option<CutLimits> {
        match self {
            Strategy::All => None,
            Strategy::Cuts(limits) | Strategy::Bidirectional(limits) => Some(limits),
        }
    }
}

/// How lights are summed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gather {
    /// The shape with which a light is evaluated.
    pub kernel: Kernel,
    /// The lights that are evaluated. Cuts need lights with a tree.
    pub strategy: Strategy,
    /// Bound on the singularity of a connection.
    pub clamp: Clamp,
    /// Divisor of the area that a light represents, as clamping and spheres see it: progressive refinement.
    pub refinement: f32,
    /// Threshold of Russian roulette before shadow rays: unshadowed light, relative to the mean over the lights. 0: no roulette.
    pub roulette: f32,
}

impl Gather {
    /// The sums of the lights at the points of a tile,
    ///
    /// ```text
    /// L = Σ_k f |w·n| I_k(-w) V / d²
    /// ```
    ///
    /// over the points of each light. Lights are the outer loop, so that the table of one stays in the cache for all points.
    pub fn sum<'s, P: AsRef<ShadingPoint<'s>>>(
        &self,
        scene: &Scene,
        lights: &LightIndex,
        points: &[P],
    ) -> Vec<Gathered> {
        let mut sums = vec![Gathered::default(); points.len()];
        let batches = Batch::all(points);
        for same_lights in batches.chunk_by(|a, b| a.lights == b.lights) {
            for group in same_lights.chunks(BATCHES) {
                match self.strategy.cut_limits() {
                    None => self.add_lights(scene, lights, group, &mut sums),
                    Some(limits) => self.add_cut(scene, lights, limits, group, &mut sums),
                }
            }
        }
        sums
    }

    /// Factor on each evaluated light: the number of lights that it represents.
    #[inline(always)]
    fn lights_per_term(&self, lights: Subset) -> f32 {
        match self.strategy {
            Strategy::All => lights.lights_per_member(),
            Strategy::Cuts(_) | Strategy::Bidirectional(_) => 1.0,
        }
    }

    /// Factor on the area that a light represents, as clamping and spheres see it.
    #[inline(always)]
    fn area_factor(&self, lights: Subset) -> f32 {
        let factor = match self.strategy {
            Strategy::All => lights.area_factor(),
            Strategy::Cuts(_) | Strategy::Bidirectional(_) => 1.0,
        };
        factor / self.refinement
    }
}
