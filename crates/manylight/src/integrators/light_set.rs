//! The lights of some passes, and shading by them.

use super::PassContext;
use super::carried::{CARRIED_NEIGHBORS, CompensationPhoton};
use super::caustics::CAUSTIC_NEIGHBORS;
use super::eye_path::{CameraPath, CameraPaths, GatherPoint, Part, PixelNumbers, starts};
use super::partition::Stage;
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::film::{FilmSampler, Layer, TileSamples};
use crate::gather::{
    CutLimits, Gather, Gathered, LightIndex, ShadingPoint, ShareOf, Strategy, Subset,
};
use crate::maps::{IncidentMap, KdTree, Neighbors};
use crate::math::Vec2;
use crate::particles::Photon;
use crate::sampling::{Pass, Stream};
use crate::scene::{PathLimits, Scene};
use crate::stats::Stats;
use crate::transport::Walk;
use crate::virtual_lights::NearestLights;
use std::ops::Range;

/// What is done about the light that the clamp takes away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compensation {
    /// It is lost.
    None,
    /// Directions drawn from the smooth lobes find it, and the method starts again where they end; see [`super::smooth_light`].
    /// Photons bring what narrow lobes reflect from emitters.
    KolligKeller,
}

/// Everything that some passes shade with.
#[derive(Debug)]
pub struct PreparedPasses<'s> {
    pub(super) scene: &'s Scene,
    pub(super) limits: PathLimits,
    pub(super) gather: Gather,
    pub(super) compensation: Compensation,
    /// The virtual lights.
    pub lights: LightIndex<'s>,
    /// Which light a photon anywhere would belong to.
    pub claims: NearestLights,
    /// Photons whose last event was specular.
    pub caustics: KdTree<Photon>,
    /// Photons that bring some of what the clamp takes.
    pub(super) carried: KdTree<CompensationPhoton>,
    /// Radiance by which clusters of lights may be off in any pixel, luminance; 0 without clusters.
    pub(super) tolerance: f32,
    /// Where light from afar comes from.
    pub(super) incident: IncidentMap,
    /// Width of a pixel at the camera, in m, and its growth per m.
    pub(super) pixel: (f32, f32),
    /// The passes that share the lights.
    pub(super) passes: Range<u32>,
    /// Among how many of them in turn the lights are divided: a divisor of their number.
    pub(super) parts: u32,
    /// Which part the first pass gets. Random, so that passes short of a whole set have the right mean.
    pub(super) first_part: u32,
}

/// Width of a pixel in the middle of the film: at the camera, and its growth with the distance.
pub(super) fn pixel_width(scene: &Scene) -> (f32, f32) {
    let middle = scene.sensor.desc().film.size.as_vec2() * 0.5;
    let ray = |film| scene.sensor.ray(film, Vec2::splat(0.5)).ray;
    let (a, b) = (ray(middle), ray(middle + Vec2::X));
    (a.o.distance(b.o), a.d.distance(b.d))
}

/// Points of the picture whose mean tells how bright it is about,
const PROBES: u32 = 256;
/// by so many clusters of lights at most.
const PROBE_LIGHTS: u32 = 64;
/// Errors count where they are seen: a pixel counts as no darker than this share of the mean.
pub const DARK: f32 = 0.05;

impl<'s> PreparedPasses<'s> {
    /// The set with the tolerance that its cuts may have, if it has any.
    pub(super) fn with_tolerance(self, pass: Pass) -> Self {
        let Strategy::Cuts(limits) = self.gather.strategy else {
            return self;
        };
        let size = self.scene.sensor.desc().film.size.as_vec2();
        let probe = |k: u32| {
            let mut sampler = pass.sampler(Stream::Selection, 4 + u64::from(k));
            let film = sampler.next_2d() * size;
            let ray = self.scene.sensor.ray(film, sampler.next_2d()).ray;
            let (_, x) = self.scene.intersect(&ray)?;
            Some(ShadingPoint {
                x,
                wo: -ray.d,
                bsdf: self.scene.bsdf(&x),
                max_photon_depth: None,
                u: 0.5,
                lights: Subset::ALL,
                tolerance: 0.0,
                lit_from: None,
            })
        };
        let probes: Vec<ShadingPoint> = (0..PROBES).filter_map(probe).collect();
        let coarse = Gather {
            strategy: Strategy::Cuts(CutLimits {
                max_lights: PROBE_LIGHTS,
                ..limits
            }),
            ..self.gather
        };
        let sums = coarse.sum(self.scene, &self.lights, &probes);
        let radiance = |sum: &Gathered| sum.radiance.luminance();
        let mean = sums.iter().map(radiance).sum::<f32>() / PROBES as f32;
        PreparedPasses {
            tolerance: limits.max_error * DARK * mean,
            ..self
        }
    }

    /// The points with the sums over lights there.
    fn sums(&self, points: Vec<GatherPoint<'s>>) -> Vec<(GatherPoint<'s>, Gathered)> {
        let limits = match self.gather.strategy {
            Strategy::Cuts(limits) if limits.share_of == ShareOf::Pixel => limits,
            _ => return self.sums_within(points, |_| self.tolerance),
        };
        let (seen, beyond): (Vec<_>, Vec<_>) = points
            .into_iter()
            .partition(|point| point.stage == Stage::BeforeX);
        let mut sums = self.sums_within(seen, |_| self.tolerance);
        let pixels = sums.iter().map(|(point, _)| point.pixel + 1).max();
        let mut shown = vec![0.0; pixels.unwrap_or(0)];
        for (point, gathered) in &sums {
            let radiance = point.throughput * gathered.radiance;
            shown[point.pixel] += radiance.luminance();
        }
        sums.extend(self.sums_within(beyond, |point| {
            let shown = shown.get(point.pixel).copied().unwrap_or(0.0);
            self.tolerance.max(limits.max_error * shown)
        }));
        sums
    }

    /// The same, where a cluster of lights may be off by so much in the pixel of a point.
    fn sums_within(
        &self,
        mut points: Vec<GatherPoint<'s>>,
        tolerance: impl Fn(&GatherPoint<'s>) -> f32,
    ) -> Vec<(GatherPoint<'s>, Gathered)> {
        for point in &mut points {
            let throughput = point.throughput.luminance().max(f32::MIN_POSITIVE);
            point.at.tolerance = tolerance(point) / throughput;
        }
        let places: Vec<ShadingPoint> = points.iter().map(|point| point.at).collect();
        let sums = self.gather.sum(self.scene, &self.lights, &places);
        points.into_iter().zip(sums).collect()
    }

    /// The lights of one of the passes.
    fn selection(&self, pass: u32) -> Subset {
        let part = self.first_part + (pass - self.passes.start);
        Subset::ALL.part(part % self.parts, self.parts)
    }

    /// Shades the pixels of one tile: first all eye paths with their direct light, then the lights for all points together.
    pub(super) fn shade_tile(
        &self,
        run: &PassContext,
        positions: &FilmSampler,
        out: &mut TileSamples,
    ) {
        let lights = self.selection(run.pass.index);
        let mut paths = CameraPaths::new(self, run.pass, out);
        let starts = starts(self.gather.strategy);
        for (i, pixel) in paths.out.tile().pixels().enumerate() {
            let mut sampler = run.pass.sampler(Stream::Pixel, positions.index(pixel));
            let numbers = PixelNumbers::draw(&mut sampler);
            for index in 0..starts {
                // Few passes must do: their positions in the pixel are spread, so that edges are smooth.
                let number = positions.index(pixel);
                let u =
                    (run.pass).low_discrepancy_2d_in_parts(Stream::Pixel, number, index, starts);
                let film = positions.sample(pixel, u);
                let camera = self.scene.sensor.ray(film.position, sampler.next_2d());
                let weight = camera.weight * film.weight / starts as f32;
                let walk =
                    Walk::from_sensor(self.scene, self.limits, camera.ray, Rgb::splat(weight));
                let mut path = CameraPath {
                    set: self,
                    lights,
                    walk,
                    sampler: &mut sampler,
                    numbers,
                    pixel: i,
                    paths: &mut paths,
                    length: 0.0,
                    part: Part { index, of: starts },
                };
                path.trace();
            }
        }
        let CameraPaths {
            points,
            mut shadow_rays,
            ..
        } = paths;
        let (mut connections, mut clamped, mut unclamped) = (0, 0.0, 0.0);
        let mut found = Neighbors::new(CAUSTIC_NEIGHBORS);
        let mut found_carried = Neighbors::new(CARRIED_NEIGHBORS);
        for (point, gathered) in self.sums(points) {
            let layer = |event| point.stage.after(Lobes::NON_SPECULAR).after(event).layer();
            out.add(
                point.pixel,
                layer(Lobes::NON_SPECULAR),
                point.throughput * gathered.radiance,
            );
            out.add(
                point.pixel,
                layer(Lobes::SPECULAR),
                point.throughput * self.caustic_radiance(&point, &mut found),
            );
            out.add(
                point.pixel,
                layer(Lobes::NON_SPECULAR),
                point.throughput * self.carried_radiance(&point, &mut found_carried),
            );
            connections += gathered.connections;
            shadow_rays += gathered.shadow_rays;
            if point.stage == Stage::BeforeX {
                // Within a cluster that could not be refined, nothing bounds it.
                let error = gathered.cluster_error.min(1.0);
                let bound = point.throughput * gathered.radiance * error;
                out.add(
                    point.pixel,
                    Layer::CutSize,
                    Rgb::splat(gathered.terms as f32),
                );
                out.add(point.pixel, Layer::CutBound, Rgb::splat(bound.luminance()));
                clamped += f64::from(gathered.clamped * point.throughput.luminance());
                unclamped += f64::from(gathered.unclamped * point.throughput.luminance());
            }
        }
        Stats::count(&run.stats.camera_paths, out.tile().pixels().count() as u64);
        Stats::count(&run.stats.connections, connections);
        Stats::count(&run.stats.shadow_rays, shadow_rays);
        Stats::count(&run.stats.clamped, (clamped * 1e6) as u64);
        Stats::count(&run.stats.unclamped, (unclamped * 1e6) as u64);
    }
}
