//! Scenes that are loaded once and rendered several times.

use crate::denoiser::open_denoiser;
use crate::failure::Failure;
use crate::kept_lights::request_with_lights;
use crate::light_groups::{check_groups, named};
use crate::request::RenderRequest;
use crate::session::{
    SceneFile, Session, frame_cameras, scene_failure, seen_by, set_frames, thread_pool,
};
use crate::usage::render_args;
use manylight::render::Stats;
use manylight::scene::{LightGroupNames, Scene, SceneDesc};
use manylight::sensors::{Sensor, SensorDesc};
use manylight_io::LoadOptions;
use manylight_io::part::LightsFile;
use rayon::ThreadPool;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// A loaded scene. It is built by the first render.
pub struct HeldScene {
    /// The words of the command line that load it: the file and its options.
    words: Vec<String>,
    digest: String,
    warnings: Vec<String>,
    cameras: Vec<SensorDesc>,
    /// Names of the sources of emission in the file.
    sources: LightGroupNames,
    content: Mutex<Content>,
}

enum Content {
    /// Not built yet.
    Described(Box<SceneDesc>),
    Built(Arc<Scene>),
    /// The scene cannot be built, for this reason.
    Invalid(String),
}

impl HeldScene {
    /// Loads a scene. `words` are its file, and those options of `manylight render` that belong to
    /// loading.
    ///
    /// # Errors
    /// An option is wrong, the scene is invalid, or a file of it cannot be read. With `--strict`, a
    /// warning.
    pub fn load(words: Vec<String>) -> Result<Self, Failure> {
        let (request, _) = request(&words, &[])?;
        let options = LoadOptions {
            strict: request.run.strict,
            ..request.load_options()
        };
        let file = SceneFile::load(&request, &options, &thread_pool(None)?, &Stats::default())?;
        Ok(HeldScene {
            words,
            digest: file.digest,
            warnings: file.warnings,
            cameras: file.desc.sensors.clone(),
            sources: LightGroupNames::of(&file.desc),
            content: Mutex::new(Content::Described(Box::new(file.desc))),
        })
    }

    /// SHA-256 of the files of the scene, as [`manylight_io::scene_digest`] takes it.
    pub fn digest(&self) -> &str {
        &self.digest
    }

    /// Warnings about the scene, without repetitions.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Names of the cameras; a name may be empty.
    pub fn cameras(&self) -> impl Iterator<Item = &str> {
        self.cameras.iter().map(|camera| camera.name.as_str())
    }

    /// Number of frames of each camera in the file: 0 for one that stands still.
    pub fn frame_counts(&self) -> impl Iterator<Item = usize> {
        self.cameras.iter().map(|camera| camera.motion.len())
    }

    /// A session that renders this scene. `words` are options of `manylight render`.
    ///
    /// # Errors
    /// An option is wrong or contradicts another, the scene has no such camera, or it is being
    /// rendered with another camera or film.
    pub fn session(&self, words: &[String]) -> Result<Session, Failure> {
        let (request, lights) = request(&self.words, words)?;
        let (pool, stats) = (thread_pool(request.run.threads())?, Stats::default());
        let oidn =
            open_denoiser(&request.denoise, request.run.threads())?.map(|oidn| oidn.version());
        let scene = self.scene(&request, &pool, &stats)?;
        Ok(Session {
            request,
            scene,
            digest: self.digest.clone(),
            scene_digest: self.digest.clone(),
            lights,
            warnings: self.warnings.clone(),
            oidn,
            pool,
            stats,
            choice: OnceLock::new(),
            guided: OnceLock::new(),
        })
    }

    /// The scene with the camera and the light groups of `request`.
    fn scene(
        &self,
        request: &RenderRequest,
        pool: &ThreadPool,
        stats: &Stats,
    ) -> Result<Arc<Scene>, Failure> {
        let mut camera = request.camera(&self.cameras)?;
        let motion = std::mem::take(&mut camera.motion);
        let frames = frame_cameras(request, &camera, motion)?;
        if !frames.is_empty() {
            request.frames_of(frames.len() as u32)?;
        }
        let has_groups = request.picture.has_light_groups();
        let groups = has_groups.then(|| named(&request.picture, &self.sources));
        let groups = groups.transpose()?;
        let mut content = self.content.lock().unwrap_or_else(PoisonError::into_inner);
        if let Content::Described(desc) = &mut *content {
            *content = match seen_by(&camera, *std::mem::take(desc), pool, stats) {
                Ok(scene) => Content::Built(Arc::new(scene)),
                Err(error) => Content::Invalid(error.message),
            };
        }
        let scene = match &mut *content {
            Content::Built(scene) => scene,
            Content::Described(_) => unreachable!("the scene was built"),
            Content::Invalid(message) => {
                return Err(scene_failure(&request.scene, message.clone()));
            }
        };
        let has_frames = (scene.frames().iter().map(Sensor::desc)).eq(&frames);
        if *scene.sensor.desc() != camera || !has_frames {
            let Some(scene) = Arc::get_mut(scene) else {
                return Err(Failure::usage(
                    "the scene is being rendered with another camera or film",
                    "end that render first, or load the scene a second time",
                ));
            };
            let changed = scene.set_sensor(camera);
            changed.map_err(|error| scene_failure(&request.scene, error.message))?;
            set_frames(scene, request, frames)?;
        }
        if let Some(groups) = groups {
            if !scene.has_light_groups(&groups) {
                let Some(scene) = Arc::get_mut(scene) else {
                    return Err(Failure::usage(
                        "the scene is being rendered with other light groups",
                        "end that render first, or load the scene a second time",
                    ));
                };
                scene.set_light_groups(&groups);
            }
            check_groups(&scene.light_groups)?;
        }
        Ok(Arc::clone(scene))
    }
}

/// The request of a command line with these words.
fn request(
    scene_words: &[String],
    words: &[String],
) -> Result<(RenderRequest, Option<LightsFile>), Failure> {
    let args = render_args(scene_words.iter().chain(words).map(String::as_str))?;
    let (request, lights) = request_with_lights(&args)?;
    if request.frames.is_walkthrough() && request.frames.only().is_none() {
        return Err(Failure::usage(
            "a picture in memory is one frame of a walkthrough",
            "give --frames one number, such as --frames=1",
        ));
    }
    let request = RenderRequest {
        outputs: Vec::new(),
        keeps_layers: true,
        ..request
    };
    Ok((request, lights))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<String> {
        text.split_whitespace().map(str::to_owned).collect()
    }

    fn room() -> HeldScene {
        let scene = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../scenes/furnace/emissive-box.xml"
        );
        HeldScene::load(vec![scene.into()]).unwrap()
    }

    #[test]
    fn a_scene_is_built_once_and_seen_by_any_film() {
        let room = room();
        let first = room.session(&words("--size 8x6")).unwrap();
        let other = room.session(&words("--size 9x6")).err().unwrap();
        assert!(other.to_string().contains("another camera or film"));
        let same = room.session(&words("--size 8x6 --method path")).unwrap();
        assert!(Arc::ptr_eq(&first.scene, &same.scene));
        drop((first, same));
        let wide = room.session(&words("--size 9x6")).unwrap();
        assert_eq!(wide.scene.sensor.desc().film.size.x, 9);
        let missing = room.session(&words("--sensor 7")).err().unwrap();
        assert_eq!(missing.exit_code(), 2);
    }

    #[test]
    fn a_wrong_option_does_not_spoil_the_scene() {
        let folder = tempfile::tempdir().unwrap();
        let scene = folder.path().join("dark.xml");
        let text =
            r#"<scene version="3.0.0"><sensor type="perspective"/><shape type="cube"/></scene>"#;
        std::fs::write(&scene, text).unwrap();
        let dark = HeldScene::load(vec![scene.display().to_string()]).unwrap();
        let failure = dark.session(&words("--light-groups")).err().unwrap();
        assert_eq!(failure.exit_code(), 2);
        assert!(dark.session(&words("--size 8x6")).is_ok());
    }

    #[test]
    fn wrong_words_are_usage_failures_with_a_suggestion() {
        let room = room();
        let failure = |text| room.session(&words(text)).err().unwrap();
        let Failure::Usage { message, help } = failure("--method rich-vlp") else {
            panic!("expected a usage failure");
        };
        assert!(message.contains("'rich-vlp'"), "{message}");
        assert!(help.contains("rich-vpl"), "{help}");
        assert_eq!(failure("--method path --lights 5").exit_code(), 2);
    }
}
