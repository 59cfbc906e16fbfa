//! The camera paths of the photon-map methods, and the density estimates at their vertices.

use super::{Estimate, PhotonMap};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::emitters::{EnvironmentLobes, MAX_ENVIRONMENT_LOBES};
use crate::film::{FilmSampler, Layer, TileSamples};
use crate::integrators::context::PassContext;
use crate::integrators::first_event::{FirstEvent, SampleShare, add_first_event};
use crate::integrators::first_surface::add_first_surface;
use crate::integrators::guiding::{environment_guide, guided_pdf, sample_direction};
use crate::integrators::partition::PathStage;
use crate::maps::density::{Bandwidth, DensityReceiver, density_estimate};
use crate::maps::{COVERAGE_PROBES, IncidentMap, KdTree, Neighbors, covered_fraction};
use crate::math::Vec3;
use crate::particles::Photon;
use crate::sampling::{Pass, Sampler, Stream, rng};
use crate::scene::{PathLimits, Scene};
use crate::stats::Stats;
use crate::transport::direct::EmitterSample;
use crate::transport::{CameraStep, Vertex, Walk, next_scattering_vertex, roulette};

/// Directions, and emitter samples, for the lobes that end a camera path. Unmeasured.
const DIRECTIONS: u32 = 2;
/// Factor from the weight of a camera path to its probability of survival before `rr_depth`. Unmeasured: only the weakest paths are terminated.
const SURVIVAL_FACTOR: f32 = 8.0;

/// What a pass shades with.
pub(super) struct PhotonMapPass<'s> {
    pub(super) scene: &'s Scene,
    pub(super) limits: PathLimits,
    pub(super) method: PhotonMap,
    pub(super) photons: KdTree<Photon>,
    /// Photons that arrive straight from the environment.
    pub(super) incident: IncidentMap,
    /// See [`Bandwidth`].
    pub(super) radius_scale: f32,
    /// Camera paths per pixel.
    pub(super) camera_paths: u32,
}

impl PhotonMapPass<'_> {
    pub(super) fn shade_tile(
        &self,
        run: &PassContext,
        positions: &FilmSampler,
        out: &mut TileSamples,
    ) {
        let mut paths = TilePaths {
            pass: self,
            out,
            found: Neighbors::new(self.method.neighbors.max(1) as usize),
            found_incident: Neighbors::new(MAX_ENVIRONMENT_LOBES),
            shadow_rays: 0,
        };
        let mut count = 0;
        for sample in 0..self.camera_paths {
            // Samples are numbered through all passes.
            let pass = Pass {
                index: run.pass.index.wrapping_mul(self.camera_paths) + sample,
                ..run.pass
            };
            for (index, pixel) in paths.out.tile().pixels().enumerate() {
                let number = positions.index(pixel);
                let mut sampler = pass.sampler(Stream::Pixel, number);
                let film = positions.sample(pixel, pass.low_discrepancy_2d(Stream::Pixel, number));
                let camera = self.scene.sensor.ray(film.position, sampler.next_2d());
                let weight = Rgb::splat(camera.weight * film.weight);
                paths.trace(PhotonMapPath {
                    index,
                    walk: Walk::from_sensor(self.scene, self.limits, camera.ray, weight),
                    stage: PathStage::BeforeX,
                    sampler,
                    describes: sample == 0,
                    filter_weight: film.weight,
                });
                count += 1;
            }
        }
        Stats::count(&run.stats.camera_paths, count);
        Stats::count(&run.stats.shadow_rays, paths.shadow_rays);
    }
}

/// The camera paths of a tile.
struct TilePaths<'v, 's, 'o, 't> {
    pass: &'v PhotonMapPass<'s>,
    out: &'o mut TileSamples<'t>,
    found: Neighbors,
    found_incident: Neighbors,
    shadow_rays: u64,
}

/// A camera path.
#[derive(Clone)]
struct PhotonMapPath<'s> {
    /// Index of its pixel in the tile.
    index: usize,
    walk: Walk<'s>,
    stage: PathStage,
    sampler: Sampler,
    /// Whether its first surface fills the layers that describe it.
    describes: bool,
    /// Weight by the reconstruction filter.
    filter_weight: f32,
}

impl<'s> TilePaths<'_, 's, '_, '_> {
    /// Follows a path to its end.
    fn trace(&mut self, mut path: PhotonMapPath<'s>) {
        let limits = self.pass.limits;
        while let Some(v) = self.next_vertex(&mut path) {
            let gathering = self.pass.method.gathering_lobes(&v.bsdf, path.stage);
            let followed = Lobes(v.bsdf.lobes().0 & !gathering.0);
            if v.bsdf.lobes().has(Lobes::NON_SPECULAR) {
                self.gather(&path, &v, gathering);
            }
            // Lobes for which photons do not estimate the light of emitters.
            let direct = match self.pass.method.estimate {
                Estimate::Progressive => gathering,
                Estimate::Direct => Lobes::NONE,
            };
            self.add_emitters(&mut path, &v, direct, followed);
            let numbers = path.sampler.next_bsdf();
            if !path.walk.scatter(&v, numbers, followed) {
                return;
            }
            path.stage = path.stage.after(path.walk.previous().event);
            let (throughput, eta_squared) = (path.walk.throughput(), path.walk.eta_squared());
            let survival = if v.segments < limits.rr_depth {
                (SURVIVAL_FACTOR * throughput.max_channel() * eta_squared).min(1.0)
            } else {
                roulette::camera_survival(throughput, eta_squared)
            };
            if !path.walk.survive(survival, path.sampler.next_1d()) {
                return;
            }
        }
    }

    /// Follows a path to the next vertex that scatters; adds the radiance emitted on the way, and what the path meets first.
    fn next_vertex(&mut self, path: &mut PhotonMapPath<'s>) -> Option<Vertex<'s>> {
        let pass = self.pass;
        let PhotonMapPath {
            index,
            walk,
            stage,
            sampler,
            describes,
            filter_weight,
        } = path;
        // After a non-specular event, photons estimate what emitters send by specular events.
        let by_photons = *stage != PathStage::BeforeX && walk.previous().event.has(Lobes::SPECULAR);
        let (out, layer) = (&mut *self.out, stage.layer());
        let (scene, limits) = (pass.scene, pass.limits);
        let is_first = FirstEvent::is_ahead_of(walk);
        let mut ends_by = FirstEvent::Nothing;
        let visit = |step: &CameraStep, throughput: Rgb, sampler: &mut Sampler| {
            if is_first {
                ends_by = FirstEvent::of_last_step(scene, limits, step);
            }
            if !by_photons && !step.emitted.is_black() {
                let value = throughput * step.emitted / pass.camera_paths as f32;
                out.add(*index, layer, value);
            }
            if let Some(v) = step
                .vertex
                .as_ref()
                .filter(|v| v.segments == 1 && *describes)
            {
                add_first_surface(v, 1.0, sampler, *index, out);
            }
            true
        };
        let found = next_scattering_vertex(limits, walk, None, sampler, visit);
        if is_first {
            let event = found.as_ref().map_or(ends_by, FirstEvent::scattering);
            let share = SampleShare {
                filter_weight: *filter_weight,
                share: 1.0 / pass.camera_paths as f32,
            };
            add_first_event(scene, event, share, *index, self.out);
        }
        found
    }

    /// Adds radiance that arrives along the path.
    #[inline]
    fn add(&mut self, path: &PhotonMapPath, layer: Layer, radiance: Rgb) {
        if !radiance.is_black() {
            let value = path.walk.throughput() * radiance / self.pass.camera_paths as f32;
            self.out.add(path.index, layer, value);
        }
    }

    /// Adds light of emitters: on `ending` lobes by several samples and directions, on `followed` lobes by one sample. The
    /// rest of the path is the other half of MIS for these.
    fn add_emitters(
        &mut self,
        path: &mut PhotonMapPath<'s>,
        v: &Vertex<'s>,
        ending: Lobes,
        followed: Lobes,
    ) {
        if ending == Lobes::NONE {
            return self.next_event(path, v, None, [ending, followed]);
        }
        let guide = environment_guide(&self.pass.incident, v, &mut self.found_incident);
        let mut ended = path.clone();
        ended.walk.scale(1.0 / DIRECTIONS as f32);
        for i in 0..DIRECTIONS {
            self.next_event(&mut ended, v, guide.as_ref(), [ending, followed]);
            let numbers = ended.sampler.next_bsdf();
            let u = (i as f32 + ended.sampler.next_1d()) / DIRECTIONS as f32;
            let sample = sample_direction(v, guide.as_ref(), ending, numbers, u);
            let mut last = ended.clone();
            if last.walk.follow(v, sample) {
                last.stage = last.stage.after(ending);
                self.next_vertex(&mut last);
            }
        }
        path.sampler = ended.sampler;
    }

    /// Next-event estimation for two sets of lobes, from each of which directions are sampled as well: from the first with
    /// the guide.
    fn next_event(
        &mut self,
        path: &mut PhotonMapPath,
        v: &Vertex,
        guide: Option<&EnvironmentLobes>,
        sets: [Lobes; 2],
    ) {
        let scene = self.pass.scene;
        let lobes = v.bsdf.lobes().and(sets[0].or(sets[1]));
        if !lobes.has(Lobes::FINITE) {
            return;
        }
        let numbers = path.sampler.next_emitter();
        let n = v.bsdf.receiving_normal(v.w_prev);
        let Some(light) = EmitterSample::new(scene, &v.x, n, numbers) else {
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
                let by_photons = path.stage != PathStage::BeforeX && class == Lobes::NEAR_DELTA;
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
        let crossings = self.pass.limits.left_after(v.segments + 1);
        let arriving = light.weight * light.transmittance(scene, crossings);
        for (layer, term) in terms {
            self.add(path, layer, term * arriving);
        }
    }

    /// Density estimate at `v`, for `gathering` lobes and for photons that come from emitters by specular events.
    fn gather(&mut self, path: &PhotonMapPath, v: &Vertex, gathering: Lobes) {
        let n = v.x.normal_towards(v.w_prev);
        self.gather_from(path, v, gathering, n);
        if v.bsdf.transmits() {
            self.gather_from(path, v, gathering, -n);
        }
    }

    /// The estimate of [`TilePaths::gather`] over photons on the side of the unit normal `n`: `Σ_j k_j f Φ_j`, divided by the
    /// covered fraction of the kernel, in the layers of the photons' last events.
    fn gather_from(&mut self, path: &PhotonMapPath, v: &Vertex, gathering: Lobes, n: Vec3) {
        let pass = self.pass;
        let receiver = DensityReceiver { p: v.x.p, n };
        let bandwidth = Bandwidth {
            largest: f32::INFINITY,
            share: pass.radius_scale,
        };
        let here = path.stage.after(Lobes::NON_SPECULAR);
        // Of photons straight from emitters, from non-specular events, and from specular ones.
        let mut terms = [
            (here.layer(), Rgb::BLACK),
            (here.after(Lobes::NON_SPECULAR).layer(), Rgb::BLACK),
            (here.after(Lobes::SPECULAR).layer(), Rgb::BLACK),
        ];
        let visit = |photon: &Photon, kernel| {
            if !pass.limits.allow(v.segments + u32::from(photon.depth)) {
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
        let radius = density_estimate(&pass.photons, receiver, bandwidth, &mut self.found, visit);
        if terms.iter().all(|(_, sum)| sum.is_black()) {
            return;
        }
        // The turn of the probe pattern is a hash of `wo`, which differs from pass to pass and does not depend on the unit of length.
        let turn = rng::unit(rng::key(v.w_prev.to_array()));
        let covered = covered_fraction(
            &pass.scene.geometry,
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
