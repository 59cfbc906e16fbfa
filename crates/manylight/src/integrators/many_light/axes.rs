//! The axes of a many-light method. A preset is a choice on each; all combinations exist, but for a few that contradict
//! themselves. In words: docs/many_light.md. The axes [`Kernel`] and [`Strategy`] belong to [`crate::gather`].
//!
//! [`Kernel`]: crate::gather::Kernel
//! [`Strategy`]: crate::gather::Strategy

use crate::virtual_lights::GlossyForm;

/// How photons are chosen to become virtual lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// With probability proportional to flux.
    Uniform,
    /// With probability proportional to importance times flux.
    Importance,
    /// As [`Placement::Importance`], followed by relaxation: repulsion between neighboring lights.
    Relaxed,
}

/// The flux of a virtual light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FluxRule {
    /// Flux of the light's photon over the probability of having been kept: the paper's rule, as we read it.
    Density,
    /// Flux of all photons that are nearer to the light than to any other light of the same surface.
    Partition,
}

/// The emission of a virtual light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EmissionKind {
    /// The reflection of one photon.
    Single,
    /// The reflection of all photons of a cluster: the diffuse part exactly, the glossy part in this form.
    Rich(GlossyForm),
}

/// Bound on the `1 / d²` singularity of a connection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClampRule {
    /// No bound.
    None,
    /// By the surface area that each light represents: [`Clamp::Auto`](crate::gather::Clamp::Auto).
    Auto,
    /// `G <= 1 / A`, with `A` the median surface area that the lights of one pass represent, in m².
    Fixed,
    /// `G <= value`, in 1/m².
    Value(f32),
}

/// Compensation of the light that clamping removes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compensation {
    /// None: the image lacks that light.
    None,
    /// Directions sampled at the shading point, continued in proportion to the clamped fraction, after Kollig and Keller.
    /// Photons add what low-roughness lobes reflect from emitters, which directions would rarely find.
    KolligKeller,
}

/// The virtual lights of successive passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resampling {
    /// New lights in each pass, which represent the same area in all passes.
    New,
    /// New lights in each pass, which represent a smaller area from pass to pass. The mean over passes converges to the
    /// right image.
    Progressive,
}

/// How the effort of a pass is set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// As the settings say.
    Fixed,
    /// By a pre-pass: at most as many lights as the settings say.
    Measured,
}
