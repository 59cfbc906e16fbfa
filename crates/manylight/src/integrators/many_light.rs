//! The method: light from virtual lights.
//!
//! A pass follows the paper's order: particles, maps, placement, creation ([`ManyLight::prepare`]), then every pixel is shaded
//! ([`Prepared::shade`]). Which path belongs to which term is said in [`super::partition`].

use super::{PassContext, first_surface};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::film::{Film, FilmSampler, Layer, TileSamples};
pub use crate::gather::{Clamp, Kernel};
use crate::gather::{Gather, ShadingPoint};
use crate::maps::density::{IMPORTANCE_NEIGHBORS, estimate, importance_at};
use crate::maps::{KdTree, Neighbors};
use crate::particles::{Importon, Photon, trace_importons, trace_photons};
use crate::stats::Stats;
use crate::sampling::{Sampler, Stream};
use crate::scene::{PathLimits, Scene};
use crate::transport::direct::{EmitterSample, found_environment, found_radiance};
use crate::transport::{Step, Vertex, Walk};
use crate::virtual_lights::{LightField, Shares, Site, assign, select};
use rayon::prelude::*;

/// Where lights stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// Photons kept with probability proportional to flux.
    Uniform,
    /// Proportional to importance x flux.
    Importance,
}

/// How much flux each light carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FluxRule {
    /// Its own photon's over the probability of having been kept.
    Density,
    /// That of all photons nearer to it than to any other light.
    Partition,
}

/// What each light shines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EmissionKind {
    /// The reflection of one photon.
    Single,
    /// The reflection of all its photons: diffuse part exact, glossy part in an octahedral table of this side.
    Table {
        /// Texels along an edge.
        side: u32,
    },
}

/// Indirect light from virtual lights. Each pass has its own lights and its own jitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManyLight {
    /// Virtual lights per pass.
    pub light_count: u32,
    /// Emitted photon paths per pass.
    pub photon_paths: u32,
    /// Importon paths per pass.
    pub importon_paths: u32,
    /// Where lights stand.
    pub placement: Placement,
    /// How much flux each carries.
    pub flux: FluxRule,
    /// What each shines.
    pub emission: EmissionKind,
    /// How one is evaluated.
    pub kernel: Kernel,
    /// What is done about the singularity.
    pub clamp: Clamp,
}

/// Photons in a caustic estimate.
const CAUSTIC_NEIGHBORS: usize = 48;
/// Largest radius of a caustic estimate as a share of the scene's diagonal.
const CAUSTIC_RADIUS: f32 = 0.01;
/// A specular branch goes on with probability `throughput x this`, at most 1: weak reflections are followed rarely.
const BRANCH_SURVIVAL: f32 = 4.0;
/// Specular chains longer than this end.
const MAX_CHAIN: u32 = 64;

impl ManyLight {
    /// Rich-VPLs: importance placement, partition, 32 x 32 tables, discs.
    pub fn rich_vpl() -> Self {
        ManyLight {
            light_count: 1024,
            photon_paths: 262_144,
            importon_paths: 32_768,
            placement: Placement::Importance,
            flux: FluxRule::Partition,
            emission: EmissionKind::Table { side: 32 },
            kernel: Kernel::Disc,
            clamp: Clamp::Auto,
        }
    }

    /// Classic VPLs: photons thinned at random.
    pub fn vpl() -> Self {
        ManyLight {
            placement: Placement::Uniform,
            flux: FluxRule::Density,
            emission: EmissionKind::Single,
            kernel: Kernel::Point,
            ..ManyLight::rich_vpl()
        }
    }

    /// VPLs placed by importance.
    pub fn vpl_importance() -> Self {
        ManyLight { placement: Placement::Importance, ..ManyLight::vpl() }
    }

    /// One sample per pixel under one set of lights. `false` if cancelled.
    pub(super) fn render_pass(&self, scene: &Scene, limits: PathLimits, run: &PassContext, film: &mut Film) -> bool {
        if run.cancelled() {
            return false;
        }
        let prepared = self.prepare(scene, limits, run);
        let positions = film.desc().sampler();
        run.shade(film, |samples| prepared.shade_tile(run, &positions, samples))
    }

    /// Everything that a pass shades with.
    pub fn prepare<'s>(&self, scene: &'s Scene, limits: PathLimits, run: &PassContext) -> Prepared<'s> {
        let (pass, stats) = (run.pass, run.stats);
        let photons = stats.time("photons", || trace_photons(scene, limits, self.photon_paths, pass));
        Stats::count(&stats.photon_paths, u64::from(self.photon_paths));
        Stats::count(&stats.photons, photons.len() as u64);
        let caustics = photons.iter().copied().filter(|p| p.event.has(Lobes::SPECULAR)).collect();
        // A light at depth m makes paths of at least m + 2 segments.
        let photons: Vec<Photon> = photons.into_iter().filter(|p| limits.allow(u32::from(p.depth) + 2)).collect();

        let weights = match self.placement {
            Placement::Uniform => photons.iter().map(|p| p.flux.luminance()).collect(),
            Placement::Importance => self.importance_weights(scene, limits, run, &photons),
        };
        let lights = stats.time("lights", || {
            let mut sampler = pass.sampler(Stream::Selection, 0);
            let sites = select(&photons, &weights, self.light_count as usize, sampler.next_1d());
            self.create(scene, &photons, &weights, &sites, sampler.next_1d())
        });
        Stats::count(&stats.lights, lights.lights().len() as u64);
        stats.light_bytes.fetch_max(lights.bytes() as u64, std::sync::atomic::Ordering::Relaxed);
        let caustics = stats.time("maps", || KdTree::build(caustics));
        let gather = Gather { kernel: self.kernel, clamp: self.clamp };
        Prepared { scene, limits, gather, lights, caustics }
    }
}

impl ManyLight {
    /// Importance x flux at every photon: the target density of the lights (paper; ALGORITHMS 1.4).
    fn importance_weights(
        &self,
        scene: &Scene,
        limits: PathLimits,
        run: &PassContext,
        photons: &[Photon],
    ) -> Vec<f32> {
        let importons: Vec<Importon> =
            run.stats.time("importons", || trace_importons(scene, limits, self.importon_paths, run.pass));
        Stats::count(&run.stats.importons, importons.len() as u64);
        run.stats.time("maps", || {
            let map = KdTree::build(importons);
            photons
                .par_iter()
                .map_init(
                    || Neighbors::new(IMPORTANCE_NEIGHBORS),
                    |found, photon| importance_at(&map, photon.p, photon.n, found) * photon.flux.luminance(),
                )
                .collect()
        })
    }

    /// Lights at `sites`: whose flux they carry, then what they shine.
    fn create<'s>(
        &self,
        scene: &'s Scene,
        photons: &[Photon],
        weights: &[f32],
        sites: &[Site],
        u: f32,
    ) -> LightField<'s> {
        let shares = match self.flux {
            FluxRule::Density => Shares::own(sites),
            FluxRule::Partition => assign(scene, photons, sites, weights, u),
        };
        match self.emission {
            EmissionKind::Single => LightField::single(scene, photons, &shares),
            EmissionKind::Table { side } => LightField::rich(scene, photons, &shares, side as usize),
        }
    }
}

/// Everything that one pass shades with.
#[derive(Debug)]
pub struct Prepared<'s> {
    scene: &'s Scene,
    limits: PathLimits,
    gather: Gather,
    /// The virtual lights.
    pub lights: LightField<'s>,
    /// Photons whose last event was specular.
    pub caustics: KdTree<Photon>,
}

/// A vertex of an eye path where virtual lights and caustic photons are summed.
struct Gathering<'s> {
    pixel: usize,
    throughput: Rgb,
    segments: u32,
    at: ShadingPoint<'s>,
}

impl<'s> Prepared<'s> {
    /// Shades the pixels of one tile: first all eye paths with their direct light, then the lights for all points together.
    fn shade_tile(&self, run: &PassContext, positions: &FilmSampler, out: &mut TileSamples) {
        let mut points = Vec::new();
        let mut shadow_rays = 0;
        for (i, pixel) in out.tile().pixels().enumerate() {
            let mut sampler = run.pass.sampler(Stream::Pixel, positions.index(pixel));
            let film = positions.sample(pixel, sampler.next_2d());
            let camera = self.scene.sensor.ray(film.position, sampler.next_2d());
            let walk = Walk::from_sensor(self.scene, camera.ray, Rgb::splat(camera.weight * film.weight));
            let mut eye = EyePath { prepared: self, walk, sampler, pixel: i, shadow_rays: 0 };
            eye.trace(out, &mut points);
            shadow_rays += eye.shadow_rays;
        }
        let (mut connections, mut clamped, mut unclamped) = (0, 0.0, 0.0);
        let mut found = Neighbors::new(CAUSTIC_NEIGHBORS);
        for point in &points {
            let gathered = self.gather.sum(self.scene, &self.lights, &point.at);
            out.add(point.pixel, Layer::VirtualLights, point.throughput * gathered.radiance);
            out.add(point.pixel, Layer::Caustics, point.throughput * self.caustic_radiance(point, &mut found));
            connections += gathered.connections;
            shadow_rays += gathered.shadow_rays;
            clamped += f64::from(gathered.clamped * point.throughput.luminance());
            unclamped += f64::from(gathered.unclamped * point.throughput.luminance());
        }
        Stats::count(&run.stats.camera_paths, out.tile().pixels().count() as u64);
        Stats::count(&run.stats.connections, connections);
        Stats::count(&run.stats.shadow_rays, shadow_rays);
        Stats::count(&run.stats.clamped, (clamped * 1e6) as u64);
        Stats::count(&run.stats.unclamped, (unclamped * 1e6) as u64);
    }

    /// Density estimate over photons whose last event was specular: `Σ_j k_j f Φ_j` (ALGORITHMS 2.16).
    fn caustic_radiance(&self, point: &Gathering, found: &mut Neighbors) -> Rgb {
        let x = &point.at.x;
        let n = if x.ng.dot(point.at.wo) >= 0.0 { x.ng } else { -x.ng };
        let reach = CAUSTIC_RADIUS * self.scene.geometry.bounds().diagonal();
        let mut sum = Rgb::BLACK;
        estimate(&self.caustics, x.p, n, reach, found, |photon, kernel| {
            if self.limits.allow(point.segments + u32::from(photon.depth)) {
                sum += photon.flux * point.at.bsdf.f(photon.wi, point.at.wo, Lobes::SMOOTH) * kernel;
            }
        });
        sum
    }
}

/// One eye path: emission and direct light on the way, and the points where lights are summed.
struct EyePath<'p, 's> {
    prepared: &'p Prepared<'s>,
    walk: Walk<'s>,
    sampler: Sampler,
    pixel: usize,
    shadow_rays: u64,
}

impl<'s> EyePath<'_, 's> {
    /// Follows specular events; every vertex with smooth lobes becomes a gathering point with those lobes alone.
    fn trace(&mut self, out: &mut TileSamples, points: &mut Vec<Gathering<'s>>) {
        let (scene, limits) = (self.prepared.scene, self.prepared.limits);
        loop {
            let step = self.walk.advance();
            let hidden = limits.hide_emitters && self.walk.previous().event == Lobes::NONE;
            let v = match step {
                Step::Escaped(wi) => {
                    if !hidden {
                        let found = found_environment(scene, self.walk.previous(), wi);
                        out.add(self.pixel, Layer::Emission, self.walk.throughput() * found);
                    }
                    return;
                }
                Step::Hit(v) => v,
            };
            if v.segments == 1 {
                first_surface(&v, &mut self.sampler, self.pixel, out);
            }
            if !hidden {
                let found = found_radiance(scene, self.walk.previous(), &v.x, v.w_prev);
                out.add(self.pixel, Layer::Emission, self.walk.throughput() * found);
            }
            if !limits.allow(v.segments + 1) {
                return;
            }
            if self.walk.pass_through(&v, self.sampler.next_1d()) {
                continue;
            }
            self.next_event(&v, out);
            if v.bsdf.lobes().has(Lobes::SMOOTH) {
                self.emitter_by_smooth_lobe(&v, out);
                points.push(self.gathering(&v));
            }
            if !self.follow_specular(&v) {
                return;
            }
        }
    }

    /// Light from an emitter chosen for `v`: by the smooth lobes it is direct light, by near-delta ones still emission.
    fn next_event(&mut self, v: &Vertex, out: &mut TileSamples) {
        let (scene, wo) = (self.prepared.scene, v.w_prev);
        if !v.bsdf.lobes().has(Lobes::FINITE) {
            return;
        }
        let Some(light) = EmitterSample::draw(scene, &v.x, v.bsdf.receiving_normal(wo), &mut self.sampler) else {
            return;
        };
        let reflected = |lobes: Lobes, walk: Lobes| {
            v.bsdf.f_cos_wi(light.wi, wo, lobes) * light.mis_weight(v.bsdf.pdf_wi(light.wi, wo, walk))
        };
        let smooth = reflected(Lobes::SMOOTH, Lobes::SMOOTH);
        let narrow = reflected(Lobes::NEAR_DELTA, Lobes::SPECULAR);
        if smooth.is_black() && narrow.is_black() {
            return;
        }
        self.shadow_rays += 1;
        let crossings = self.prepared.limits.max_depth.map_or(u32::MAX, |max| max - (v.segments + 1));
        let arriving = self.walk.throughput() * light.weight * light.transmittance(scene, crossings);
        out.add(self.pixel, Layer::Direct, arriving * smooth);
        out.add(self.pixel, Layer::Emission, arriving * narrow);
    }

    /// The other half of direct light: a direction drawn from the smooth lobes that runs into an emitter.
    fn emitter_by_smooth_lobe(&mut self, v: &Vertex<'s>, out: &mut TileSamples) {
        let (scene, limits) = (self.prepared.scene, self.prepared.limits);
        let mut walk = self.walk.clone();
        if !walk.scatter(v, self.sampler.next_bsdf(), Lobes::SMOOTH) {
            return;
        }
        loop {
            match walk.advance() {
                Step::Escaped(wi) => {
                    let found = found_environment(scene, walk.previous(), wi);
                    return out.add(self.pixel, Layer::Direct, walk.throughput() * found);
                }
                Step::Hit(y) => {
                    let found = found_radiance(scene, walk.previous(), &y.x, y.w_prev);
                    out.add(self.pixel, Layer::Direct, walk.throughput() * found);
                    if !limits.allow(y.segments + 1) || !walk.pass_through(&y, self.sampler.next_1d()) {
                        return;
                    }
                }
            }
        }
    }

    fn gathering(&mut self, v: &Vertex<'s>) -> Gathering<'s> {
        let max_photon_depth = self.prepared.limits.max_depth.map(|max| max - (v.segments + 1));
        let at =
            ShadingPoint { x: v.x, wo: v.w_prev, bsdf: v.bsdf, max_photon_depth, u: self.sampler.next_1d() };
        Gathering { pixel: self.pixel, throughput: self.walk.throughput(), segments: v.segments, at }
    }

    /// Continues by a specular event; weak branches only sometimes, since every one ends in another sum over all lights.
    fn follow_specular(&mut self, v: &Vertex) -> bool {
        if v.segments >= MAX_CHAIN
            || !v.bsdf.lobes().has(Lobes::SPECULAR)
            || !self.walk.scatter(v, self.sampler.next_bsdf(), Lobes::SPECULAR)
        {
            return false;
        }
        let after = self.walk.throughput().max_channel() * self.walk.eta_squared();
        let survival = (BRANCH_SURVIVAL * after).min(1.0);
        survival > 0.0 && self.walk.survive(survival, self.sampler.next_1d())
    }
}
