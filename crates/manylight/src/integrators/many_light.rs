//! The method: light from virtual lights.
//!
//! A pass follows the paper's order: particles, maps, placement, creation ([`ManyLight::prepare`]), then every pixel is shaded
//! ([`Prepared::shade`]). Which path belongs to which term is said in [`super::partition`].

use super::{PassContext, first_surface};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::film::{Film, FilmSampler, Layer, TileSamples};
pub use crate::gather::{Clamp, Kernel};
use crate::gather::{Gather, Lights, ShadingPoint};
use crate::maps::density::{IMPORTANCE_NEIGHBORS, estimate, importance_at};
use crate::maps::{KdTree, Neighbors};
use crate::particles::{Importon, Photon, trace_importons, trace_photons};
use crate::sampling::{Sampler, Stream};
use crate::scene::{PathLimits, Scene};
use crate::stats::Stats;
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

/// Estimates of direct light per gathering point: cheap beside the sum over all lights, and without them its noise would show.
const DIRECT_SAMPLES: u32 = 4;
/// Photons that ask for their importance, per light.
const CANDIDATES_PER_LIGHT: usize = 32;
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
            light_count: 512,
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
        ManyLight {
            placement: Placement::Importance,
            ..ManyLight::vpl()
        }
    }

    /// One sample per pixel under one set of lights. `false` if cancelled.
    pub(super) fn render_pass(
        &self,
        scene: &Scene,
        limits: PathLimits,
        run: &PassContext,
        film: &mut Film,
    ) -> bool {
        if run.cancelled() {
            return false;
        }
        let prepared = self.prepare(scene, limits, run);
        let positions = film.desc().sampler();
        run.shade(film, |samples| {
            prepared.shade_tile(run, &positions, samples)
        })
    }

    /// Everything that a pass shades with.
    pub fn prepare<'s>(
        &self,
        scene: &'s Scene,
        limits: PathLimits,
        run: &PassContext,
    ) -> Prepared<'s> {
        let (pass, stats) = (run.pass, run.stats);
        let photons = stats.time("photons", || {
            trace_photons(scene, limits, self.photon_paths, pass)
        });
        Stats::count(&stats.photon_paths, u64::from(self.photon_paths));
        Stats::count(&stats.photons, photons.len() as u64);
        let caustics = photons
            .iter()
            .copied()
            .filter(|p| p.event.has(Lobes::SPECULAR))
            .collect();
        // A light at depth m makes paths of at least m + 2 segments.
        let photons: Vec<Photon> = photons
            .into_iter()
            .filter(|p| limits.allow(u32::from(p.depth) + 2))
            .collect();

        let fluxes: Vec<f32> = photons.iter().map(|p| p.flux.luminance()).collect();
        let mut sampler = pass.sampler(Stream::Selection, 0);
        let sites = match self.placement {
            Placement::Uniform => stats.time("lights", || {
                select(
                    &photons,
                    &fluxes,
                    self.light_count as usize,
                    sampler.next_1d(),
                )
            }),
            Placement::Importance => {
                self.place_by_importance(scene, limits, run, &photons, &fluxes, &mut sampler)
            }
        };
        let lights = stats.time("lights", || {
            let shares = match self.flux {
                FluxRule::Density => Shares::own(&sites),
                FluxRule::Partition => assign(scene, &photons, &sites, &fluxes, sampler.next_1d()),
            };
            match self.emission {
                EmissionKind::Single => LightField::single(scene, limits, &photons, &shares),
                EmissionKind::Table { side } => {
                    LightField::rich(scene, limits, &photons, &shares, side as usize)
                }
            }
        });
        Stats::count(&stats.lights, lights.lights().len() as u64);
        stats
            .light_bytes
            .fetch_max(lights.bytes() as u64, std::sync::atomic::Ordering::Relaxed);
        let caustics = stats.time("maps", || KdTree::build_ordered(caustics));
        let gather = Gather {
            kernel: self.kernel,
            clamp: self.clamp,
        };
        Prepared {
            scene,
            limits,
            gather,
            lights: Lights::new(lights),
            caustics,
        }
    }
}

impl ManyLight {
    /// Sites with density importance x flux (paper), in two steps: candidates by flux, then lights among
    /// them by importance, so that few photons ask for theirs. A site's probability is the product of both.
    fn place_by_importance(
        &self,
        scene: &Scene,
        limits: PathLimits,
        run: &PassContext,
        photons: &[Photon],
        fluxes: &[f32],
        sampler: &mut Sampler,
    ) -> Vec<Site> {
        let stats = run.stats;
        let importons: Vec<Importon> = stats.time("importons", || {
            trace_importons(scene, limits, self.importon_paths, run.pass)
        });
        Stats::count(&stats.importons, importons.len() as u64);
        let map = stats.time("maps", || KdTree::build_ordered(importons));
        stats.time("lights", || {
            let count = self.light_count as usize;
            let candidates = select(
                photons,
                fluxes,
                CANDIDATES_PER_LIGHT * count,
                sampler.next_1d(),
            );
            let chosen: Vec<Photon> = candidates
                .iter()
                .map(|site| photons[site.photon as usize])
                .collect();
            let weights: Vec<f32> = candidates
                .par_iter()
                .zip(&chosen)
                .map_init(
                    || Neighbors::new(IMPORTANCE_NEIGHBORS),
                    |found, (site, photon)| {
                        let importance = importance_at(&map, photon.p, photon.n, found);
                        importance * photon.flux.luminance() / site.probability
                    },
                )
                .collect();
            let kept = select(&chosen, &weights, count, sampler.next_1d());
            let combine = |site: Site| {
                let candidate = candidates[site.photon as usize];
                Site {
                    photon: candidate.photon,
                    probability: candidate.probability * site.probability,
                }
            };
            kept.into_iter().map(combine).collect()
        })
    }
}

/// Everything that one pass shades with.
#[derive(Debug)]
pub struct Prepared<'s> {
    scene: &'s Scene,
    limits: PathLimits,
    gather: Gather,
    /// The virtual lights.
    pub lights: Lights<'s>,
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
            // Few passes must do: their positions in the pixel are spread, so that edges are smooth.
            let film = positions.sample(
                pixel,
                run.pass.spread_2d(Stream::Pixel, positions.index(pixel)),
            );
            let camera = self.scene.sensor.ray(film.position, sampler.next_2d());
            let walk = Walk::from_sensor(
                self.scene,
                self.limits,
                camera.ray,
                Rgb::splat(camera.weight * film.weight),
            );
            let mut eye = EyePath {
                prepared: self,
                walk,
                sampler,
                pixel: i,
                shadow_rays: 0,
            };
            eye.trace(out, &mut points);
            shadow_rays += eye.shadow_rays;
        }
        let (mut connections, mut clamped, mut unclamped) = (0, 0.0, 0.0);
        let mut found = Neighbors::new(CAUSTIC_NEIGHBORS);
        let places: Vec<ShadingPoint> = points.iter().map(|point| point.at).collect();
        let sums = self.gather.sum(self.scene, &self.lights, &places);
        for (point, gathered) in points.iter().zip(sums) {
            out.add(
                point.pixel,
                Layer::VirtualLights,
                point.throughput * gathered.radiance,
            );
            out.add(
                point.pixel,
                Layer::Caustics,
                point.throughput * self.caustic_radiance(point, &mut found),
            );
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

    /// Density estimate over photons whose last event was specular: `Σ_j k_j f Φ_j`.
    fn caustic_radiance(&self, point: &Gathering, found: &mut Neighbors) -> Rgb {
        let x = &point.at.x;
        let n = if x.ng.dot(point.at.wo) >= 0.0 {
            x.ng
        } else {
            -x.ng
        };
        let reach = CAUSTIC_RADIUS * self.scene.geometry.bounds().diagonal();
        let mut sum = Rgb::BLACK;
        estimate(&self.caustics, x.p, n, reach, found, |photon, kernel| {
            if self.limits.allow(point.segments + u32::from(photon.depth)) {
                sum +=
                    photon.flux * point.at.bsdf.f(photon.wi, point.at.wo, Lobes::SMOOTH) * kernel;
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
            let v = match self.walk.advance() {
                Step::Hidden => return,
                Step::Escaped(wi) => {
                    let found = found_environment(scene, self.walk.previous(), wi);
                    out.add(self.pixel, Layer::Emission, self.walk.throughput() * found);
                    return;
                }
                Step::Hit(v) => v,
            };
            if v.segments == 1 {
                first_surface(&v, &mut self.sampler, self.pixel, out);
            }
            let found = found_radiance(scene, self.walk.previous(), &v.x, v.w_prev);
            out.add(self.pixel, Layer::Emission, self.walk.throughput() * found);
            if !limits.allow(v.segments + 1) {
                return;
            }
            if self.walk.pass_through(&v, self.sampler.next_1d()) {
                continue;
            }
            self.narrow_emission(&v, out);
            if v.bsdf.lobes().has(Lobes::SMOOTH) {
                for _ in 0..DIRECT_SAMPLES {
                    self.direct_from_emitter(&v, out);
                    self.direct_by_smooth_lobe(&v, out);
                }
                points.push(self.gathering(&v));
            }
            if !self.follow_specular(&v) {
                return;
            }
        }
    }

    /// Direct light at `v`: an emitter is chosen, and the smooth lobes reflect it.
    fn direct_from_emitter(&mut self, v: &Vertex, out: &mut TileSamples) {
        if let Some(radiance) = self.emitter_light(v, Lobes::SMOOTH, Lobes::SMOOTH) {
            out.add(self.pixel, Layer::Direct, radiance / DIRECT_SAMPLES as f32);
        }
    }

    /// The same by near-delta lobes, which belongs to the emission: the walk that follows them is the other half of it.
    fn narrow_emission(&mut self, v: &Vertex, out: &mut TileSamples) {
        if v.bsdf.lobes().has(Lobes::NEAR_DELTA)
            && let Some(radiance) = self.emitter_light(v, Lobes::NEAR_DELTA, Lobes::SPECULAR)
        {
            out.add(self.pixel, Layer::Emission, radiance);
        }
    }

    /// Light from a chosen emitter by `lobes` at `v`, weighted against a walk that samples `walk` there.
    fn emitter_light(&mut self, v: &Vertex, lobes: Lobes, walk: Lobes) -> Option<Rgb> {
        let (scene, wo) = (self.prepared.scene, v.w_prev);
        let light =
            EmitterSample::draw(scene, &v.x, v.bsdf.receiving_normal(wo), &mut self.sampler)?;
        let f_cos = v.bsdf.f_cos_wi(light.wi, wo, lobes);
        if f_cos.is_black() {
            return None;
        }
        self.shadow_rays += 1;
        let crossings = self
            .prepared
            .limits
            .max_depth
            .map_or(u32::MAX, |max| max - (v.segments + 1));
        let arriving =
            self.walk.throughput() * light.weight * light.transmittance(scene, crossings);
        Some(arriving * f_cos * light.mis_weight(v.bsdf.pdf_wi(light.wi, wo, walk)))
    }

    /// The other half of direct light: a direction drawn from the smooth lobes that runs into an emitter.
    fn direct_by_smooth_lobe(&mut self, v: &Vertex<'s>, out: &mut TileSamples) {
        let (scene, limits) = (self.prepared.scene, self.prepared.limits);
        let mut walk = self.walk.clone();
        if !walk.scatter(v, self.sampler.next_bsdf(), Lobes::SMOOTH) {
            return;
        }
        loop {
            match walk.advance() {
                Step::Hidden => return,
                Step::Escaped(wi) => {
                    let found = found_environment(scene, walk.previous(), wi);
                    return out.add(
                        self.pixel,
                        Layer::Direct,
                        walk.throughput() * found / DIRECT_SAMPLES as f32,
                    );
                }
                Step::Hit(y) => {
                    let found = found_radiance(scene, walk.previous(), &y.x, y.w_prev);
                    out.add(
                        self.pixel,
                        Layer::Direct,
                        walk.throughput() * found / DIRECT_SAMPLES as f32,
                    );
                    if !limits.allow(y.segments + 1)
                        || !walk.pass_through(&y, self.sampler.next_1d())
                    {
                        return;
                    }
                }
            }
        }
    }

    fn gathering(&mut self, v: &Vertex<'s>) -> Gathering<'s> {
        let max_photon_depth = self
            .prepared
            .limits
            .max_depth
            .map(|max| max - (v.segments + 1));
        let at = ShadingPoint {
            x: v.x,
            wo: v.w_prev,
            bsdf: v.bsdf,
            max_photon_depth,
            u: self.sampler.next_1d(),
        };
        Gathering {
            pixel: self.pixel,
            throughput: self.walk.throughput(),
            segments: v.segments,
            at,
        }
    }

    /// Continues by a specular event; weak branches only sometimes, since every one ends in another sum over all lights.
    fn follow_specular(&mut self, v: &Vertex) -> bool {
        if v.segments >= MAX_CHAIN
            || !v.bsdf.lobes().has(Lobes::SPECULAR)
            || !self
                .walk
                .scatter(v, self.sampler.next_bsdf(), Lobes::SPECULAR)
        {
            return false;
        }
        let after = self.walk.throughput().max_channel() * self.walk.eta_squared();
        let survival = (BRANCH_SURVIVAL * after).min(1.0);
        survival > 0.0 && self.walk.survive(survival, self.sampler.next_1d())
    }
}
