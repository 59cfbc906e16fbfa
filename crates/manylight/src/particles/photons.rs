//! Photons: flux that arrives at surfaces.

use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::geometry::SurfaceRef;
use crate::math::Vec3;

/// Flux that arrives at `p` from direction `wi`, already divided by the number of emitted paths:
/// `E[Σ flux h(p, wi)] = ∫∫ L_i(p, w) |n·w| h(p, w) dw dA` for any `h` (ALGORITHMS 1.2).
#[derive(Clone, Copy, Debug)]
pub struct Photon {
    /// Position.
    pub p: Vec3,
    /// Geometric normal, turned to the side from which the photon arrives.
    pub n: Vec3,
    /// Unit direction to the previous vertex.
    pub wi: Vec3,
    /// W.
    pub flux: Rgb,
    /// Flux times [`Bsdf::diffuse_weight`](crate::bsdf::Bsdf::diffuse_weight) at `wi`: what the diffuse lobes send out, before
    /// their exit term. W.
    pub diffuse_flux: Rgb,
    /// Position of the previous vertex, for parallax; infinitely far (`p + wi * 1e?`) never occurs: distant emitters give a point outside the scene.
    pub prev: Vec3,
    /// Where on the surface; the scattering function is rebuilt from here.
    pub at: SurfaceRef,
    /// Index of the stored photon at `prev`, or [`Photon::NO_PARENT`] after an emitter or a specular event.
    pub parent: u32,
    /// Segments from the emitter: 1 is direct light.
    pub depth: u16,
    /// Class of the scattering event at `prev`; [`Lobes::NONE`] at an emitter.
    pub event: Lobes,
}

impl Photon {
    /// No stored photon at the previous vertex.
    pub const NO_PARENT: u32 = u32::MAX;
}
