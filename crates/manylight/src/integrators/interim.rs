//! The interim maps of the many-light methods, as the camera sees them: what placement follows, and where lights stand before
//! and after relaxation. They are made of the particles and lights of the first pass.

use super::PassContext;
use super::axes::Placement;
use super::candidates::{Candidates, fluxes, importance_times_flux, light_carriers};
use super::eye_path::MAX_CHAIN;
use super::light_tracer::line_of_sight;
use super::many_light::ManyLight;
use crate::bsdf::{BsdfNumbers, Lobes};
use crate::color::Rgb;
use crate::geometry::Segment;
use crate::maps::density::{
    Bandwidth, DensityReceiver, IMPORTANCE_NEIGHBORS, density_estimate, importance_at,
};
use crate::maps::{KdTree, Neighbors};
use crate::math::{UVec2, Vec2, Vec3};
use crate::particles::{Importon, Photon};
use crate::scene::{PathLimits, Scene};
use crate::transport::{Step, Vertex, Walk};
use crate::virtual_lights::Site;
use crate::virtual_lights::relax::relax;
use rayon::prelude::*;

/// Photons in an estimate of irradiance: so many that a picture of it is smooth.
const IRRADIANCE_NEIGHBORS: usize = 128;
/// The middle of everything that walks draw: of pixels, of the lens, and of lobes, where it stands for the likelier one.
const MIDDLE: Vec2 = Vec2::splat(0.5);

/// The interim maps: one value per pixel, rows from top to bottom, and the lights.
///
/// A pixel tells of the first point with smooth lobes that is seen through its centre by specular events, each of which takes its
/// likelier way; where there is none, its values are 0.
#[derive(Clone, Debug, PartialEq)]
pub struct InterimMaps {
    /// Width and height in pixels.
    pub size: UVec2,
    /// Importance that arrives from the points that sum lights, in 1/m².
    pub importance: Vec<f32>,
    /// Flux of the photons that may become lights, per area, in W/m².
    pub irradiance: Vec<Rgb>,
    /// Importance times luminance of irradiance, in W/m⁴: by how much the density of lights that are placed by importance grows.
    pub product: Vec<f32>,
    /// Reflectance towards the viewer times cosine there: grey surfaces for lights to be drawn on.
    pub shading: Vec<f32>,
    /// The lights before relaxation.
    pub placed: Vec<PlacedLight>,
    /// The same lights after relaxation.
    pub relaxed: Vec<PlacedLight>,
}

/// Where a virtual light stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedLight {
    /// Position, in m.
    pub p: Vec3,
    /// Geometric normal on the lit side, unit.
    pub n: Vec3,
    /// Position on the film, in pixels from the upper left, if the camera sees the light straight.
    pub film_position: Option<Vec2>,
}

impl ManyLight {
    /// The maps of the pass that `run` names, which makes its lights for itself alone. `None` if cancelled.
    pub fn interim_maps(
        &self,
        scene: &Scene,
        limits: PathLimits,
        run: &PassContext,
    ) -> Option<InterimMaps> {
        let photons = light_carriers(limits, self.trace_photons(scene, limits, run));
        let importons = self.importance_map(scene, limits, run);
        let seen = See {
            scene,
            limits,
            importons: &importons,
            photons: &run
                .stats
                .time("maps", || KdTree::build_ordered(photons.clone())),
        };
        if run.cancelled() {
            return None;
        }
        let pixels = run.stats.time("shade", || seen.pixels());
        if run.cancelled() {
            return None;
        }
        let weights = match self.placement {
            Placement::Uniform => fluxes(&photons),
            Placement::Importance | Placement::Relaxed => {
                importance_times_flux(&importons, &photons, run.stats)
            }
        };
        let (placed, relaxed) = run.stats.time("lights", || {
            let Candidates {
                photons,
                weights,
                u_sites,
                ..
            } = self.candidates(run, photons, weights, 1.0);
            let sites = self.choose(&photons, &weights, u_sites);
            let relaxed = relax(scene, &photons, &sites);
            (
                seen.lights(&photons, &sites),
                seen.lights(&photons, &relaxed),
            )
        });
        Some(InterimMaps {
            size: scene.sensor.desc().film.crop_size,
            importance: pixels.iter().map(|p| p.importance).collect(),
            irradiance: pixels.iter().map(|p| p.irradiance).collect(),
            product: (pixels.iter())
                .map(|p| p.importance * p.irradiance.luminance())
                .collect(),
            shading: pixels.iter().map(|p| p.shading).collect(),
            placed,
            relaxed,
        })
    }
}

/// What a pixel tells.
#[derive(Clone, Copy, Default)]
struct Pixel {
    importance: f32,
    irradiance: Rgb,
    shading: f32,
}

/// What is seen.
struct See<'s> {
    scene: &'s Scene,
    limits: PathLimits,
    importons: &'s KdTree<Importon>,
    photons: &'s KdTree<Photon>,
}

impl See<'_> {
    fn pixels(&self) -> Vec<Pixel> {
        let size = self.scene.sensor.desc().film.crop_size;
        let memory = || {
            (
                Neighbors::new(IMPORTANCE_NEIGHBORS),
                Neighbors::new(IRRADIANCE_NEIGHBORS),
            )
        };
        (0..size.x as usize * size.y as usize)
            .into_par_iter()
            .with_min_len(256)
            .map_init(memory, |(near_importons, near_photons), i| {
                let pixel = UVec2::new(i as u32 % size.x, i as u32 / size.x);
                let film_position = pixel.as_vec2() + MIDDLE;
                self.look(film_position).map_or(Pixel::default(), |v| {
                    self.pixel(&v, near_importons, near_photons)
                })
            })
            .collect()
    }

    /// The first point with smooth lobes.
    fn look(&self, film_position: Vec2) -> Option<Vertex<'_>> {
        let ray = self.scene.sensor.ray(film_position, MIDDLE).ray;
        let mut walk = Walk::from_sensor(self.scene, self.limits, ray, Rgb::WHITE);
        while let Step::Hit(v) = walk.advance() {
            if v.segments > MAX_CHAIN || !self.limits.allow(v.segments + 1) {
                return None;
            }
            if walk.pass_through(&v, MIDDLE.x) {
                continue;
            }
            if v.bsdf.lobes().has(Lobes::NON_SPECULAR) {
                return Some(v);
            }
            if !walk.scatter(&v, LIKELIEST, Lobes::SPECULAR) {
                return None;
            }
        }
        None
    }

    fn pixel(
        &self,
        v: &Vertex,
        near_importons: &mut Neighbors,
        near_photons: &mut Neighbors,
    ) -> Pixel {
        let (p, n) = (v.x.p, v.x.normal_towards(v.w_prev));
        let whole = Bandwidth {
            largest: f32::INFINITY,
            share: 1.0,
        };
        let mut irradiance = Rgb::BLACK;
        let receiver = DensityReceiver { p, n };
        density_estimate(
            self.photons,
            receiver,
            whole,
            near_photons,
            |photon, weight| irradiance += photon.flux * weight,
        );
        let reflected = v.bsdf.sample_wi(v.w_prev, LIKELIEST, Lobes::ALL);
        let albedo = reflected.map_or(0.0, |sample| sample.weight.luminance());
        Pixel {
            importance: importance_at(self.importons, p, n, near_importons),
            irradiance,
            shading: albedo.min(1.0) * n.dot(v.w_prev),
        }
    }

    fn lights(&self, photons: &[Photon], sites: &[Site]) -> Vec<PlacedLight> {
        let light = |site: &Site| {
            let photon = &photons[site.photon as usize];
            PlacedLight {
                p: photon.p,
                n: photon.n,
                film_position: self.film_position(photon),
            }
        };
        sites.par_iter().map(light).collect()
    }

    /// Where the camera sees the lit side of the photon's place, or any side of a surface that lets light through.
    fn film_position(&self, photon: &Photon) -> Option<Vec2> {
        let seen = self.scene.sensor.connect(photon.p, MIDDLE)?;
        let x = self.scene.surface_point(photon.at);
        if photon.n.dot(seen.w) <= 0.0 && !self.scene.bsdf(&x).transmits() {
            return None;
        }
        let line = Segment {
            from: x.offset_towards(seen.w),
            to: seen.target,
        };
        let line = line_of_sight(self.scene, self.limits, &x, line)?;
        let is_seen = !self.scene.transmittance(&line).is_black();
        is_seen.then_some(seen.film_position)
    }
}

/// Takes the likelier of two lobes, in its middle.
const LIKELIEST: BsdfNumbers = BsdfNumbers {
    lobe: 0.5,
    direction: MIDDLE,
};
