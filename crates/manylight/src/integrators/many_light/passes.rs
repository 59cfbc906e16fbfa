//! What the passes of a group shade with.

use super::compensation_photons::CompensationPhoton;
use super::radiance_cache::RadianceCache;
use super::schedule::{LightSubsets, PassGroup};
use super::settings::Compensation;
use crate::emitters::RayDensities;
use crate::gather::{Gather, LightIndex};
use crate::maps::{IncidentMap, KdTree};
use crate::math::Vec2;
use crate::particles::Photon;
use crate::scene::{PathLimits, Scene};
use crate::sensors::Sensor;
use crate::virtual_lights::light_groups::NearestLightsOfGroups;

/// Everything that the passes of a group shade with.
#[derive(Debug)]
pub struct PreparedPasses<'s> {
    pub(super) scene: &'s Scene,
    pub(super) limits: PathLimits,
    pub(super) group: PassGroup,
    /// Number of light groups; 0 if they are not told apart.
    pub(super) light_groups: usize,
    pub(super) compensation: Compensation,
    /// Emitter samples per direction at the first gather points.
    pub(super) emitter_samples: u32,
    /// Camera paths that a pixel starts with in a pass.
    pub(super) camera_paths: u32,
    pub(super) gather: Gather,
    /// The virtual lights.
    pub lights: LightIndex<'s>,
    pub(super) subsets: LightSubsets,
    /// Radiance by which a cluster of lights may be off in any pixel, luminance in W/(m² sr); 0
    /// without cuts.
    pub(super) tolerance: f32,
    /// The light that a photon anywhere would be assigned to.
    pub nearest: NearestLightsOfGroups,
    /// Photons that arrive straight from the environment.
    pub(super) incident: IncidentMap,
    /// Photons with a specular last event.
    pub caustics: KdTree<Photon>,
    /// Densities of the photons at emitters.
    pub(super) ray_densities: RayDensities,
    pub(super) cache: RadianceCache,
    pub(super) compensation_photons: KdTree<CompensationPhoton>,
}

/// What groups of passes shade with, kept for the passes to come.
#[derive(Debug)]
pub(in crate::integrators) struct PreparedGroups<'s> {
    /// Made before the render.
    given: &'s [PreparedPasses<'s>],
    groups: Vec<PreparedPasses<'s>>,
    /// Most groups that are kept at once, at least 1.
    most: usize,
}

impl<'s> PreparedGroups<'s> {
    pub(in crate::integrators) fn new(most: usize) -> Self {
        PreparedGroups {
            given: &[],
            groups: Vec::new(),
            most: most.max(1),
        }
    }

    /// The same, with what was made before the render.
    pub(in crate::integrators) fn with_given(self, given: &'s [PreparedPasses<'s>]) -> Self {
        PreparedGroups { given, ..self }
    }

    /// That of `group`, which is made if it is missing. If there is no room, the oldest is dropped
    /// before: both might not fit into memory. Those that were made before the render stay.
    pub(super) fn of_group(
        &mut self,
        group: &PassGroup,
        make: impl FnOnce() -> PreparedPasses<'s>,
    ) -> &PreparedPasses<'s> {
        if let Some(given) = self.given.iter().find(|given| given.group == *group) {
            return given;
        }
        let found = self.groups.iter().position(|made| made.group == *group);
        let index = found.unwrap_or_else(|| {
            if self.groups.len() == self.most {
                self.groups.remove(0);
            }
            self.groups.push(make());
            self.groups.len() - 1
        });
        &self.groups[index]
    }
}

/// Width of a pixel in the middle of the film, as a function of the distance from the camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct PixelFootprint {
    /// Width at the camera, in m.
    width: f32,
    /// Growth of the width per m of distance.
    growth: f32,
}

impl PixelFootprint {
    pub(super) fn of(camera: &Sensor) -> Self {
        let film = &camera.desc().film;
        // The sensor takes positions relative to the crop window.
        let middle = film.size.as_vec2() * 0.5 - film.crop_offset.as_vec2();
        let ray = |film| camera.ray(film, Vec2::splat(0.5));
        let (a, b) = (ray(middle), ray(middle + Vec2::X));
        PixelFootprint {
            width: a.o.distance(b.o),
            growth: a.d.distance(b.d),
        }
    }

    /// Width at `distance` m along a camera path, in m.
    pub(super) fn width_at(self, distance: f32) -> f32 {
        self.width + self.growth * distance
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{UVec2, Vec3};
    use crate::testing::scenes::Builder;

    #[test]
    fn a_crop_window_does_not_change_the_footprint_of_a_pixel() {
        let footprint = |crop: Option<UVec2>| {
            let mut b = Builder::new(Vec3::Z * 5.0, Vec3::ZERO, 90.0, 64);
            let grey = b.material(crate::testing::scenes::diffuse(0.5, 0.5, 0.5));
            b.rectangle(Vec3::ZERO, Vec3::X, Vec3::Y, grey, None);
            if let Some(offset) = crop {
                let film = &mut b.desc.sensors[0].film;
                (film.crop_offset, film.crop_size) = (offset, UVec2::splat(8));
            }
            PixelFootprint::of(&b.build().sensor).width_at(1.0)
        };
        let (whole, cropped) = (footprint(None), footprint(Some(UVec2::splat(56))));
        assert!(
            (cropped / whole - 1.0).abs() < 1e-3,
            "{cropped} and {whole}"
        );
    }
}
