//! Renders to pictures in memory.

use crate::denoiser::open_denoiser;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::kept_lights::ShadingLights;
use crate::names::{AovNames, Named, value_of};
use crate::output::Console;
use crate::picture::{PictureFacts, PictureSource};
use crate::pre_pass::choose;
use crate::prepared::Prepared;
use crate::session::Session;
use crate::stated_error::error_bars;
use manylight::film::Film;
use manylight::render::{Observer, RenderJob, Stop};
use manylight_denoise::DenoisedImage;
use manylight_io::image::{DisplayTransform, LayeredImage, View};

/// A picture with what is known of its render.
#[derive(Clone, Debug)]
pub struct Picture {
    /// The layers of an EXR file, with its metadata.
    pub image: LayeredImage,
    /// Number of passes.
    pub passes: u32,
    /// Upper bound of the relative error, as `--target-error` takes it; infinite if it is unknown.
    pub relative_error: f32,
}

impl Picture {
    /// The picture of `film`, denoised if there is a denoised image.
    pub(super) fn new(film: &Film, denoised: Option<&DenoisedImage>, facts: &PictureFacts) -> Self {
        let bars = error_bars(film, denoised);
        let source = PictureSource {
            film,
            denoised,
            bars: bars.as_deref(),
            facts,
        };
        Picture {
            image: source.picture(AovNames::Manylight),
            passes: film.passes(),
            relative_error: bars.map_or(f32::INFINITY, |bars| bars.stated.at_most),
        }
    }
}

/// The word of `--view` that is its default.
pub const DEFAULT_VIEW: &str = View::NAMES[0].0;

/// How values become colors of 8 bits: an exposure in stops, and a word that `--view` takes.
///
/// # Errors
/// The word is unknown.
pub fn display_transform(exposure: f32, view: &str) -> Result<DisplayTransform, Failure> {
    let view = value_of(view)
        .map_err(|expected| Failure::usage(format!("--view: found '{view}'"), expected))?;
    Ok(DisplayTransform {
        exposure_ev: exposure,
        view,
    })
}

/// The result of a render.
#[derive(Debug)]
pub struct Rendered {
    /// The picture.
    pub picture: Picture,
    /// Whether it was interrupted.
    pub interrupted: bool,
    /// What went wrong at the end, such as a checkpoint that was not written.
    pub failures: Vec<Failure>,
}

impl Session {
    /// Whether the picture is to be denoised.
    pub fn denoises(&self) -> bool {
        self.oidn.is_some()
    }

    /// Renders a picture, and denoises it if that is asked for; `None` if an interrupt came before
    /// all lights were made that are to be kept.
    ///
    /// # Errors
    /// The denoiser is missing, the memory limit is too small, or the checkpoint to continue from
    /// is not one of this render.
    pub fn render(
        &self,
        interrupt: &Interrupt,
        observer: &mut (dyn Observer + Send),
    ) -> Result<Option<Rendered>, Failure> {
        let oidn = open_denoiser(&self.request.denoise, self.request.run.threads())?;
        choose(self, oidn.as_ref())?;
        let lights = ShadingLights::of(self, interrupt)?;
        if lights.are_interrupted() {
            return Ok(None);
        }
        let prepared = Prepared::new(self, oidn.as_ref(), lights.kept(), None, interrupt)?;
        let rendered = prepared.render(&Console::default(), observer);
        let denoised = rendered.denoise();
        let outcome = &rendered.outcome;
        let picture = self.picture_of(&rendered.job, &outcome.film, denoised.picture.as_ref());
        let interrupted = outcome.stop == Stop::Cancelled || denoised.interrupted;
        let failures = rendered.checkpoint.err().map(Failure::from).into_iter();
        Ok(Some(Rendered {
            picture,
            interrupted,
            failures: failures.chain(denoised.failure).collect(),
        }))
    }

    /// The picture of a film of this session, as an observer gets it.
    pub fn picture(&self, film: &Film) -> Picture {
        self.picture_of(&self.job(), film, None)
    }

    fn picture_of(
        &self,
        job: &RenderJob,
        film: &Film,
        denoised: Option<&DenoisedImage>,
    ) -> Picture {
        let facts = self.facts(film, job, &self.report(job, film.passes()));
        Picture::new(film, denoised, &facts)
    }
}
