//! Scene files. [`load_scene`] returns a [`SceneDesc`], [`check_scene`] all problems of a file.

mod assets;
mod attributes;
mod curve_files;
mod digest;
mod expansion;
mod files;
mod gltf;
mod growth;
mod mitsuba;
mod names;
mod pbrt;
mod sink;
mod tubes;

pub use digest::scene_digest;
pub use gltf::{EnvironmentSource, GltfOptions, LightUnits};

use crate::error::{Diagnostic, LoadError, LoadErrorKind, Severity};
use crate::read::read_regular;
use crate::shown::shown_path;
use crate::warning::Warning;
use manylight::scene::SceneDesc;
use sink::Sink;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Options of loading.
#[derive(Clone, Debug, Default)]
pub struct LoadOptions {
    /// Values of `$name` parameters, as pairs of name and value. They override the `<default>`s of the file.
    pub defines: Vec<(String, String)>,
    /// Whether the first warning is an error.
    pub strict: bool,
    /// Options for glTF scenes. Options that differ from the default are errors for scenes of other formats.
    pub gltf: GltfOptions,
}

/// The description of a scene, and the warnings of loading it.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// The description of the scene.
    pub desc: SceneDesc,
    /// In the order of the file; repeated subjects are reported once.
    pub warnings: Vec<Warning>,
    /// Paths of the files that were read, sorted: the scene, included files, meshes, images and spectra.
    pub files: Vec<PathBuf>,
}

/// The supported plugins of one family in one format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SupportedFamily {
    /// Format of the scene files: `mitsuba` or `pbrt`.
    pub format: &'static str,
    /// Plural name of the family, such as `bsdfs`.
    pub name: &'static str,
    /// Sorted names of the plugins.
    pub plugins: &'static [&'static str],
}

/// The supported plugins of scene files, by format and family.
pub fn supported() -> impl Iterator<Item = SupportedFamily> {
    mitsuba::SUPPORTED.iter().chain(pbrt::SUPPORTED).copied()
}

/// Loads the scene in the file `path`, with all included files, meshes and images.
///
/// # Errors
/// The first error in the order of the file. With [`LoadOptions::strict`], the first warning if there is no error.
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

/// All errors and warnings of the scene in the file `path`, sorted by file (in the order of inclusion) and location.
pub fn check_scene(path: &Path, options: &LoadOptions) -> Vec<Diagnostic> {
    let sink = Sink::default();
    load(path, options, &sink);
    sink.into_diagnostics()
}

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
            let help =
                crate::resolve::similar_file(path).map(|name| format!("did you mean `{name}`?"));
            sink.report(whole_file(
                "scene::unreadable",
                message,
                help,
                LoadErrorKind::FileSystem,
            ));
            return None;
        }
    };
    sink.note_read(path);
    let format = detect_format(path, &bytes, sink)?;
    if matches!(format, Format::Gltf) {
        return gltf::load(path, &bytes, &options.gltf, sink);
    }
    if options.gltf != GltfOptions::default() {
        let message = format!("`{}` is not a glTF scene", path.display());
        let help = "the options for light units, environments and material variants apply to glTF scenes alone";
        sink.report(whole_file(
            "scene::option",
            message,
            Some(help.to_owned()),
            LoadErrorKind::Option,
        ));
        return None;
    }
    if matches!(format, Format::Pbrt) {
        return pbrt::load(path, bytes, sink);
    }
    let text: Arc<str> = match String::from_utf8(bytes) {
        Ok(text) => text.into(),
        Err(error) => {
            let offset = error.utf8_error().valid_up_to();
            let message = format!(
                "the scene file `{}` is not UTF-8 text: invalid byte at offset {offset}",
                path.display()
            );
            sink.report(whole_file(
                "scene::encoding",
                message,
                None,
                LoadErrorKind::Scene,
            ));
            return None;
        }
    };
    mitsuba::load(path, text, options, sink)
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
    sink.report(whole_file(
        "scene::unknown_format",
        message,
        help,
        LoadErrorKind::Scene,
    ));
    None
}

/// An error about a file as a whole.
fn whole_file(
    code: &'static str,
    message: String,
    help: Option<String>,
    kind: LoadErrorKind,
) -> Diagnostic {
    Diagnostic {
        severity: Severity::Error,
        kind,
        code,
        message,
        location: None,
        help,
    }
}
