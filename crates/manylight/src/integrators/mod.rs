//! The methods.

pub mod many_light;

pub use many_light::ManyLight;

use crate::scene::PathLimits;

/// A method with its parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Method {
    /// Which.
    pub kind: MethodKind,
    /// How long paths may be.
    pub limits: PathLimits,
}

/// The methods.
#[derive(Clone, Debug, PartialEq)]
pub enum MethodKind {
    /// Path tracing with next-event estimation: the reference.
    Path,
    /// Photons splatted on the film: the adjoint of `Path`.
    LightTracer,
    /// Direct light alone: path tracing to depth 2.
    Direct,
    /// Albedo, normal, depth of the first surface.
    Aov,
    /// Virtual lights.
    ManyLight(ManyLight),
}
