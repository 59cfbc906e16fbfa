//! Scene files: which format a file has, and its way into a [`SceneDesc`].

mod mitsuba;
mod sink;

use crate::error::{Diagnostic, LoadError, LoadErrorKind, Severity};
use crate::warning::Warning;
use manylight::scene::SceneDesc;
use sink::Sink;
use std::path::Path;
use std::sync::Arc;

/// How a scene is loaded.
#[derive(Clone, Debug, Default)]
pub struct LoadOptions {
    /// Values of the file's `$name` parameters; they win over its `<default>`s.
    pub defines: Vec<(String, String)>,
    /// Treat the first warning as an error.
    pub strict: bool,
}

/// A scene as its file describes it, and what was left out or replaced.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// The scene.
    pub desc: SceneDesc,
    /// In the order of the file, each subject once.
    pub warnings: Vec<Warning>,
}

/// The plugins that can be used in a scene file, for one family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SupportedFamily {
    /// Plural, as in `manylight list bsdfs`.
    pub name: &'static str,
    /// Names of the plugins, sorted.
    pub plugins: &'static [&'static str],
}

/// All plugins that scene files can use, by family.
pub fn supported() -> &'static [SupportedFamily] {
    mitsuba::SUPPORTED
}

/// Reads the scene in `path` with everything that it names.
///
/// # Errors
/// The first error in the order of the file; with [`LoadOptions::strict`] and no error, the first warning.
pub fn load_scene(path: &Path, options: &LoadOptions) -> Result<LoadedScene, LoadError> {
    let sink = Sink::default();
    let desc = load(path, options, &sink);
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
    let desc = desc.expect("a scene without a description has an error");
    Ok(LoadedScene {
        desc,
        warnings: warnings.into_iter().map(Warning::from).collect(),
    })
}

/// Every error and warning of the scene in `path`: first by file in the order of inclusion, then by span.
pub fn check_scene(path: &Path, options: &LoadOptions) -> Vec<Diagnostic> {
    let sink = Sink::default();
    load(path, options, &sink);
    sink.into_diagnostics()
}

/// The formats of scene files.
enum Format {
    MitsubaXml,
}

/// The scene, as far as it can be understood; `None` only if an error was reported.
fn load(path: &Path, options: &LoadOptions, sink: &Sink) -> Option<SceneDesc> {
    let bytes = match std::fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) => {
            let message = format!("cannot read the scene file `{}`: {error}", path.display());
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
    let format = detect_format(path, &bytes, sink)?;
    let text: Arc<str> = match String::from_utf8(bytes) {
        Ok(text) => text.into(),
        Err(error) => {
            let span = error.utf8_error().valid_up_to();
            let message = format!(
                "`{}` is not UTF-8 text: byte {span} is damaged",
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
    match format {
        Format::MitsubaXml => mitsuba::load(path, text, options, sink),
    }
}

/// Chosen by content, and where that says nothing, by extension.
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
    let message = format!(
        "`{}` is in no scene format that is supported",
        path.display()
    );
    let help = Some("supported: Mitsuba XML (`.xml`), versions 0.4 to 3".to_owned());
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
