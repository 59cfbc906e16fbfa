//! Sums over virtual lights at shading points. [`Kernel`] is the shape with which a light is
//! evaluated, [`Strategy`] the choice of lights that are evaluated. All kernels and strategies make
//! their connections by the functions of `connect`.
//!
//! | strategy | modules |
//! |---|---|
//! | all lights, sixteen points at once | `all_lights`; `batch_sums` connects, `shadow_block` traces, `roulette` leaves out |
//! | cuts through the light tree, sixteen points at once | `cut`, `occlusion`; `batch_sums` as above |
//! | cuts through pairs of points and lights | `product_cut`, `pairs`, `gather_tree` |

mod all_lights;
mod batch_sums;
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
mod receivers;
mod roulette;
mod settings;
mod shading_point;
mod shadow_block;
mod sphere;
mod sphere_samples;
mod subset;
#[cfg(test)]
mod tests;

pub use clamping::{Clamp, ClampReceiver};
pub use light_index::{Assignment, LightIndex};
pub use settings::{CutLimits, Gather, Kernel, Strategy};
pub use shading_point::{Gathered, ShadingPoint};
pub use subset::Subset;

use crate::color::Rgb;
use crate::lanes::One;
use crate::math::Vec3;
use crate::scene::Scene;
use crate::virtual_lights::SurfaceLocation;
use clamping::ClampedConnection;
use gather_tree::GatherTree;
use light_points::part_area;
use pairs::PairContext;
use points::{BATCHES, Batch};

impl Gather {
    /// The sums of the lights at the points of a tile,
    ///
    /// ```text
    /// L = Σ_k f |w·n| I_k(-w) w_c V / d²
    /// ```
    ///
    /// over the points of each light, with the clamping weight `w_c` and the visibility `V`. Lights
    /// are the outer loop, so that the table of one stays in the cache for all points.
    pub fn sum<'s, P: AsRef<ShadingPoint<'s>>>(
        &self,
        scene: &Scene,
        lights: &LightIndex,
        points: &[P],
    ) -> Vec<Gathered> {
        self.sum_by_group(scene, lights, points, &mut Vec::new())
    }

    /// [`Gather::sum`]. `by_group` becomes the radiance of each light group at each point: the
    /// groups of a point follow each other. It is empty if the lights do not tell groups apart.
    pub fn sum_by_group<'s, P: AsRef<ShadingPoint<'s>>>(
        &self,
        scene: &Scene,
        lights: &LightIndex,
        points: &[P],
        by_group: &mut Vec<Rgb>,
    ) -> Vec<Gathered> {
        let mut sums = vec![Gathered::default(); points.len()];
        by_group.clear();
        by_group.resize(points.len() * lights.groups, Rgb::BLACK);
        let batches = Batch::all(points);
        for same_lights in batches.chunk_by(|a, b| a.lights == b.lights) {
            for group in same_lights.chunks(BATCHES) {
                let sums = (sums.as_mut_slice(), by_group.as_mut_slice());
                match self.strategy.cut_limits() {
                    None => all_lights::add(self, scene, lights, group, sums),
                    Some(limits) => cut::add(self, (scene, lights), limits, group, sums),
                }
            }
        }
        sums
    }

    /// The sums of the lights at the gather points of one pixel, estimated by one cut for the sum
    /// over the points, weighted by the throughput given with each. A sum at a single point has the
    /// right expected value, and more noise. The error of a pair of clusters may be `tolerance`
    /// (luminance, in W/(m² sr)), or the relative error of the limits. The first of the returned
    /// sums holds the size and the cost of the cut. The radiance of each light group at each point is
    /// appended to `by_group`, as in [`Gather::sum_by_group`].
    pub fn sum_of_pixel(
        &self,
        scene: &Scene,
        lights: &LightIndex,
        (limits, tolerance): (CutLimits, f32),
        points: &[(&ShadingPoint, Rgb)],
        by_group: &mut Vec<Rgb>,
    ) -> Vec<Gathered> {
        let gather_tree = GatherTree::new(points);
        let context = PairContext::new(self, scene, lights, &gather_tree);
        product_cut::sums(context, limits, tolerance, points, by_group)
    }

    /// Fraction of the light from `y` that the clamp removes from the sum at `at`: one minus the
    /// weight of a connection with the part at `y` of the light to which photons at `y` are
    /// assigned. `f_cos` is `f cosθ` of the non-specular lobes at `at` for a direction, in 1/sr.
    pub fn clamped_fraction(
        &self,
        lights: &LightIndex,
        at: &ClampReceiver,
        y: &SurfaceLocation,
        assignment: Assignment,
        f_cos: impl FnOnce(Vec3) -> Rgb,
    ) -> f32 {
        if self.clamp == Clamp::None {
            return 0.0;
        }
        let (n_y, area) = match assignment {
            Assignment::Light(id) => {
                let light = &lights.set.lights()[id.index()];
                (light.n, part_area(self, at, light))
            }
            Assignment::Unassigned { area } => (y.n, area),
        };
        let to_y = y.p - at.p;
        let d2 = to_y.length_squared();
        if d2 == 0.0 {
            return 0.0;
        }
        let inv_d = d2.sqrt().recip();
        let w = to_y * inv_d;
        let weight = self.clamp.weight::<One>(&ClampedConnection {
            w: w.into(),
            inv_d2: (inv_d * inv_d).into(),
            f_cos: f_cos(w).into(),
            n_x: at.n.into(),
            n_y,
            area: area * self.area_factor(at.lights),
        });
        1.0 - weight.get()
    }
}
