//! The points at which lights are summed, and the sums.

use super::Subset;
use crate::bsdf::Bsdf;
use crate::color::Rgb;
use crate::geometry::SurfacePoint;
use crate::math::Vec3;

/// A surface point at which lights are summed, seen along `-wo`.
#[derive(Clone, Copy, Debug)]
pub struct ShadingPoint<'s> {
    /// Surface point.
    pub x: SurfacePoint,
    /// Unit direction to the viewer.
    pub wo: Vec3,
    /// Scattering function; its non-specular lobes count.
    pub bsdf: Bsdf<'s>,
    /// Largest photon depth that fits the path limits; `None` without limit.
    pub max_photon_depth: Option<u32>,
    /// Random number in [0, 1): the number of points that stand for a disc, directions to spheres,
    /// and the seeds of roulette, cuts and the lobes of lights follow from it.
    pub u: f32,
    /// The lights that are summed.
    pub lights: Subset,
    /// Radiance by which any cluster of lights may be off, luminance in W/(m² sr), whatever the
    /// relative error; 0 for none.
    pub tolerance: f32,
    /// If given, only light that arrives on the side of this normal counts.
    pub lit_from: Option<Vec3>,
}

impl<'s> ShadingPoint<'s> {
    /// A point at which all lights are summed, in the middle of the random numbers, without limits
    /// of depth and side.
    pub fn unlimited(x: SurfacePoint, wo: Vec3, bsdf: Bsdf<'s>) -> Self {
        ShadingPoint {
            x,
            wo,
            bsdf,
            max_photon_depth: None,
            u: 0.5,
            lights: Subset::ALL,
            tolerance: 0.0,
            lit_from: None,
        }
    }
}

impl<'s> AsRef<ShadingPoint<'s>> for ShadingPoint<'s> {
    fn as_ref(&self) -> &Self {
        self
    }
}

/// The sum of the lights at a point, with its cost.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gathered {
    /// Radiance towards the viewer, in W/(m² sr).
    pub radiance: Rgb,
    /// Radiance that the clamp removed from the connections evaluated, visibility not counted;
    /// luminance in W/(m² sr). A cut through the light tree also counts the representatives of
    /// clusters that it refined, each as one light.
    pub clamped: f32,
    /// Radiance of the same connections before clamping, visibility not counted; luminance in
    /// W/(m² sr).
    pub unclamped: f32,
    /// Number of terms of the sum: lights, or the lights and clusters of a cut.
    pub terms: u32,
    /// Upper bound of the error of any cluster, relative to the luminance of `radiance`, or of the
    /// sum over a pixel with one cut for all its points; 0 without clusters.
    pub cluster_error: f32,
    /// Lights, and representatives of clusters, that were evaluated, those included that face away
    /// from the point.
    pub connections: u64,
    /// Shadow rays traced.
    pub shadow_rays: u64,
}
