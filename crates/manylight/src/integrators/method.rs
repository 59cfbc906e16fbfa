//! The methods with their settings, and the film layers that each fills.

use super::many_light::{Compensation, ManyLight, Strategy};
use super::photon_map::PhotonMap;
use crate::film::Layer;
use crate::scene::PathLimits;

/// A method with its settings.
#[derive(Clone, Debug, PartialEq)]
pub struct Method {
    /// The kind of method.
    pub kind: MethodKind,
    /// Limits of path length.
    pub limits: PathLimits,
}

/// The kinds of methods.
#[derive(Clone, Debug, PartialEq)]
pub enum MethodKind {
    /// Path tracing with next-event estimation: the reference.
    Path,
    /// Light tracing: photons splatted on the film. The adjoint of `Path` for light that reaches the camera without
    /// specular events.
    LightTracer,
    /// Direct light alone: path tracing to depth 2.
    Direct,
    /// Albedo, normal and depth of the first surface; the beauty layer stays black.
    Aov,
    /// Virtual lights.
    ManyLight(ManyLight),
    /// Photon mapping.
    PhotonMap(PhotonMap),
}

impl Method {
    /// Whether the method emits photons.
    pub fn emits_photons(&self) -> bool {
        match self.kind {
            MethodKind::Path | MethodKind::Direct | MethodKind::Aov => false,
            MethodKind::LightTracer | MethodKind::ManyLight(_) | MethodKind::PhotonMap(_) => true,
        }
    }

    /// The layers that this method fills, beauty first.
    pub fn layers(&self) -> Vec<Layer> {
        let mut layers = vec![Layer::Beauty];
        if !matches!(self.kind, MethodKind::LightTracer | MethodKind::Aov) {
            layers.extend([
                Layer::Emission,
                Layer::Direct,
                Layer::VirtualLights,
                Layer::Caustics,
            ]);
        }
        if matches!(&self.kind, MethodKind::ManyLight(method) if method.compensation != Compensation::None)
        {
            layers.push(Layer::Compensation);
        }
        if self.kind != MethodKind::LightTracer {
            layers.extend([Layer::Albedo, Layer::Normal, Layer::Depth]);
        }
        if matches!(&self.kind, MethodKind::ManyLight(method) if method.strategy != Strategy::All) {
            layers.extend([Layer::CutSize, Layer::CutBound]);
        }
        layers
    }
}
