//! Sums virtual lights at shading points. [`Kernel`] says how one light is evaluated, [`Strategy`] which are.

mod block;
mod clamping;
mod connect;
mod cut;
mod occlusion;
mod points;
mod sphere;
#[cfg(test)]
mod tests;

pub use clamping::Clamp;
pub use cut::{CutLimits, ShareOf};

use crate::bsdf::Bsdf;
use crate::color::Rgb;
use crate::geometry::SurfacePoint;
use crate::ids::LightId;
use crate::light_tree::LightTree;
use crate::math::Vec3;
use crate::scene::Scene;
use crate::virtual_lights::{SurfaceLocation, VirtualLights};
use clamping::ClampedConnection;
use points::{BATCHES, Batch, Reach};

/// How one light is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// As a point.
    Point,
    /// As a disc with the second moment of its photons, by sixteen to one of its points.
    Disc,
    /// As what a sphere with that moment takes of the field of view; spheres of single photons by the surface per light. Source:
    /// Hašan, Křivánek, Walter, Bala, "Virtual Spherical Lights for Many-Light Rendering of Glossy Scenes", 2009.
    Sphere,
}

/// Which lights are evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Strategy {
    /// All of a [`Subset`].
    All,
    /// Some that stand for the others, chosen for up to 64 points together. A selection of one in `n` is a cut of a so much smaller size.
    Cuts(CutLimits),
}

/// Where lights are summed: a surface point, seen along `-wo`.
#[derive(Clone, Copy, Debug)]
pub struct ShadingPoint<'s> {
    /// The point.
    pub x: SurfacePoint,
    /// Unit direction to the viewer.
    pub wo: Vec3,
    /// Scattering function; its smooth lobes count here.
    pub bsdf: Bsdf<'s>,
    /// Largest photon depth that fits the path limits here; `None` without limit.
    pub max_photon_depth: Option<u32>,
    /// Uniform in [0, 1): decides between numbers of points.
    pub u: f32,
    /// Which lights are summed here.
    pub lights: Subset,
    /// Radiance by which any cluster of lights may be off here, luminance; 0 where only a share of the sum may be.
    pub tolerance: f32,
    /// Only light that arrives on the side of this normal counts, if given.
    pub lit_from: Option<Vec3>,
}

/// Which lights are summed at a point: some at equal distances along the space-filling curve. Each stands for as many as there are
/// from one to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Subset {
    first: u32,
    step: u32,
    /// Points whose mean counts and among which the lights are divided.
    points: u32,
}

impl Subset {
    /// Every light.
    pub const ALL: Subset = Subset {
        first: 0,
        step: 1,
        points: 1,
    };

    /// These lights are divided among `step` selections; this is the one with index `k`, counted round.
    pub fn part(self, k: u32, step: u32) -> Self {
        Subset {
            first: self.first + self.step * (k % step),
            step: self.step * step,
            points: self.points,
        }
    }

    /// The same for point `k` of so many whose mean counts. To the clamp a light has its own surface then: what it adds to the mean is as
    /// if all lights were summed at each of the points.
    pub fn divided(self, k: u32, points: u32) -> Self {
        Subset {
            points: self.points * points,
            ..self.part(k, points)
        }
    }

    /// The indices of the selected ones among `lights` lights.
    #[inline]
    pub fn indices(self, lights: usize) -> impl ExactSizeIterator<Item = usize> {
        (self.first as usize..lights).step_by(self.step as usize)
    }

    /// How many of `lights` lights are selected.
    pub fn count(self, lights: usize) -> usize {
        self.indices(lights).len()
    }

    /// For how many lights each selected one stands: its light counts so many times.
    #[inline]
    pub fn stands_for(self) -> f32 {
        self.step as f32
    }

    /// Of how many lights the clamp sees the surface.
    #[inline]
    fn surfaces(self) -> f32 {
        self.step as f32 / self.points as f32
    }
}

/// Where the clamp is asked about from.
#[derive(Clone, Copy, Debug)]
pub struct Viewpoint {
    /// Position.
    pub p: Vec3,
    /// Geometric normal.
    pub n: Vec3,
    /// As [`ShadingPoint::u`].
    pub u: f32,
    /// Which lights are summed there.
    pub lights: Subset,
}

impl From<&ShadingPoint<'_>> for Viewpoint {
    fn from(at: &ShadingPoint) -> Self {
        Viewpoint {
            p: at.x.p,
            n: at.x.ng,
            u: at.u,
            lights: at.lights,
        }
    }
}

/// The light that stands for light from some spot.
#[derive(Clone, Copy, Debug)]
pub enum Assignment {
    /// This one.
    Light(LightId),
    /// None: photons there are lights by themselves.
    Unassigned {
        /// Surface that each of them stands for, in m².
        area: f32,
    },
}

/// Lights made ready to be summed.
#[derive(Debug)]
pub struct LightIndex<'s> {
    /// The lights themselves.
    pub set: VirtualLights<'s>,
    /// How far the points of each light lie from it.
    reaches: Vec<Reach>,
    /// For cuts.
    tree: Option<LightTree>,
}

impl<'s> LightIndex<'s> {
    /// Prepares `field` for sums over all lights.
    pub fn new(field: VirtualLights<'s>) -> Self {
        let reaches = field.lights().iter().map(Reach::of).collect();
        LightIndex {
            set: field,
            reaches,
            tree: None,
        }
    }

    /// What is known of `light`, to which photons at `y` belong, if there is one.
    pub fn owner(&self, light: Option<LightId>, y: &SurfaceLocation) -> Assignment {
        match light {
            Some(id) => Assignment::Light(id),
            None => Assignment::Unassigned {
                area: self.set.unassigned_area(y.p),
            },
        }
    }

    /// The same with a tree over all lights, for cuts.
    pub fn with_tree(self) -> Self {
        let tree = LightTree::new(&self.set, |_| true);
        LightIndex {
            tree: Some(tree),
            ..self
        }
    }

    /// For measurements: clusters know nothing of where their lights shine, only how bright they are at most.
    #[cfg(any(test, feature = "testing"))]
    pub fn forget_directions(&mut self) {
        if let Some(tree) = &mut self.tree {
            tree.forget_directions();
        }
    }
}

/// How lights are summed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gather {
    /// How one is evaluated.
    pub kernel: Kernel,
    /// Which are evaluated. For cuts the lights must have a tree.
    pub strategy: Strategy,
    /// What is done about the singularity.
    pub clamp: Clamp,
    /// How many times smaller than what a light stands for the surface is that the clamp sees, and a sphere has.
    pub finer: f32,
}

/// A sum of lights, with what it cost.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gathered {
    /// Radiance towards the viewer.
    pub radiance: Rgb,
    /// Radiance that the clamp took away, before visibility; luminance.
    pub clamped: f32,
    /// Luminance before clamp and visibility.
    pub unclamped: f32,
    /// Lights and clusters that the sum is made of.
    pub terms: u32,
    /// Upper bound of the error of any cluster, relative to the luminance of the radiance; 0 without clusters.
    pub cluster_error: f32,
    /// Connections evaluated.
    pub connections: u64,
    /// Visibility tests.
    pub shadow_rays: u64,
}

impl Gather {
    /// For each point of a tile the radiance from all lights: `L = Σ_k f |w·n| I_k(-w) V / d²` over the points that each light
    /// is made of. Light by light, so that its table stays in the cache for the whole tile.
    pub fn sum(
        &self,
        scene: &Scene,
        lights: &LightIndex,
        points: &[ShadingPoint],
    ) -> Vec<Gathered> {
        let mut sums = vec![Gathered::default(); points.len()];
        let batches = Batch::all(points);
        for same_lights in batches.chunk_by(|a, b| a.lights == b.lights) {
            for group in same_lights.chunks(BATCHES) {
                match self.strategy {
                    Strategy::All => self.add_lights(scene, lights, group, &mut sums),
                    Strategy::Cuts(limits) => {
                        self.add_cut(scene, lights, limits, group, &mut sums);
                    }
                }
            }
        }
        sums
    }

    /// For how many lights each one counts that is evaluated by itself.
    #[inline(always)]
    fn stands_for(&self, selection: Subset) -> f32 {
        match self.strategy {
            Strategy::All => selection.stands_for(),
            Strategy::Cuts(_) => 1.0,
        }
    }

    /// Of how many lights it has the surface, beside the clamp.
    #[inline(always)]
    fn surfaces(&self, selection: Subset) -> f32 {
        let surfaces = match self.strategy {
            Strategy::All => selection.surfaces(),
            Strategy::Cuts(_) => 1.0,
        };
        surfaces / self.finer
    }

    /// Share of the light from `y` that the sum at `at` lacks, because the clamp takes it away from the light that photons at
    /// `y` belong to: one less what [`Gather::sum`] keeps of a connection to a part of `owner` at `y`. `f_cos` says what the
    /// smooth lobes at `at` reflect from a direction: `f cosθ` in 1/sr.
    pub fn missing(
        &self,
        lights: &LightIndex,
        at: &Viewpoint,
        y: &SurfaceLocation,
        owner: Assignment,
        f_cos: impl FnOnce(Vec3) -> Rgb,
    ) -> f32 {
        if self.clamp == Clamp::None {
            return 0.0;
        }
        let (n_y, area) = match owner {
            Assignment::Light(id) => {
                let light = &lights.set.lights()[id.index()];
                (light.n, self.part_area(at, light))
            }
            Assignment::Unassigned { area } => (y.n, area),
        };
        self.taken(self.clamp, at, (y.p, n_y), area, f_cos)
    }

    /// Share of the light from `y`, where the normal is `n_y`, that `clamp` takes away from a piece of so much `area`.
    fn taken(
        &self,
        clamp: Clamp,
        at: &Viewpoint,
        (y, n_y): (Vec3, Vec3),
        area: f32,
        f_cos: impl FnOnce(Vec3) -> Rgb,
    ) -> f32 {
        let to_y = y - at.p;
        let d2 = to_y.length_squared();
        if d2 == 0.0 {
            return 0.0;
        }
        let inv_d = d2.sqrt().recip();
        let w = to_y * inv_d;
        1.0 - clamp.kept(&ClampedConnection {
            w,
            inv_d2: inv_d * inv_d,
            f_cos: f_cos(w),
            n_x: at.n,
            n_y,
            area: area * self.surfaces(at.lights),
        })
    }
}
