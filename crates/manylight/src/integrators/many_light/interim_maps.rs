//! The interim maps of the many-light methods, as the camera sees them: the quantities that
//! placement follows, and the lights before and after relaxation. They are made of the particles
//! and lights of one pass.

use super::lights::{selected_sites, thinned, weighted};
use super::schedule::{GroupContext, PassGroup};
use super::{ManyLight, trace};
use crate::bsdf::{BsdfNumbers, Lobes};
use crate::color::Rgb;
use crate::geometry::Segment;
use crate::integrators::context::PassContext;
use crate::integrators::light_tracer::line_of_sight;
use crate::maps::density::{
    Bandwidth, DensityReceiver, IMPORTANCE_NEIGHBORS, density_estimate, importance_at,
};
use crate::maps::{KdTree, Neighbors};
use crate::math::{UVec2, Vec2, Vec3};
use crate::particles::{Importon, Photon};
use crate::scene::{PathLimits, Scene};
use crate::transport::walk::MAX_SPECULAR_SEGMENTS;
use crate::transport::{Vertex, Walk};
use crate::virtual_lights::Site;
use crate::virtual_lights::candidates::Candidates;
use crate::virtual_lights::relax::relax;
use rayon::prelude::*;

/// Photons in an estimate of irradiance, for a picture of it. With K photons of equal flux under
/// the Epanechnikov kernel, the relative standard deviation is `√(4/(3K))`, 10 %: 14 % with half as
/// many, 7 % with twice as many, for a radius larger by `√2`.
const IRRADIANCE_NEIGHBORS: usize = 128;
/// The middle of the unit square: the center of pixels and of the lens.
const MIDDLE: Vec2 = Vec2::splat(0.5);
/// Random numbers that choose the likelier of two lobes, in the middle of its directions.
const LIKELIEST: BsdfNumbers = BsdfNumbers {
    lobe: 0.5,
    direction: MIDDLE,
};

/// The interim maps: one value per pixel, rows from top to bottom, and the lights.
///
/// The value of a pixel is that at the first vertex with non-specular lobes of the camera path
/// through its center, which takes the likelier of the specular lobes at each vertex. It is 0 where
/// the path has no such vertex.
#[derive(Clone, Debug, PartialEq)]
pub struct InterimMaps {
    /// Width and height in pixels.
    pub size: UVec2,
    /// Importance, in 1/m².
    pub importance: Vec<f32>,
    /// Irradiance by the photons that may become lights, in W/m².
    pub irradiance: Vec<Rgb>,
    /// Importance times luminance of irradiance, in W/m⁴: the density of placed lights is
    /// proportional to it.
    pub product: Vec<f32>,
    /// Reflectance towards the viewer times cosine: a grey image on which lights can be drawn.
    pub shading: Vec<f32>,
    /// The lights before relaxation.
    pub placed: Vec<PlacedLight>,
    /// The same lights after relaxation.
    pub relaxed: Vec<PlacedLight>,
}

/// The position of a virtual light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedLight {
    /// Position, in m.
    pub p: Vec3,
    /// Geometric normal on the lit side, unit.
    pub n: Vec3,
    /// Position on the film, in pixels from the upper left, if the camera sees the light directly.
    pub film_position: Option<Vec2>,
}

/// The maps of the pass that `run` names, in a group of that pass alone, with the lights that a
/// pixel is shaded by. `None` if cancelled.
pub(super) fn interim_maps(
    method: &ManyLight,
    scene: &Scene,
    limits: PathLimits,
    run: &PassContext,
) -> Option<InterimMaps> {
    let method = &ManyLight {
        interleaving: 1,
        ..*method
    };
    let cx = &GroupContext {
        method,
        scene,
        limits,
        group: &PassGroup::single_pass(method, run.pass.index),
        run: *run,
    };
    let candidates = Candidates::by_flux(limits, trace::photons(cx));
    let importons = trace::importons(cx);
    let photons = candidates.photons.clone();
    let photon_map = (run.stats).time("maps", || KdTree::build_ordered(photons));
    let camera = MapCamera {
        scene,
        limits,
        importons: &importons,
        photons: &photon_map,
    };
    if run.cancelled() {
        return None;
    }
    let pixels = run.stats.time("shade", || camera.pixels());
    if run.cancelled() {
        return None;
    }
    let (placed, relaxed) = placed_lights(cx, &camera, candidates);
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

/// The lights before and after relaxation.
fn placed_lights(
    cx: &GroupContext,
    camera: &MapCamera,
    candidates: Candidates,
) -> (Vec<PlacedLight>, Vec<PlacedLight>) {
    let candidates = thinned(cx, weighted(cx, candidates, || camera.importons));
    cx.run.stats.time("lights", || {
        let sites = selected_sites(cx, &candidates);
        let relaxed = relax(cx.scene, &candidates, &sites);
        let photons = &candidates.photons;
        (
            camera.lights(photons, &sites),
            camera.lights(photons, &relaxed),
        )
    })
}

/// The values of a pixel.
#[derive(Clone, Copy, Default)]
struct MapPixel {
    importance: f32,
    irradiance: Rgb,
    shading: f32,
}

/// The camera, with the particles that it sees.
struct MapCamera<'s> {
    scene: &'s Scene,
    limits: PathLimits,
    importons: &'s KdTree<Importon>,
    photons: &'s KdTree<Photon>,
}

impl MapCamera<'_> {
    fn pixels(&self) -> Vec<MapPixel> {
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
                let vertex = self.first_non_specular_vertex(film_position);
                vertex.map_or(MapPixel::default(), |v| {
                    self.pixel(&v, near_importons, near_photons)
                })
            })
            .collect()
    }

    fn first_non_specular_vertex(&self, film_position: Vec2) -> Option<Vertex<'_>> {
        let ray = self.scene.sensor.ray(film_position, MIDDLE);
        let mut walk = Walk::from_sensor(self.scene, self.limits, ray);
        while let Some(v) = walk.advance() {
            if v.segments > MAX_SPECULAR_SEGMENTS || !self.limits.allow(v.segments + 1) {
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
    ) -> MapPixel {
        let (p, n) = (v.x.p, v.x.normal_towards(v.w_prev));
        let unbounded = Bandwidth {
            largest: f32::INFINITY,
            radius_scale: 1.0,
        };
        let mut irradiance = Rgb::BLACK;
        let receiver = DensityReceiver { p, n };
        let mut add = |photon: &Photon, weight| irradiance += photon.flux * weight;
        density_estimate(self.photons, receiver, unbounded, near_photons, &mut add);
        let reflected = v.bsdf.sample_wi(v.w_prev, LIKELIEST, Lobes::ALL);
        let albedo = reflected.map_or(0.0, |sample| sample.weight.luminance());
        MapPixel {
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

    /// Film position of a photon, if the camera sees the side on which it arrives, or any side of a
    /// transmitting surface.
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
        let line = line_of_sight(self.scene, self.limits, x.at, line)?;
        let is_seen = !self.scene.transmittance(&line).is_black();
        is_seen.then_some(seen.film_position)
    }
}
