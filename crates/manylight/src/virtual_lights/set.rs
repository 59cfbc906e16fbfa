//! A set of virtual lights with their emission, ready to be gathered. Made by
//! [`build_lights`](super::build_lights).

use super::areas::LightAreas;
use super::depth_limits::DepthFractions;
use super::glossy::{Glossy, GlossyForm, Profiles};
use super::light::VirtualLight;
use super::reflection::Reflection;
use crate::geometry::SurfaceRef;
use crate::ids::LightId;
use crate::math::Vec3;
use crate::scene::PathLimits;

/// A set of virtual lights in the order of their clusters, that is along the space-filling curve.
#[derive(Debug)]
pub struct VirtualLights<'s> {
    pub(super) lights: Vec<VirtualLight<'s>>,
    pub(super) reflections: Vec<Reflection<'s>>,
    /// Glossy radiant intensities.
    pub(super) profiles: Profiles,
    pub(super) depths: DepthFractions,
    pub(super) areas: LightAreas,
    /// The surface of each light.
    pub(super) surfaces: Vec<SurfaceRef>,
    pub(super) profile_flux: ProfileFlux,
}

/// Flux of the glossy profiles of a set, in W per channel: a check of their scale.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProfileFlux {
    /// What they should emit, by samples of the lobes.
    pub scattered: [f64; 3],
    /// What they emit: their integrals.
    pub emitted: [f64; 3],
}

impl<'s> VirtualLights<'s> {
    /// The lights; [`LightId`] is the index.
    pub fn lights(&self) -> &[VirtualLight<'s>] {
        &self.lights
    }

    /// The light path with the index of [`Emission::Single`](super::Emission::Single).
    #[inline(always)]
    pub(crate) fn reflection(&self, index: u32) -> &Reflection<'s> {
        &self.reflections[index as usize]
    }

    /// The glossy profile with the index of [`Emission::Rich`](super::Emission::Rich).
    #[inline(always)]
    pub(super) fn glossy(&self, index: u32) -> Glossy<'_> {
        self.profiles.get(index)
    }

    /// Fraction of the flux of light `id` that arrived over at most `depth` segments, in [0, 1].
    /// Only distinguished in scenes that limit paths to at most 16 segments; otherwise, and for
    /// greater depths, 1.
    #[inline]
    pub fn share_up_to(&self, id: LightId, depth: u32) -> f32 {
        self.depths.up_to(id, depth)
    }

    /// Surface that the light of a single photon at `p` would represent, in m², for a photon that
    /// is assigned to no light.
    pub fn unassigned_area(&self, p: Vec3) -> f32 {
        self.areas.unassigned(p)
    }

    /// Surface per light around `p`, in m².
    pub fn surface_per_light(&self, p: Vec3) -> f32 {
        self.areas.surface_per_light(p)
    }

    /// Median of the surfaces represented by the lights, in m²; 0 without lights.
    pub fn median_area(&self) -> f32 {
        let mut areas: Vec<f32> = self.lights.iter().map(|light| light.area).collect();
        let middle = areas.len() / 2;
        areas.sort_unstable_by(f32::total_cmp);
        areas.get(middle).copied().unwrap_or(0.0)
    }

    /// Sets [`VirtualLight::radius_of_all`](super::VirtualLight::radius_of_all): a group with the
    /// fraction `s` of the lights has discs of `1/s` of the area that they would have without
    /// groups. The points of the lights of all groups around a place are as many as without.
    pub fn pool_radii(&mut self) {
        let count = self.lights.len() as f32;
        for of_group in self.lights.chunk_by_mut(|a, b| a.group == b.group) {
            let share = of_group.len() as f32 / count;
            for light in of_group {
                light.radius_of_all = light.radius * share.sqrt();
            }
        }
    }

    /// Flux of the glossy profiles.
    pub fn profile_flux(&self) -> &ProfileFlux {
        &self.profile_flux
    }

    /// Expected bytes per light, if a fraction `glossy` of the lights has a profile of `form`, or
    /// without a form is a single light path.
    pub fn bytes_per_light(form: Option<GlossyForm>, glossy: f64, limits: PathLimits) -> f64 {
        let depths = if limits.max_depth.is_some() {
            DepthFractions::BYTES_PER_LIGHT
        } else {
            0
        };
        let place = size_of::<SurfaceRef>() + size_of::<Vec3>() + size_of::<u32>();
        let all = size_of::<VirtualLight>() + place + depths;
        let of_glossy = form.map_or(size_of::<Reflection>(), GlossyForm::bytes);
        all as f64 + glossy * of_glossy as f64
    }

    /// Bytes of lights and emission.
    pub fn bytes(&self) -> usize {
        size_of_val(self.lights.as_slice())
            + size_of_val(self.reflections.as_slice())
            + size_of_val(self.surfaces.as_slice())
            + self.profiles.bytes()
            + self.depths.bytes()
    }
}
