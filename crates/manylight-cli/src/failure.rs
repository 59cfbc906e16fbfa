//! Failures of a command: one message and one exit code.

use manylight_denoise::Unavailable;
use manylight_io::{FileError, LoadError, LoadErrorKind, clean_text, shown_path};
use manylight_lab::text::plural;
use manylight_lab::{LabError, PlanError};
use miette::{Diagnostic, LabeledSpan, MietteHandlerOpts, ReportHandler, Severity, SourceCode};
use std::fmt;
use std::io::{self, IsTerminal, Write};
use std::path::PathBuf;
use thiserror::Error;

/// Exit code: all went well.
pub(crate) const DONE: u8 = 0;
/// Exit code: internal error or failed render.
pub(crate) const INTERNAL: u8 = 1;
/// Exit code: wrong arguments.
pub(crate) const USAGE: u8 = 2;
/// Exit code: an error in the scene.
pub(crate) const SCENE: u8 = 3;
/// Exit code: a file cannot be read or written.
pub(crate) const FILE_SYSTEM: u8 = 4;
/// Exit code: an optional component is missing.
pub(crate) const COMPONENT: u8 = 5;
/// Exit code: warnings under `--strict`.
pub(crate) const STRICT: u8 = 6;

/// Why a command fails.
#[derive(Debug, Error, Diagnostic)]
pub enum Failure {
    /// The arguments do not fit each other or the scene.
    #[error("{message}")]
    #[diagnostic(code(manylight::usage))]
    Usage {
        /// What was found.
        message: String,
        /// What to do instead.
        #[help]
        help: String,
    },
    /// The scene file, or a file that it names, cannot be loaded.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Load(Box<LoadError>),
    /// The content of the scene is invalid.
    #[error("{}: {message}", shown_path(scene))]
    #[diagnostic(code(manylight::scene))]
    Scene {
        /// The scene file.
        scene: PathBuf,
        /// What was found and what was expected.
        message: String,
    },
    /// The plan of a study is invalid.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Plan(Box<PlanError>),
    /// A file cannot be read or written.
    #[error("{0}")]
    #[diagnostic(code(manylight::file))]
    File(Box<FileError>),
    /// Standard output cannot be written.
    #[error("cannot write to standard output: {0}")]
    #[diagnostic(code(manylight::file))]
    Stdout(io::Error),
    /// The reader of standard output has closed it; not an error.
    #[error("standard output was closed")]
    ClosedPipe,
    /// The library that denoises is missing.
    #[error(transparent)]
    #[diagnostic(
        code(manylight::component),
        help(
            "install it by `pip install pyoidn`, or download it from https://www.openimagedenoise.org and set OIDN_DIR to its folder, \
            or name its file by --oidn-lib; or render without --denoise"
        )
    )]
    Denoiser(#[from] Unavailable),
    /// The image was written, but not denoised.
    #[error("the image was written without denoising: {0}")]
    #[diagnostic(code(manylight::denoise))]
    NotDenoised(String),
    /// There are warnings under `--strict`.
    #[error("{} warning{} under --strict", .0, plural(*.0))]
    #[diagnostic(
        code(manylight::strict),
        help("they are printed above; without --strict they are not errors")
    )]
    Strict(usize),
    /// The operating system refuses threads or signal handlers.
    #[error("{0}")]
    #[diagnostic(code(manylight::internal))]
    Internal(String),
}

impl Failure {
    /// [`Failure::Usage`] from its two texts.
    pub(crate) fn usage(message: impl Into<String>, help: impl Into<String>) -> Self {
        Failure::Usage {
            message: message.into(),
            help: help.into(),
        }
    }

    /// The exit code of the process.
    pub fn exit_code(&self) -> u8 {
        match self {
            Failure::ClosedPipe => DONE,
            Failure::Internal(_) | Failure::NotDenoised(_) => INTERNAL,
            Failure::Usage { .. } | Failure::Plan(_) => USAGE,
            Failure::Load(error) => match error.kind() {
                LoadErrorKind::Scene => SCENE,
                LoadErrorKind::FileSystem => FILE_SYSTEM,
                LoadErrorKind::Option => USAGE,
                LoadErrorKind::Strict => STRICT,
            },
            Failure::Scene { .. } => SCENE,
            Failure::File(_) | Failure::Stdout(_) => FILE_SYSTEM,
            Failure::Denoiser(_) => COMPONENT,
            Failure::Strict(_) => STRICT,
        }
    }

    /// Prints the message to standard error.
    pub(crate) fn print(&self) {
        // A failing standard error cannot be reported.
        let _ = write!(io::stderr().lock(), "{}", Rendered(self));
    }
}

impl From<LoadError> for Failure {
    fn from(error: LoadError) -> Self {
        Failure::Load(Box::new(error))
    }
}

impl From<LabError> for Failure {
    fn from(error: LabError) -> Self {
        match error {
            LabError::Plan(error) => Failure::Plan(error),
            LabError::File(error) => Failure::File(error),
            LabError::Usage { message, help } => Failure::Usage { message, help },
        }
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        Failure::File(Box::new(error))
    }
}

/// A diagnostic with text that a terminal shows and does not obey.
struct Clean<'d>(&'d dyn Diagnostic);

impl fmt::Debug for Clean<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.0, f)
    }
}

impl fmt::Display for Clean<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&clean_text(&self.0.to_string()))
    }
}

impl std::error::Error for Clean<'_> {}

impl Diagnostic for Clean<'_> {
    fn code<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.0.code()
    }

    fn severity(&self) -> Option<Severity> {
        self.0.severity()
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        let help = self.0.help()?.to_string();
        Some(Box::new(clean_text(&help).into_owned()))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.0.source_code()
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let cleaned = |label: LabeledSpan| {
            let text = label.label().map(|text| clean_text(text).into_owned());
            LabeledSpan::new_with_span(text, *label.inner())
        };
        Some(Box::new(self.0.labels()?.map(cleaned)))
    }
}

/// A diagnostic with its code, place and source excerpt; in color if standard error is a terminal.
pub(crate) struct Rendered<'d>(pub(crate) &'d dyn Diagnostic);

impl fmt::Display for Rendered<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Links would hide the code, and wrapped lines would break paths that scripts read.
        let mut options = MietteHandlerOpts::new().terminal_links(false);
        if !io::stderr().is_terminal() {
            options = options.wrap_lines(false).break_words(false);
        }
        options.build().debug(&Clean(self.0), f)
    }
}
