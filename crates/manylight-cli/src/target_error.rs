//! `--target-error`: the end of a render by the error of the picture that is written.

use crate::interrupt::Interrupt;
use crate::session::Session;
use manylight::film::{ErrorBars, Film};
use manylight::render::{Budget, Observer, Stats, error_is_due};
use manylight_denoise::Oidn;
use std::ops::ControlFlow;
use std::time::Duration;

/// A denoised picture is made to learn its error only if that of the noisy one is at most as many
/// times the limit: 15 is the largest ratio of both errors in eight scenes.
const MAX_GAIN: f32 = 20.0;

/// Passes grow by one in this number until the picture is denoised again to learn its error, which
/// takes as long as many passes.
const DENOISED_STEP: u32 = 2;

/// An observer that asks for the error of the picture that is written, and calls another observer.
pub(crate) struct StatingError<'a> {
    pub(crate) session: &'a Session,
    /// The denoiser of the picture.
    pub(crate) oidn: Option<&'a Oidn>,
    /// Features for the denoiser that the film lacks.
    pub(crate) features: Option<&'a Film>,
    pub(crate) interrupt: &'a Interrupt,
    pub(crate) observer: &'a mut (dyn Observer + Send),
}

impl Observer for StatingError<'_> {
    fn begins(&mut self, budget: &Budget) {
        self.observer.begins(budget);
    }

    fn pass_done(&mut self, film: &Film, stats: &Stats, elapsed: Duration) -> ControlFlow<()> {
        self.observer.pass_done(film, stats, elapsed)
    }

    fn error(&mut self, film: &Film) -> Option<f32> {
        let Some(oidn) = self.oidn else {
            return self.observer.error(film);
        };
        if !error_is_due(film.passes(), DENOISED_STEP) {
            return None;
        }
        let (noisy, limit) = (
            ErrorBars::of_film(film)?,
            self.session.request.budget.relative_error?,
        );
        if noisy.stated.pixels > MAX_GAIN * limit {
            return None;
        }
        let denoised = (self.session).denoise(Some(oidn), film, self.features, self.interrupt);
        Some(denoised.picture?.bars?.stated.at_most)
    }

    fn ended(&mut self, film: &Film, stats: &Stats, elapsed: Duration) {
        self.observer.ended(film, stats, elapsed);
    }
}
