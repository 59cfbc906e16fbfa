//! The methods with their settings, and the film layers that each fills.

use super::many_light::{Compensation, ManyLight, Strategy, with_most_photons};
use super::mixed::Mixed;
use super::photon_map::PhotonMap;
use crate::film::{Half, IdLayer, Layer};
use crate::scene::{PathLimits, Scene};

/// A method with its settings.
#[derive(Clone, Debug, PartialEq)]
pub struct Method {
    /// The kind of method.
    pub kind: MethodKind,
    /// Limits of path length.
    pub limits: PathLimits,
    /// Layers beyond those that the method fills in any case.
    pub extra: ExtraLayers,
}

/// Layers that are recorded, or left out, on request.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ExtraLayers {
    /// Leaves out the layers that the method fills in any case, but those of the picture and its
    /// error: beauty, emission and alpha. [`MethodKind::Aov`] and [`MethodKind::Mixed`] need the
    /// others.
    pub picture_only: bool,
    /// [`Layer::Position`].
    pub position: bool,
    /// [`IdLayer::Object`].
    pub objects: bool,
    /// [`IdLayer::Material`].
    pub materials: bool,
    /// Number of light groups with a [`Layer::LightGroup`]: all of the scene, or 0. Not filled by
    /// [`MethodKind::Aov`].
    pub light_groups: usize,
}

impl ExtraLayers {
    /// The id layers among them.
    pub fn id_layers(&self) -> Vec<IdLayer> {
        let layers = [
            (self.objects, IdLayer::Object),
            (self.materials, IdLayer::Material),
        ];
        let requested = layers.into_iter().filter(|(requested, _)| *requested);
        requested.map(|(_, layer)| layer).collect()
    }
}

/// The kinds of methods.
#[derive(Clone, Debug, PartialEq)]
pub enum MethodKind {
    /// Path tracing with next-event estimation: the reference.
    Path,
    /// Light tracing: photons splatted on the film. The adjoint of `Path` for light that reaches
    /// the camera without specular events.
    LightTracer,
    /// Direct light alone: path tracing to depth 2.
    Direct,
    /// What the camera sees first: albedo, normal, depth and alpha, with [`ExtraLayers`] more; the
    /// beauty layer stays black.
    Aov,
    /// Virtual lights.
    ManyLight(ManyLight),
    /// The weighted mean of virtual lights and path tracing.
    Mixed(Mixed),
    /// Photon mapping.
    PhotonMap(PhotonMap),
}

impl Method {
    /// Whether the method emits photons.
    pub fn emits_photons(&self) -> bool {
        match self.kind {
            MethodKind::Path | MethodKind::Direct | MethodKind::Aov => false,
            MethodKind::LightTracer
            | MethodKind::ManyLight(_)
            | MethodKind::Mixed(_)
            | MethodKind::PhotonMap(_) => true,
        }
    }

    /// The settings of the virtual lights, if the method has any.
    pub fn lights(&self) -> Option<&ManyLight> {
        match &self.kind {
            MethodKind::ManyLight(lights) | MethodKind::Mixed(Mixed { lights, .. }) => Some(lights),
            _ => None,
        }
    }

    /// [`Method::lights`], to change them.
    pub(crate) fn lights_mut(&mut self) -> Option<&mut ManyLight> {
        match &mut self.kind {
            MethodKind::ManyLight(lights) | MethodKind::Mixed(Mixed { lights, .. }) => Some(lights),
            _ => None,
        }
    }

    /// The method for frames of a walkthrough, of `passes` passes each.
    pub(crate) fn of_frames(&self, passes: Option<u32>) -> Method {
        let lights = self.lights().map(|lights| lights.of_frames(passes));
        lights.map_or_else(|| self.clone(), |lights| self.with_lights(&lights))
    }

    /// The method with the virtual lights of `lights`.
    pub(crate) fn with_lights(&self, kept: &ManyLight) -> Method {
        let mut method = self.clone();
        if let Some(lights) = method.lights_mut() {
            *lights = *kept;
        }
        method
    }

    /// Most sets of virtual lights of the first `passes` passes in `scene`; 1 if they have no end.
    pub(crate) fn max_group_count(&self, scene: &Scene, passes: Option<u32>) -> u32 {
        let lights = self.lights().zip(passes);
        lights.map_or(1, |(lights, passes)| {
            with_most_photons(lights, scene).group_count(passes)
        })
    }

    /// The half of the passes to which pass `index` belongs. Passes of different halves share
    /// neither virtual lights nor a sequence of samples.
    pub fn half_of_pass(&self, index: u32) -> Half {
        match self.lights() {
            Some(lights) => lights.place_in_half(index).0,
            None => Half::of_set(index),
        }
    }

    /// Whether the film is without the layers that [`ExtraLayers::picture_only`] leaves out.
    fn has_picture_only(&self) -> bool {
        let needs_layers = matches!(self.kind, MethodKind::Aov | MethodKind::Mixed(_));
        self.extra.picture_only && !needs_layers
    }

    /// The layers that this method fills, beauty first.
    pub fn layers(&self) -> Vec<Layer> {
        let mut layers = vec![Layer::Beauty];
        if self.has_picture_only() {
            if self.kind != MethodKind::LightTracer {
                layers.extend([Layer::Emission, Layer::Alpha]);
                layers.extend(self.extra.position.then_some(Layer::Position));
            }
            layers.extend(Layer::of_light_groups(self.extra.light_groups));
            return layers;
        }
        if !matches!(self.kind, MethodKind::LightTracer | MethodKind::Aov) {
            layers.extend([
                Layer::Emission,
                Layer::Direct,
                Layer::VirtualLights,
                Layer::Caustics,
            ]);
        }
        let lights = self.lights();
        if lights.is_some_and(|lights| lights.compensation != Compensation::None) {
            layers.push(Layer::Compensation);
        }
        if self.kind != MethodKind::LightTracer {
            layers.extend([Layer::Albedo, Layer::Normal, Layer::Depth, Layer::Alpha]);
            layers.extend(self.extra.position.then_some(Layer::Position));
        }
        if lights.is_some_and(|lights| lights.strategy != Strategy::All) {
            layers.extend([Layer::CutSize, Layer::CutBound]);
        }
        layers.extend(Layer::of_light_groups(self.extra.light_groups));
        layers
    }
}
