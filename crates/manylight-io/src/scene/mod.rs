//! Scene files. [`load_scene`] returns a [`SceneDesc`], [`check_scene`] all problems of a file.

mod assets;
mod attributes;
mod camera_path;
mod curve_files;
mod description;
mod digest;
mod files;
mod gltf;
mod growth;
mod mitsuba;
mod motion;
mod names;
mod options;
mod parameters;
mod pbrt;
mod pixels;
mod plugins;
mod sink;
mod tubes;

pub use camera_path::read_camera_path;
pub use digest::scene_digest;
pub use options::{DEFAULT_FPS, EnvironmentSource, GltfOptions, LightUnits, LoadOptions};
pub use plugins::SupportedFamily;

use crate::error::{Diagnostic, LoadError, LoadErrorKind, Severity, Warning};
use crate::read::read_regular;
use crate::resolve::similar_file;
use crate::shown::shown_path;
use manylight::scene::SceneDesc;
use sink::Sink;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The description of a scene, and the warnings of loading it.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// The description of the scene.
    pub desc: SceneDesc,
    /// In the order of the file; repeated subjects are reported once.
    pub warnings: Vec<Warning>,
    /// Paths of the files that were read, sorted: the scene, included files, meshes, images and
    /// spectra.
    pub files: Vec<PathBuf>,
}

/// The supported plugins of scene files, by format and family.
pub fn supported() -> impl Iterator<Item = SupportedFamily> {
    let families = mitsuba::SUPPORTED.iter().chain(&pbrt::SUPPORTED);
    families.copied()
}

/// Loads the scene in the file `path`, with all included files, meshes and images.
///
/// # Errors
/// The first error in the order of the file. With [`LoadOptions::strict`], the first warning if
/// there is no error.
pub fn load_scene(path: &Path, options: &LoadOptions) -> Result<LoadedScene, LoadError> {
    let sink = Sink::default();
    let desc = load(path, options, &sink);
    let files = sink.files_read();
    let mut warnings = Vec::new();
    for diagnostic in sink.into_diagnostics() {
        match diagnostic.severity {
            Severity::Error => return Err(diagnostic.into()),
            Severity::Warning => warnings.push(diagnostic),
        }
    }
    if options.strict && !warnings.is_empty() {
        let first = warnings.swap_remove(0);
        return Err(Diagnostic {
            severity: Severity::Error,
            kind: LoadErrorKind::Strict,
            ..first
        }
        .into());
    }
    let desc = desc.expect("invariant: an error is reported where no scene is returned");
    Ok(LoadedScene {
        desc,
        warnings: warnings.into_iter().map(Warning::from).collect(),
        files,
    })
}

/// All errors and warnings of the scene in the file `path`, sorted by file (in the order of
/// inclusion) and location.
pub fn check_scene(path: &Path, options: &LoadOptions) -> Vec<Diagnostic> {
    let sink = Sink::default();
    load(path, options, &sink);
    sink.into_diagnostics()
}

/// Extensions of scene files.
pub const SCENE_EXTENSIONS: [&str; 4] = ["xml", "pbrt", "gltf", "glb"];

/// Format of a scene file.
enum Format {
    MitsubaXml,
    Gltf,
    Pbrt,
}

/// The scene without its invalid parts. `None` only if an error has been reported.
fn load(path: &Path, options: &LoadOptions, sink: &Sink) -> Option<SceneDesc> {
    let bytes = match read_regular(path) {
        Ok(bytes) => bytes,
        Err(error) => {
            let message = format!("cannot read the scene file `{}`: {error}", shown_path(path));
            let suggested = match path.is_dir() {
                true => scene_in(path).map(|file| shown_path(&file)),
                false => similar_file(path),
            };
            let help = suggested.map(|name| format!("did you mean `{name}`?"));
            let kind = LoadErrorKind::FileSystem;
            sink.file_error("scene::unreadable", message, help, kind);
            return None;
        }
    };
    sink.note_read(path);
    let format = detect_format(path, &bytes, sink)?;
    if !matches!(format, Format::MitsubaXml)
        && let Some((name, _)) = options.defines.first()
    {
        let message = format!("`{}` has no parameter `{name}`", path.display());
        let help = Some("only Mitsuba scenes have parameters".to_owned());
        sink.file_error("scene::option", message, help, LoadErrorKind::Option);
        return None;
    }
    if matches!(format, Format::Gltf) {
        return gltf::load(path, &bytes, options, sink);
    }
    if options.gltf != GltfOptions::default() {
        let message = format!("`{}` is not a glTF scene", path.display());
        let help = "the options for light units, environments and material variants apply to glTF scenes alone";
        let help = Some(help.to_owned());
        sink.file_error("scene::option", message, help, LoadErrorKind::Option);
        return None;
    }
    if matches!(format, Format::Pbrt) {
        return pbrt::load(path, bytes, options.fps, sink);
    }
    let text: Arc<str> = match String::from_utf8(bytes) {
        Ok(text) => text.into(),
        Err(error) => {
            let offset = error.utf8_error().valid_up_to();
            let message = format!(
                "the scene file `{}` is not UTF-8 text: invalid byte at offset {offset}",
                path.display()
            );
            sink.file_error("scene::encoding", message, None, LoadErrorKind::Scene);
            return None;
        }
    };
    mitsuba::load(path, text, options, sink)
}

/// The scene file that is meant where `folder` is given: one with the name `scene` before others.
fn scene_in(folder: &Path) -> Option<PathBuf> {
    let entries = std::fs::read_dir(folder).ok()?.flatten();
    let scenes = entries.map(|entry| entry.path()).filter(|path| {
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        path.is_file() && SCENE_EXTENSIONS.iter().any(|&scene| extension == scene)
    });
    scenes.min_by_key(|path| (path.file_stem() != Some("scene".as_ref()), path.clone()))
}

/// The format, by content or else by extension. An unknown format is reported.
fn detect_format(path: &Path, bytes: &[u8], sink: &Sink) -> Option<Format> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let first = bytes
        .iter()
        .copied()
        .find(|byte| !byte.is_ascii_whitespace());
    let extension = path
        .extension()
        .map(|extension| extension.to_string_lossy().to_lowercase());
    if first == Some(b'<') || extension.as_deref() == Some("xml") {
        return Some(Format::MitsubaXml);
    }
    let name = path.to_string_lossy().to_lowercase();
    if name.ends_with(".pbrt") || name.ends_with(".pbrt.gz") || pbrt::is_scene(bytes) {
        return Some(Format::Pbrt);
    }
    let is_gltf = bytes.starts_with(gltf::MAGIC)
        || first == Some(b'{')
        || matches!(extension.as_deref(), Some("gltf" | "glb"));
    if is_gltf {
        return Some(Format::Gltf);
    }
    let message = format!("the scene file `{}` has an unknown format", path.display());
    let help = "expected Mitsuba XML (`.xml`), versions 0.4 to 3, PBRT (`.pbrt`), versions 3 and 4, or glTF 2.0 (`.gltf`, `.glb`)";
    let help = Some(help.to_owned());
    sink.file_error("scene::unknown_format", message, help, LoadErrorKind::Scene);
    None
}
