//! How lights are summed.

use super::clamping::Clamp;

/// The shape with which a light is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// One point.
    Point,
    /// The disc with the second moment of the light's photons, as sixteen points from near, four
    /// from farther, and one from far.
    Disc,
    /// The sphere with that moment, integrated over its solid angle. The radius of a light of one
    /// photon follows from the area that it represents. Source: Hašan, Křivánek, Walter, Bala,
    /// "Virtual Spherical Lights for Many-Light Rendering of Glossy Scenes", SIGGRAPH Asia 2009.
    Sphere,
}

impl Kernel {
    /// Whether a light is a sphere: directions are sampled instead of points, and nothing is
    /// clamped.
    #[inline(always)]
    pub fn is_sphere(self) -> bool {
        match self {
            Kernel::Sphere => true,
            Kernel::Point | Kernel::Disc => false,
        }
    }

    /// Whether a light is evaluated elsewhere than at its own position, so that it needs those of
    /// its photons even where its emission is that of one.
    #[inline(always)]
    pub fn needs_extent(self) -> bool {
        match self {
            Kernel::Disc => true,
            Kernel::Point | Kernel::Sphere => false,
        }
    }
}

/// The choice of lights that are evaluated at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Strategy {
    /// All lights of a [`Subset`](super::Subset).
    All,
    /// A cut through the light tree, common to up to 64 points. At points with a subset of one
    /// light in `n`, the cut has at most `max_lights / n` terms.
    Cuts(CutLimits),
    /// A cut through the pairs of the gather points of a pixel and the lights:
    /// [`Gather::sum_of_pixel`]. [`Gather::sum`] makes the same cuts as for [`Strategy::Cuts`].
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
    /// Divisor of the area that a light represents, as clamping and spheres see it: progressive
    /// refinement.
    pub refinement: f32,
    /// Threshold of Russian roulette before shadow rays: unshadowed light of a ray, relative to the
    /// mean over the lights. 0: no roulette.
    pub roulette: f32,
}

/// When the refinement of a cut ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutLimits {
    /// Largest error of a cluster, relative to the radiance that the point reflects, or that the
    /// pixel receives.
    pub max_error: f32,
    /// Most lights and clusters of a cut, whatever their error.
    pub max_lights: u32,
}

impl Default for CutLimits {
    /// The values of Walter et al. 2005.
    fn default() -> Self {
        CutLimits {
            max_error: 0.02,
            max_lights: 1000,
        }
    }
}
