//! The method: light from virtual lights.
//!
//! A pass follows the paper's order: particles, maps, placement, creation ([`ManyLight::prepare`]), then every pixel is shaded
//! ([`LightSet::shade`]). Which path belongs to which term is said in [`super::partition`].

use super::PassContext;
use super::eye_path::{EyePath, Gathering};
use super::partition::Stage;
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::film::{Film, FilmSampler, TileSamples};
pub use crate::gather::{Clamp, Kernel};
use crate::gather::{Gather, Lights, Selection, ShadingPoint};
use crate::maps::density::{Bandwidth, IMPORTANCE_NEIGHBORS, estimate, importance_at};
use crate::maps::{Incident, IncidentMap, KdTree, Neighbors};
use crate::math::Vec2;
use crate::particles::{Importon, Photon, trace_importons, trace_photons};
use crate::sampling::{Pass, Stream};
use crate::scene::{PathLimits, Scene};
use crate::stats::Stats;
use crate::transport::Walk;
use crate::virtual_lights::{Claims, LightField, Shares, assign, select};
use rayon::prelude::*;
use std::ops::Range;

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
    /// How the light that the clamp takes away is given back.
    pub complement: Complement,
}

/// What is done about the light that the clamp takes away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Complement {
    /// It is lost.
    None,
    /// Directions drawn from the smooth lobes find it, and the method starts again where they end; see
    /// [`super::eye_path`].
    KolligKeller,
}

/// Photons in a caustic estimate.
const CAUSTIC_NEIGHBORS: usize = 48;
/// Largest radius of a caustic estimate in pixels, after one pass.
const CAUSTIC_PIXELS: f32 = 8.0;
/// And as a share of the scene's diagonal.
const CAUSTIC_RADIUS: f32 = 0.01;
/// Passes that share one set of lights, at most; each shades by its own part of them.
const MAX_PASSES_PER_SET: u32 = 8;
/// No set for more than one pass has more lights than this,
const MAX_SET_LIGHTS: u32 = 32_768;
/// or is made of more photon paths.
const MAX_SET_PHOTON_PATHS: u32 = 1 << 22;
/// Radii shrink with the number of passes to the power of less this, so that the mean over passes goes to the right picture:
/// squared radii by n^(-1/3), where the errors by blur and by noise fall alike.
/// Source: Knaus, Zwicker, "Progressive Photon Mapping: A Probabilistic Approach", ACM TOG 2011, with alpha = 2/3.
const CAUSTIC_SHRINKING: f32 = 1.0 / 6.0;

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
            complement: Complement::KolligKeller,
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

    /// One sample per pixel under the lights of one pass, which are part of the set that is `kept` from pass to pass.
    /// `false` if cancelled.
    pub(super) fn render_pass<'s>(
        &self,
        scene: &'s Scene,
        limits: PathLimits,
        run: &PassContext,
        kept: &mut Option<LightSet<'s>>,
        film: &mut Film,
    ) -> bool {
        if run.cancelled() {
            return false;
        }
        let passes = self.passes_with(run.pass.index);
        if kept.as_ref().is_some_and(|set| set.passes != passes) {
            // Before the next set is made: two of them might not fit.
            *kept = None;
        }
        let set = kept.get_or_insert_with(|| self.prepare(scene, limits, passes, run));
        let positions = film.desc().sampler();
        run.shade(film, |samples| set.shade_tile(run, &positions, samples))
    }

    /// The passes that share the lights of pass `index`: one, then one, 2, 4, and 8 from there on, or fewer if the set would
    /// become too large.
    ///
    /// A set for many passes is better than a set for each: lights that stand for fewer photons each are more alike, so that
    /// every eighth of 4096 lights is a better choice than eight times 512.
    fn passes_with(&self, index: u32) -> Range<u32> {
        let most = MAX_PASSES_PER_SET
            .min(MAX_SET_LIGHTS / self.light_count.max(1))
            .min(MAX_SET_PHOTON_PATHS / self.photon_paths.max(1))
            .min(index);
        let count = most.checked_ilog2().map_or(1, |log| 1 << log);
        let start = index - index % count;
        start..start + count
    }

    /// Everything that `passes` shade with.
    pub fn prepare<'s>(
        &self,
        scene: &'s Scene,
        limits: PathLimits,
        passes: Range<u32>,
        run: &PassContext,
    ) -> LightSet<'s> {
        let count = passes.len() as u32;
        let all = ManyLight {
            light_count: self.light_count * count,
            photon_paths: self.photon_paths * count,
            importon_paths: self.importon_paths * count,
            ..*self
        };
        let pass = Pass {
            index: passes.start,
            ..run.pass
        };
        let run = PassContext { pass, ..*run };
        let photons = all.trace_photons(scene, limits, &run);
        let (lights, claims) = all.make_lights(scene, limits, &run, &photons);
        let (incident, caustics) = run.stats.time("maps", || {
            let caustics = photons.iter().filter(|p| p.event.has(Lobes::SPECULAR));
            (
                incident_from_afar(scene, &photons),
                KdTree::build_ordered(caustics.copied().collect()),
            )
        });
        // Where few photons arrive there are fewer lights than asked for, and they are divided among fewer passes.
        let parts = (0..=count.ilog2())
            .map(|log| 1 << log)
            .find(|parts| lights.field.lights().len() <= (self.light_count * parts) as usize)
            .unwrap_or(count);
        LightSet {
            scene,
            limits,
            gather: Gather {
                kernel: self.kernel,
                clamp: self.clamp,
            },
            complement: self.complement,
            lights,
            claims,
            caustics,
            incident,
            shrunk: (passes.end as f32).powf(-CAUSTIC_SHRINKING),
            pixel: pixel_width(scene),
            parts,
            first_part: (pass.sampler(Stream::Selection, 1).next_1d() * parts as f32) as u32,
            passes,
        }
    }

    fn trace_photons(&self, scene: &Scene, limits: PathLimits, run: &PassContext) -> Vec<Photon> {
        let stats = run.stats;
        let photons = stats.time("photons", || {
            trace_photons(scene, limits, self.photon_paths, run.pass)
        });
        Stats::count(&stats.photon_paths, u64::from(self.photon_paths));
        Stats::count(&stats.photons, photons.len() as u64);
        photons
    }

    /// Importance, placement, lights; and whose photons are.
    fn make_lights<'s>(
        &self,
        scene: &'s Scene,
        limits: PathLimits,
        run: &PassContext,
        photons: &[Photon],
    ) -> (Lights<'s>, Claims) {
        let (pass, stats) = (run.pass, run.stats);
        // A light at depth m makes paths of at least m + 2 segments.
        let photons: Vec<Photon> = photons
            .iter()
            .filter(|p| limits.allow(u32::from(p.depth) + 2))
            .copied()
            .collect();
        let mut sampler = pass.sampler(Stream::Selection, 0);
        let weights = match self.placement {
            Placement::Uniform => photons.iter().map(|p| p.flux.luminance()).collect(),
            Placement::Importance => self.importance_times_flux(scene, limits, run, &photons),
        };
        let (lights, claims) = stats.time("lights", || {
            let count = self.light_count as usize;
            let sites = select(&photons, &weights, count, sampler.next_1d());
            let (shares, claims) = match self.flux {
                FluxRule::Density => (Shares::own(&sites), Claims::none()),
                FluxRule::Partition => assign(scene, &photons, &sites, &weights, sampler.next_1d()),
            };
            let lights = match self.emission {
                EmissionKind::Single => LightField::single(scene, limits, &photons, &shares),
                EmissionKind::Table { side } => {
                    LightField::rich(scene, limits, &photons, &shares, side as usize)
                }
            };
            (lights, claims)
        });
        Stats::count(&stats.lights, lights.lights().len() as u64);
        Stats::count(&stats.light_bytes, lights.bytes() as u64);
        (Lights::new(lights), claims)
    }

    /// What the paper's placement goes by: how much of each photon reaches the camera, if importance did not depend on direction.
    fn importance_times_flux(
        &self,
        scene: &Scene,
        limits: PathLimits,
        run: &PassContext,
        photons: &[Photon],
    ) -> Vec<f32> {
        let stats = run.stats;
        let importons: Vec<Importon> = stats.time("importons", || {
            trace_importons(scene, limits, self.importon_paths, run.pass)
        });
        Stats::count(&stats.importons, importons.len() as u64);
        let map = stats.time("maps", || KdTree::build_ordered(importons));
        stats.time("importance", || {
            let ask = |found: &mut Neighbors, photon: &Photon| {
                importance_at(&map, photon.p, photon.n, found) * photon.flux.luminance()
            };
            photons
                .par_iter()
                .with_min_len(256)
                .map_init(|| Neighbors::new(IMPORTANCE_NEIGHBORS), ask)
                .collect()
        })
    }
}

/// Everything that some passes shade with.
#[derive(Debug)]
pub struct LightSet<'s> {
    pub(super) scene: &'s Scene,
    pub(super) limits: PathLimits,
    pub(super) gather: Gather,
    pub(super) complement: Complement,
    /// The virtual lights.
    pub lights: Lights<'s>,
    /// Which light a photon anywhere would belong to.
    pub claims: Claims,
    /// Photons whose last event was specular.
    pub caustics: KdTree<Photon>,
    /// Where light from afar comes from.
    pub(super) incident: IncidentMap,
    /// What is left of the radii of caustic estimates.
    shrunk: f32,
    /// Width of a pixel at the camera, in m, and its growth per m.
    pixel: (f32, f32),
    /// The passes that share the lights.
    passes: Range<u32>,
    /// Among how many of them in turn the lights are divided: a divisor of their number.
    parts: u32,
    /// Which part the first pass gets. Random, so that passes short of a whole set have the right mean.
    first_part: u32,
}

/// Photons straight from emitters beyond the scene, if these fill a solid angle. Emitters within it are found by their area.
fn incident_from_afar(scene: &Scene, photons: &[Photon]) -> IncidentMap {
    let bounds = scene.geometry.bounds();
    let from_afar = |photon: &&Photon| {
        photon.event == Lobes::NONE
            && scene.emitters.has_environment()
            && bounds.distance_squared(photon.prev) > 0.0
    };
    let incident = |photon: &Photon| Incident {
        p: photon.p,
        n: photon.n,
        wi: photon.wi,
    };
    let incidents: Vec<Incident> = photons.iter().filter(from_afar).map(incident).collect();
    IncidentMap::new(&incidents)
}

/// Width of a pixel in the middle of the film: at the camera, and its growth with the distance.
fn pixel_width(scene: &Scene) -> (f32, f32) {
    let middle = scene.sensor.desc().film.size.as_vec2() * 0.5;
    let ray = |film| scene.sensor.ray(film, Vec2::splat(0.5)).ray;
    let (a, b) = (ray(middle), ray(middle + Vec2::X));
    (a.o.distance(b.o), a.d.distance(b.d))
}

impl<'s> LightSet<'s> {
    /// The lights of one of the passes.
    fn selection(&self, pass: u32) -> Selection {
        let part = self.first_part + (pass - self.passes.start);
        Selection::ALL.part(part % self.parts, self.parts)
    }

    /// Shades the pixels of one tile: first all eye paths with their direct light, then the lights for all points together.
    fn shade_tile(&self, run: &PassContext, positions: &FilmSampler, out: &mut TileSamples) {
        let lights = self.selection(run.pass.index);
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
            let mut eye = EyePath::new(self, lights, walk, sampler, i, out, &mut points);
            eye.trace();
            shadow_rays += eye.shadow_rays();
        }
        let (mut connections, mut clamped, mut unclamped) = (0, 0.0, 0.0);
        let mut found = Neighbors::new(CAUSTIC_NEIGHBORS);
        let places: Vec<ShadingPoint> = points.iter().map(|point| point.at).collect();
        let sums = self.gather.sum(self.scene, &self.lights, &places);
        for (point, gathered) in points.iter().zip(sums) {
            let layer = |event| point.stage.after(Lobes::SMOOTH).after(event).layer();
            out.add(
                point.pixel,
                layer(Lobes::SMOOTH),
                point.throughput * gathered.radiance,
            );
            out.add(
                point.pixel,
                layer(Lobes::SPECULAR),
                point.throughput * self.caustic_radiance(point, &mut found),
            );
            connections += gathered.connections;
            shadow_rays += gathered.shadow_rays;
            if point.stage == Stage::BeforeX {
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

    /// Density estimate over caustic photons: `Σ_j k_j f Φ_j`.
    fn caustic_radiance(&self, point: &Gathering, found: &mut Neighbors) -> Rgb {
        let x = &point.at.x;
        let n = point
            .at
            .lit_from
            .unwrap_or(if x.ng.dot(point.at.wo) >= 0.0 {
                x.ng
            } else {
                -x.ng
            });
        let bandwidth = Bandwidth {
            largest: point
                .reach
                .min(CAUSTIC_RADIUS * self.scene.geometry.bounds().diagonal()),
            share: self.shrunk,
        };
        let mut sum = Rgb::BLACK;
        estimate(
            &self.caustics,
            x.p,
            n,
            bandwidth,
            found,
            |photon, kernel| {
                if self.limits.allow(point.segments + u32::from(photon.depth)) {
                    sum += photon.flux
                        * point.at.bsdf.f(photon.wi, point.at.wo, Lobes::SMOOTH)
                        * kernel;
                }
            },
        );
        sum
    }

    /// Largest radius of a caustic estimate at the end of an eye path of the given length, in m: some pixels.
    pub(super) fn caustic_reach(&self, length: f32) -> f32 {
        CAUSTIC_PIXELS * (self.pixel.0 + self.pixel.1 * length)
    }
}
