//! Photon maps: light on wide lobes is estimated by the density of the photons that arrive there.
//!
//! Two methods share the walk from the camera. *Progressive* photon mapping follows narrow lobes, connects to emitters at every
//! vertex, and leaves to the photons what comes to wide lobes by way of other surfaces; every pass has its own photons and a
//! smaller kernel than the one before, so that the mean over passes goes to the right picture. The photon map *shown directly*
//! leaves to the photons everything that smooth lobes reflect, emitters included, by a kernel that stays as it is.
//!
//! At a vertex the walk divides its lobes in two. Those that *gather* end it: photons count for them, and a ray may still run into an
//! emitter. The others are followed. Photons that come from an emitter by specular events alone count for every smooth lobe, and
//! followed lobes do not look for their light: emitters behind glass may be too small for it. What counts where depends on the
//! surface and on events alone, so that every path has one place where it is counted.
//!
//! Source: Jensen, "Global Illumination using Photon Maps", EGWR 1996; Hachisuka, Ogaki, Jensen, "Progressive Photon Mapping", ACM
//! TOG 2008; Hachisuka, Jensen, "Stochastic Progressive Photon Mapping", ACM TOG 2009; radii as in [`progressive_radius_scale`].

use super::guided::{draw_direction, guide_at, guided_pdf};
use super::partition::Stage;
use super::{PassContext, first_surface};
use crate::bsdf::{Bsdf, Lobes};
use crate::color::Rgb;
use crate::film::{Film, FilmSampler, Layer, TileSamples};
use crate::maps::density::{
    Bandwidth, DensityReceiver, density_estimate, progressive_radius_scale,
};
use crate::maps::{
    COVERAGE_PROBES, INCIDENT_NEIGHBORS, IncidentGuide, IncidentMap, KdTree, Neighbors,
    covered_fraction,
};
use crate::math::{UVec2, Vec3};
use crate::particles::{Photon, trace_photons};
use crate::sampling::{Pass, Sampler, Stream, rng};
use crate::scene::{PathLimits, Scene};
use crate::stats::Stats;
use crate::transport::direct::{
    EmitterPlan, EmitterSample, emitted_with_mis, environment_with_mis,
};
use crate::transport::{Step, Vertex, Walk, roulette};

/// What the photons are used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimate {
    /// What reaches wide lobes by way of other surfaces, with a kernel that shrinks from pass to pass.
    Progressive,
    /// Everything that smooth lobes reflect, with the whole kernel in every pass.
    Direct,
}

/// Light from density estimates over photons. Each pass has its own photons and its own jitter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PhotonMap {
    /// Emitted photon paths per pass.
    pub photon_paths: u32,
    /// Photons in an estimate, before its kernel shrinks.
    pub neighbors: u32,
    /// What they are used for.
    pub estimate: Estimate,
}

/// Glossy lobes gather from this roughness on: narrower ones show single photons. Behind a smooth event, which blurs what is seen
/// by it, all do.
const WIDE: f32 = 0.3;
/// Directions drawn at the end of an eye path, and samples of its emitters.
const DIRECTIONS: u32 = 2;
/// Eye paths per pixel and pass, at most; see [`PhotonMap::eye_paths`].
const MAX_EYE_PATHS: u32 = 16;
/// Eye paths go on with probability `throughput x this`, at most 1: the weakest are followed rarely.
const SURVIVAL: f32 = 8.0;

impl PhotonMap {
    /// Progressive photon mapping.
    pub fn progressive() -> Self {
        PhotonMap {
            photon_paths: 262_144,
            neighbors: 64,
            estimate: Estimate::Progressive,
        }
    }

    /// The photon map shown directly.
    pub fn direct() -> Self {
        PhotonMap {
            neighbors: 128,
            estimate: Estimate::Direct,
            ..PhotonMap::progressive()
        }
    }

    /// One pass with photons of its own. `false` if cancelled.
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
        let stats = run.stats;
        let photons = stats.time("photons", || {
            self.trace_photons(scene, limits, self.photon_paths, run.pass)
        });
        Stats::count(&stats.photon_paths, u64::from(self.photon_paths));
        Stats::count(&stats.photons, photons.len() as u64);
        let (incident, photons) = stats.time("maps", || {
            let incident = match self.estimate {
                Estimate::Progressive => IncidentMap::of_environment(scene, &photons),
                Estimate::Direct => IncidentMap::new(&[]),
            };
            let counts = |photon: &Photon| self.counts(photon.event);
            let photons = photons.into_iter().filter(counts).collect();
            (incident, KdTree::build_ordered(photons))
        });
        let view = View {
            scene,
            limits,
            method: *self,
            photons,
            incident,
            share: match self.estimate {
                Estimate::Progressive => progressive_radius_scale(run.pass.index + 1),
                Estimate::Direct => 1.0,
            },
            eye_paths: self.eye_paths(film.picture_size()),
        };
        let positions = film.desc().sampler();
        run.shade(film, UVec2::ZERO, |samples| {
            view.shade_tile(run, &positions, samples)
        })
    }

    /// The photons of `paths` paths that some eye path may use.
    pub(super) fn trace_photons(
        &self,
        scene: &Scene,
        limits: PathLimits,
        paths: u32,
        pass: Pass,
    ) -> Vec<Photon> {
        trace_photons(scene, limits, paths, pass, |bsdf, event| {
            // All smooth lobes gather behind a smooth event. Light from afar shows where to look for it.
            let is_useful = self.counts(event) || scene.emitters.has_environment();
            (bsdf.lobes().has(Lobes::NON_SPECULAR) && is_useful).then_some(1)
        })
    }

    /// Eye paths per pixel in a pass: as many as photon paths in all, so that neither waits for the other, and at least one.
    fn eye_paths(&self, size: UVec2) -> u32 {
        let pixels = u64::from(size.x) * u64::from(size.y);
        let rounded = (u64::from(self.photon_paths) + pixels / 2) / pixels.max(1);
        rounded.clamp(1, u64::from(MAX_EYE_PATHS)) as u32
    }

    /// Whether photons from events of this class are part of estimates.
    fn counts(&self, event: Lobes) -> bool {
        self.estimate == Estimate::Direct || event != Lobes::NONE
    }

    /// The lobes for which photons count where an eye path has come to the given stage; the others are followed.
    fn gathering(&self, bsdf: &Bsdf, stage: Stage) -> Lobes {
        let is_wide = stage != Stage::BeforeX || bsdf.glossy_width() >= WIDE;
        let lobes = if self.estimate == Estimate::Direct || is_wide {
            Lobes::NON_SPECULAR
        } else {
            Lobes::DIFFUSE
        };
        bsdf.lobes().and(lobes)
    }
}

/// What a pass shades with.
struct View<'s> {
    scene: &'s Scene,
    limits: PathLimits,
    method: PhotonMap,
    photons: KdTree<Photon>,
    /// Where light from afar comes from.
    incident: IncidentMap,
    /// See [`Bandwidth`].
    share: f32,
    /// Per pixel.
    eye_paths: u32,
}

impl View<'_> {
    fn shade_tile(&self, run: &PassContext, positions: &FilmSampler, out: &mut TileSamples) {
        let mut paths = EyePaths {
            view: self,
            out,
            found: Neighbors::new(self.method.neighbors.max(1) as usize),
            found_incident: Neighbors::new(INCIDENT_NEIGHBORS),
            shadow_rays: 0,
        };
        let mut count = 0;
        for sample in 0..self.eye_paths {
            // Samples are numbered through all passes.
            let pass = Pass {
                index: run.pass.index.wrapping_mul(self.eye_paths) + sample,
                ..run.pass
            };
            for (index, pixel) in paths.out.tile().pixels().enumerate() {
                let number = positions.index(pixel);
                let mut sampler = pass.sampler(Stream::Pixel, number);
                let film = positions.sample(pixel, pass.spread_2d(Stream::Pixel, number));
                let camera = self.scene.sensor.ray(film.position, sampler.next_2d());
                let weight = Rgb::splat(camera.weight * film.weight);
                let eye_path = EyePath {
                    index,
                    walk: Walk::from_sensor(self.scene, self.limits, camera.ray, weight),
                    stage: Stage::BeforeX,
                    sampler,
                    describes: sample == 0,
                };
                paths.trace(eye_path);
                count += 1;
            }
        }
        Stats::count(&run.stats.camera_paths, count);
        Stats::count(&run.stats.shadow_rays, paths.shadow_rays);
    }
}

/// The eye paths of a tile.
struct EyePaths<'v, 's, 'o, 't> {
    view: &'v View<'s>,
    out: &'o mut TileSamples<'t>,
    found: Neighbors,
    found_incident: Neighbors,
    shadow_rays: u64,
}

/// An eye path under way.
#[derive(Clone)]
struct EyePath<'s> {
    /// Of its pixel in the tile.
    index: usize,
    walk: Walk<'s>,
    stage: Stage,
    sampler: Sampler,
    /// Whether its first surface is described.
    describes: bool,
}

impl<'s> EyePaths<'_, 's, '_, '_> {
    /// Follows a path to its end.
    fn trace(&mut self, mut path: EyePath<'s>) {
        let limits = self.view.limits;
        while let Some(v) = self.next_surface(&mut path) {
            let gathering = self.view.method.gathering(&v.bsdf, path.stage);
            let followed = Lobes(v.bsdf.lobes().0 & !gathering.0);
            if v.bsdf.lobes().has(Lobes::NON_SPECULAR) {
                self.gather(&path, &v, gathering);
            }
            // Emitters that the photons do not bring.
            let direct = match self.view.method.estimate {
                Estimate::Progressive => gathering,
                Estimate::Direct => Lobes::NONE,
            };
            self.emitters(&mut path, &v, direct, followed);
            let numbers = path.sampler.next_bsdf();
            if !path.walk.scatter(&v, numbers, followed) {
                return;
            }
            path.stage = path.stage.after(path.walk.previous().event);
            let (throughput, eta_squared) = (path.walk.throughput(), path.walk.eta_squared());
            let survival = if v.segments < limits.rr_depth {
                (SURVIVAL * throughput.max_channel() * eta_squared).min(1.0)
            } else {
                roulette::camera_survival(throughput, eta_squared)
            };
            if !path.walk.survive(survival, path.sampler.next_1d()) {
                return;
            }
        }
    }

    /// Follows a path to the next surface where it must scatter, and adds the emitters that it meets on the way. `None`: it ends.
    fn next_surface(&mut self, path: &mut EyePath<'s>) -> Option<Vertex<'s>> {
        let (scene, limits) = (self.view.scene, self.view.limits);
        loop {
            let step = path.walk.advance();
            let previous = path.walk.previous();
            // Behind a smooth event, photons bring what emitters send by way of specular ones.
            let by_photons = path.stage != Stage::BeforeX && previous.event.has(Lobes::SPECULAR);
            let (found, hit) = match step {
                Step::Hidden => return None,
                Step::Escaped(wi) => (environment_with_mis(scene, previous, wi), None),
                Step::Hit(v) => (emitted_with_mis(scene, previous, &v.x, v.w_prev), Some(v)),
            };
            if !by_photons {
                self.add(path, path.stage.layer(), found);
            }
            let v = hit?;
            if v.segments == 1 && path.describes {
                first_surface(&v, 1.0, &mut path.sampler, path.index, self.out);
            }
            if !limits.allow(v.segments + 1) {
                return None;
            }
            if !path.walk.pass_through(&v, path.sampler.next_1d()) {
                return Some(v);
            }
        }
    }

    /// Adds light that the path carries to the camera.
    #[inline]
    fn add(&mut self, path: &EyePath, layer: Layer, radiance: Rgb) {
        if !radiance.is_black() {
            let value = path.walk.throughput() * radiance / self.view.eye_paths as f32;
            self.out.add(path.index, layer, value);
        }
    }

    /// Light from emitters: on lobes that end the path here, in some directions, and on those that are followed, as far as these
    /// do not find it themselves.
    fn emitters(&mut self, path: &mut EyePath<'s>, v: &Vertex<'s>, ending: Lobes, followed: Lobes) {
        if ending == Lobes::NONE {
            return self.next_event(path, v, None, [ending, followed]);
        }
        let guide = guide_at(&self.view.incident, v, &mut self.found_incident);
        let mut ended = path.clone();
        ended.walk.scale(1.0 / DIRECTIONS as f32);
        for i in 0..DIRECTIONS {
            self.next_event(&mut ended, v, guide.as_ref(), [ending, followed]);
            let numbers = ended.sampler.next_bsdf();
            let u = (i as f32 + ended.sampler.next_1d()) / DIRECTIONS as f32;
            let sample = draw_direction(v, guide.as_ref(), ending, numbers, u);
            let mut last = ended.clone();
            if last.walk.follow(v, sample) {
                last.stage = last.stage.after(ending);
                self.next_surface(&mut last);
            }
        }
        path.sampler = ended.sampler;
    }

    /// Next-event estimation for each of two sets of lobes, from each of which directions are drawn as well: from the first with
    /// the guide.
    fn next_event(
        &mut self,
        path: &mut EyePath,
        v: &Vertex,
        guide: Option<&IncidentGuide>,
        sets: [Lobes; 2],
    ) {
        let scene = self.view.scene;
        let lobes = v.bsdf.lobes().and(sets[0].or(sets[1]));
        if !lobes.has(Lobes::FINITE) {
            return;
        }
        let plan = EmitterPlan::draw(scene, &mut path.sampler);
        let n = v.bsdf.receiving_normal(v.w_prev);
        let Some(light) = EmitterSample::planned(scene, &v.x, n, &plan) else {
            return;
        };
        let mut terms = [(Layer::Direct, Rgb::BLACK); 4];
        for ((set, guide), terms) in sets
            .into_iter()
            .zip([guide, None])
            .zip(terms.chunks_exact_mut(2))
        {
            let classes = [Lobes::NON_SPECULAR, Lobes::NEAR_DELTA];
            for (class, term) in classes.into_iter().zip(terms) {
                let by_photons = path.stage != Stage::BeforeX && class == Lobes::NEAR_DELTA;
                let f_cos = v.bsdf.f_cos_wi(light.wi, v.w_prev, set.and(class));
                if !f_cos.is_black() && !by_photons {
                    let pdf = guided_pdf(v, guide, set, light.wi);
                    *term = (
                        path.stage.after(class).layer(),
                        f_cos * light.mis_weight(pdf),
                    );
                }
            }
        }
        if terms.iter().all(|(_, term)| term.is_black()) {
            return;
        }
        self.shadow_rays += 1;
        let crossings = self.view.limits.left_after(v.segments + 1);
        let arriving = light.weight * light.transmittance(scene, crossings);
        for (layer, term) in terms {
            self.add(path, layer, term * arriving);
        }
    }

    /// Density estimate at `v`, for `gathering` lobes and for what comes from emitters by specular events.
    fn gather(&mut self, path: &EyePath, v: &Vertex, gathering: Lobes) {
        let n = v.x.normal_towards(v.w_prev);
        self.gather_from(path, v, gathering, n);
        if v.bsdf.transmits() {
            self.gather_from(path, v, gathering, -n);
        }
    }

    /// [`EyePaths::gather`] of the photons on the side of the unit normal `n`: `Σ_j k_j f Φ_j`, over the covered part of the
    /// kernel, in the layers of the photons' last events.
    fn gather_from(&mut self, path: &EyePath, v: &Vertex, gathering: Lobes, n: Vec3) {
        let view = self.view;
        let receiver = DensityReceiver { p: v.x.p, n };
        let bandwidth = Bandwidth {
            largest: f32::INFINITY,
            share: view.share,
        };
        let here = path.stage.after(Lobes::NON_SPECULAR);
        // Of photons straight from emitters, from smooth events and from specular ones.
        let mut terms = [
            (here.layer(), Rgb::BLACK),
            (here.after(Lobes::NON_SPECULAR).layer(), Rgb::BLACK),
            (here.after(Lobes::SPECULAR).layer(), Rgb::BLACK),
        ];
        let visit = |photon: &Photon, kernel| {
            if !view.limits.allow(v.segments + u32::from(photon.depth)) {
                return;
            }
            let is_specular = photon.event.has(Lobes::SPECULAR);
            let lobes = if is_specular && photon.origin == Lobes::NONE {
                Lobes::NON_SPECULAR
            } else {
                gathering
            };
            let term = if is_specular {
                2
            } else {
                usize::from(photon.event != Lobes::NONE)
            };
            terms[term].1 += photon.flux * v.bsdf.f(photon.wi, v.w_prev, lobes) * kernel;
        };
        let radius = density_estimate(&view.photons, receiver, bandwidth, &mut self.found, visit);
        if terms.iter().all(|(_, sum)| sum.is_black()) {
            return;
        }
        // The view names the turn of the probes: it differs in every pass, and not with the scene's unit of length.
        let turn = rng::unit(rng::key(v.w_prev.to_array()));
        let covered = covered_fraction(
            &view.scene.geometry,
            receiver,
            radius,
            COVERAGE_PROBES,
            turn,
        );
        for (layer, sum) in terms {
            self.add(path, layer, sum / covered);
        }
    }
}
