//! A scene with the settings of a render.

use crate::choice::budget_and_block;
use crate::denoiser::Denoised;
use crate::failure::Failure;
use crate::frame_files::FrameFiles;
use crate::interrupt::Interrupt;
use crate::light_groups::{check_groups, named};
use crate::picture::PictureFacts;
use crate::repeat::Settings;
use crate::report::RenderReport;
use crate::request::RenderRequest;
use manylight::emitters::EmissionGuide;
use manylight::film::{Film, Layer};
use manylight::integrators::{Choice, GuidedEmission, Method};
use manylight::math::{Affine3A, Vec3};
use manylight::render::{RenderJob, Stats};
use manylight::scene::{LightGroupNames, Scene, SceneDesc, SceneError};
use manylight::sensors::{SensorDesc, SensorKind};
use manylight_denoise::{FEATURE_PASSES, Oidn, Version, render_features};
use manylight_io::part::LightsFile;
use manylight_io::{
    LoadOptions, LoadedScene, is_same_file, load_scene, read_camera_path, scene_digest, shown_path,
};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use std::time::Instant;

/// A scene with the settings of a render, and everything that the render uses.
pub struct Session {
    pub(crate) request: RenderRequest,
    pub(crate) scene: Arc<Scene>,
    /// SHA-256 of the files of the scene, and of the cameras of a walkthrough.
    pub(crate) digest: String,
    /// SHA-256 of the files of the scene alone.
    pub(crate) scene_digest: String,
    /// The file of lights that the render shades by, if they were made before.
    pub(crate) lights: Option<LightsFile>,
    /// Warnings about the scene, without repetitions.
    pub(crate) warnings: Vec<String>,
    /// Version of Open Image Denoise, if the image is to be denoised.
    pub(crate) oidn: Option<Version>,
    pub(crate) pool: ThreadPool,
    pub(crate) stats: Stats,
    /// What was chosen, by a method that is chosen.
    pub(crate) choice: OnceLock<Choice>,
    /// The guide of photons, when it is made.
    pub(crate) guided: OnceLock<GuidedEmission>,
}

/// A pool of `threads` threads; `None` for one per processor.
pub(crate) fn thread_pool(threads: Option<usize>) -> Result<ThreadPool, Failure> {
    ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .build()
        .map_err(|error| Failure::Internal(format!("cannot start threads: {error}")))
}

/// A loaded scene file.
pub(crate) struct SceneFile {
    pub(crate) desc: SceneDesc,
    /// Warnings without repetitions.
    pub(crate) warnings: Vec<String>,
    /// SHA-256 of the files of the scene, and of the cameras of a walkthrough.
    pub(crate) digest: String,
    /// SHA-256 of the files of the scene alone.
    pub(crate) scene_digest: String,
    /// The files of the scene.
    files: Vec<PathBuf>,
}

impl SceneFile {
    /// Loads the scene of `request` on the threads of `pool`.
    ///
    /// # Errors
    /// The scene is invalid, or a file of it cannot be read.
    pub(crate) fn load(
        request: &RenderRequest,
        options: &LoadOptions,
        pool: &ThreadPool,
        stats: &Stats,
    ) -> Result<Self, Failure> {
        stats.time("load", || {
            pool.install(|| {
                let mut loaded = load_scene(&request.scene, options)?;
                let of_scene = scene_digest(&request.scene, &loaded.files)?;
                let digest = match &request.frames.cameras {
                    None => of_scene.clone(),
                    Some(cameras) => {
                        loaded.files.push(cameras.clone());
                        scene_digest(&request.scene, &loaded.files)?
                    }
                };
                Ok(SceneFile {
                    warnings: distinct_warnings(&loaded),
                    desc: loaded.desc,
                    digest,
                    scene_digest: of_scene,
                    files: loaded.files,
                })
            })
        })
    }

    /// Refuses to replace a file of the scene by what `request` writes.
    pub(crate) fn check_outputs(&self, request: &RenderRequest) -> Result<(), Failure> {
        let others = [&request.parts.checkpoint, &request.kept.lights_out];
        let others = others.into_iter().flatten();
        let outputs = request.outputs.iter();
        let frames: Vec<FrameFiles> = match request.frames.is_walkthrough() {
            true => outputs.clone().map(|path| FrameFiles::of(path)).collect(),
            false => Vec::new(),
        };
        let would_replace = |file: &&PathBuf| {
            let is_output = |output: &PathBuf| is_same_file(output, file);
            frames.iter().any(|frames| frames.frame_of(file).is_some())
                || outputs.clone().chain(others.clone()).any(is_output)
        };
        match self.files.iter().find(would_replace) {
            None => Ok(()),
            Some(file) => Err(Failure::usage(
                format!(
                    "{} is a file of the scene, which the render would replace",
                    shown_path(file)
                ),
                "write to a file of another name",
            )),
        }
    }
}

fn distinct_warnings(loaded: &LoadedScene) -> Vec<String> {
    let mut warnings: Vec<String> = Vec::new();
    for warning in loaded.warnings.iter().map(ToString::to_string) {
        if !warnings.contains(&warning) {
            warnings.push(warning);
        }
    }
    warnings
}

/// Builds a scene that the camera of `request` sees.
///
/// # Errors
/// The scene is invalid, or has no such camera or light groups.
pub(crate) fn build_scene(
    request: &RenderRequest,
    desc: SceneDesc,
    pool: &ThreadPool,
    stats: &Stats,
) -> Result<Scene, Failure> {
    let mut camera = request.camera(&desc.sensors)?;
    let motion = std::mem::take(&mut camera.motion);
    let names = request
        .picture
        .has_light_groups()
        .then(|| LightGroupNames::of(&desc));
    let scene = seen_by(&camera, desc, pool, stats);
    let mut scene = scene.map_err(|error| scene_failure(&request.scene, error.message))?;
    if let Some(names) = names {
        scene.set_light_groups(&named(&request.picture, &names)?);
        check_groups(&scene.light_groups)?;
    }
    let frames = frame_cameras(request, &camera, motion)?;
    set_frames(&mut scene, request, frames)?;
    Ok(scene)
}

/// Builds a scene that `camera` alone sees.
pub(crate) fn seen_by(
    camera: &SensorDesc,
    desc: SceneDesc,
    pool: &ThreadPool,
    stats: &Stats,
) -> Result<Scene, SceneError> {
    let desc = SceneDesc {
        sensors: vec![camera.clone()],
        ..desc
    };
    stats.time("build", || pool.install(|| Scene::build(desc, 0)))
}

/// The cameras of a walkthrough: those of the file that `request` names, or those of `motion`, the
/// places of `camera`; none of a single picture.
pub(crate) fn frame_cameras(
    request: &RenderRequest,
    camera: &SensorDesc,
    motion: Vec<Affine3A>,
) -> Result<Vec<SensorDesc>, Failure> {
    if !request.frames.is_walkthrough() {
        return Ok(Vec::new());
    }
    let motion = match &request.frames.cameras {
        Some(path) => {
            let places = read_camera_path(path)?.into_iter();
            places.map(|place| with_lens_of(camera, place)).collect()
        }
        None => motion,
    };
    if motion.is_empty() {
        return Err(Failure::usage(
            "--frames: the camera of the scene stands still",
            "name the cameras of the frames by --cameras; a camera moves by <animation> in Mitsuba files, ActiveTransform in PBRT files, and animations of glTF files",
        ));
    }
    let frames = motion.into_iter().map(|world_from_camera| SensorDesc {
        world_from_camera,
        ..camera.clone()
    });
    Ok(frames.collect())
}

/// The place of a camera with the lens of `camera`: an orthographic camera has its width in the
/// lengths of the axes.
fn with_lens_of(camera: &SensorDesc, place: Affine3A) -> Affine3A {
    let lengths = |place: &Affine3A| {
        let axes = &place.matrix3;
        Vec3::new(
            axes.x_axis.length(),
            axes.y_axis.length(),
            axes.z_axis.length(),
        )
    };
    match camera.kind {
        SensorKind::Orthographic => {
            let (found, expected) = (lengths(&place), lengths(&camera.world_from_camera));
            place * Affine3A::from_scale(expected / found)
        }
        SensorKind::Perspective { .. } | SensorKind::ThinLens { .. } => place,
    }
}

/// Sets the cameras of a walkthrough.
pub(crate) fn set_frames(
    scene: &mut Scene,
    request: &RenderRequest,
    cameras: Vec<SensorDesc>,
) -> Result<(), Failure> {
    let path = request.frames.cameras.as_ref().unwrap_or(&request.scene);
    let failure = |(index, error): (usize, SceneError)| {
        scene_failure(
            path,
            format!("camera of frame {}: {}", index + 1, error.message),
        )
    };
    scene.set_frames(cameras).map_err(failure)
}

/// The failure of a scene with invalid content.
pub(crate) fn scene_failure(scene: &Path, message: String) -> Failure {
    Failure::Scene {
        scene: scene.to_owned(),
        message,
    }
}

impl Session {
    /// The render.
    pub(crate) fn job(&self) -> RenderJob<'_> {
        let request = &self.request;
        let mut method = self.method();
        let choice = self.choice.get();
        if let Some(choice) = choice {
            method.kind = choice.kind.clone();
        }
        let (budget, block) = budget_and_block(request.budget, request.parts.block, choice);
        RenderJob {
            scene: &self.scene,
            method,
            budget,
            seed: request.paths.seed,
            frame: request.frames.only(),
            lights: None,
            block,
            guide: self.guide(),
        }
    }

    /// The method as it was asked for, with the layers of the scene's light groups.
    fn method(&self) -> Method {
        let mut method = self.request.method(self.scene.limits);
        method.extra.picture_only = !self.request.keeps_layers;
        if self.request.picture.has_light_groups() {
            method.extra.light_groups = self.scene.light_groups.count();
        }
        method
    }

    /// The guide of the photons, made when it is needed first; `None` if none are emitted.
    pub(crate) fn guide(&self) -> Option<&EmissionGuide> {
        let method = self.method();
        let make = || method.guided_emission(&self.scene);
        let guided = || self.pool.install(|| self.stats.time("photons", make));
        let emits_photons = method.emits_photons() && self.lights.is_none();
        emits_photons.then(|| &self.guided.get_or_init(guided).guide)
    }

    /// SHA-256 of the lights of a file, if the render shades by them.
    pub(crate) fn digest_of_lights(&self) -> Option<&str> {
        self.lights.as_ref().map(LightsFile::digest)
    }

    /// Settings of a render of `job`.
    pub(crate) fn settings<'s>(&'s self, job: &'s RenderJob) -> Settings<'s> {
        Settings {
            request: &self.request,
            method: &job.method,
            film: &self.scene.sensor.desc().film,
            choice: self.choice.get(),
            threads: self.pool.current_num_threads(),
            oidn: self.oidn,
        }
    }

    /// The report of a render of `job` after `passes` passes.
    pub(crate) fn report<'s>(&'s self, job: &'s RenderJob, passes: u32) -> RenderReport<'s> {
        RenderReport {
            settings: self.settings(job),
            stats: &self.stats,
            passes,
            error: None,
            warnings: self.all_warnings(),
            scene_digest: &self.digest,
        }
    }

    /// What a picture of `film`, which `report` is about, says beside its layers.
    pub(crate) fn facts(
        &self,
        film: &Film,
        job: &RenderJob,
        report: &RenderReport,
    ) -> PictureFacts {
        let camera = self.scene.camera(job.frame);
        PictureFacts::new(&self.scene, camera, film.id_layers(), report.metadata())
    }

    /// Warnings about the scene and the samples so far.
    pub(crate) fn all_warnings(&self) -> Vec<String> {
        let mut warnings = self.warnings.clone();
        warnings.extend(self.sample_warnings());
        warnings
    }

    /// Warnings about the samples so far: some were not finite, hardly any photon found the scene,
    /// or hardly any of an emitter found where its light matters.
    pub(crate) fn sample_warnings(&self) -> Vec<String> {
        let dropped = Stats::get(&self.stats.dropped_samples);
        let dropped = (dropped > 0)
            .then(|| format!("{dropped} samples were not finite and were replaced by black"));
        let lights = self.lost_photons().or_else(|| self.missed_light());
        dropped.into_iter().chain(lights).collect()
    }

    /// A warning if a method of virtual lights has hardly any photon. Of photon maps nothing is
    /// known: they keep photons of indirect light alone, and a plain floor has none.
    fn lost_photons(&self) -> Option<String> {
        /// Photons per photon path below which pictures lack light: even open scenes have a hundred
        /// times as many.
        const FEW: f64 = 1e-3;
        let [paths, photons] = [&self.stats.photon_paths, &self.stats.photons].map(Stats::get);
        let method = self.job().method;
        let are_few = method.lights().is_some()
            && method.limits.allow(3)
            && (photons as f64) < FEW * paths as f64;
        are_few.then(|| {
            format!(
                "only {photons} photons of {paths} photon paths reached a surface, so that the picture lacks indirect light: the lights are far larger than the scene, or shine past it; --method path is not affected"
            )
        })
    }

    /// A warning if photons hardly carry the light of an emitter to where it matters.
    fn missed_light(&self) -> Option<String> {
        let missed = self.guided.get()?.missed?;
        if !self.job().method.emits_photons() {
            return None;
        }
        let primitives = self.scene.geometry.primitives();
        let first = primitives
            .iter()
            .position(|p| p.emitter == Some(missed.emitter));
        let name = first.map_or("", |first| self.scene.names.of_primitive(first.into()));
        Some(format!(
            "photons carry only {:.1} % of the light that the emitter of {} sends to surfaces near the view, where it is {:.0} % of all direct light: indirect light and caustics of it are noisy or missing; --method path is not affected",
            100.0 * missed.carried,
            shown_path(Path::new(name)),
            100.0 * missed.share
        ))
    }

    /// Renders features that the film of `job` will lack, if the image is to be denoised. Their
    /// time is taken from the time limit of `job`.
    pub(crate) fn features(&self, job: &mut RenderJob, interrupt: &Interrupt) -> Option<Film> {
        self.oidn?;
        let has_features = job.method.layers().contains(&Layer::Albedo);
        let expected = job.budget.passes.filter(|_| has_features).unwrap_or(0);
        let passes = FEATURE_PASSES.saturating_sub(expected);
        if passes == 0 {
            return None;
        }
        let start = Instant::now();
        let film = self.stats.time("features", || {
            let cancel = interrupt.cancel();
            self.pool.install(|| render_features(job, passes, cancel))
        });
        job.budget.time = (job.budget.time).map(|limit| limit.saturating_sub(start.elapsed()));
        Some(film)
    }

    /// Denoises `film` by `oidn`, if there is one. A second signal ends it.
    pub(crate) fn denoise(
        &self,
        oidn: Option<&Oidn>,
        film: &Film,
        features: Option<&Film>,
        interrupt: &Interrupt,
    ) -> Denoised {
        let denoise = |oidn| {
            let work = || Denoised::of_film(oidn, film, features, interrupt);
            self.stats.time("denoise", work)
        };
        oidn.map(denoise).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use manylight::film::{FilmDesc, Filter};
    use manylight::math::{UVec2, Vec2};
    use manylight::sensors::FovAxis;

    #[test]
    fn frames_of_an_orthographic_camera_keep_its_width() {
        let turned = Affine3A::from_rotation_y(0.4);
        let mut camera = SensorDesc {
            world_from_camera: turned * Affine3A::from_scale(Vec3::new(3.0, 2.0, 1.0)),
            motion: Vec::new(),
            name: String::new(),
            kind: SensorKind::Orthographic,
            principal_point_offset: Vec2::ZERO,
            near_clip: 0.0,
            far_clip: f32::INFINITY,
            film: FilmDesc {
                size: UVec2::new(4, 3),
                crop_offset: UVec2::ZERO,
                crop_size: UVec2::new(4, 3),
                filter: Filter::Box,
            },
        };
        for scale in [1.0, 7.0] {
            let place = turned * Affine3A::from_scale(Vec3::splat(scale));
            let found = with_lens_of(&camera, place);
            assert!(found.abs_diff_eq(camera.world_from_camera, 1e-5), "{found}");
        }
        camera.kind = SensorKind::Perspective {
            fov: 40.0,
            fov_axis: FovAxis::X,
        };
        assert_eq!(with_lens_of(&camera, turned), turned);
    }
}
