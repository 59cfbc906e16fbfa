//! `--denoise`: the library is opened before the render, features are rendered first, the image is filtered at the end.

use crate::args::DisplayArgs;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::{print_message, print_warnings};
use crate::request::RenderRequest;
use manylight::film::{Film, Layer};
use manylight::image::Image;
use manylight::render::{RenderJob, Stats};
use manylight_denoise::{
    FEATURE_PASSES, FeatureImages, FilterError, Oidn, SearchPlaces, denoise_film, render_features,
};
use std::time::Instant;

/// The denoiser of a request; `None` if it names none.
///
/// # Errors
/// The library is not found or cannot be used.
pub(super) fn open(request: &RenderRequest, display: DisplayArgs) -> Result<Option<Oidn>, Failure> {
    if request.denoise.is_none() {
        return Ok(None);
    }
    let places = SearchPlaces::from_environment(request.oidn_lib.clone());
    let oidn = Oidn::open(&places, request.threads)?;
    if display.verbose {
        print_message(format_args!(
            "denoiser: Open Image Denoise {} ({})",
            oidn.version(),
            oidn.file().display()
        ));
    }
    Ok(Some(oidn))
}

/// Renders features that the film of `job` will lack. Their time is taken from the time limit of `job`.
pub(super) fn features(job: &mut RenderJob, stats: &Stats, interrupt: &Interrupt) -> Option<Film> {
    let has_features = job.method.layers().contains(&Layer::Albedo);
    let expected = job.budget.passes.filter(|_| has_features).unwrap_or(0);
    let passes = FEATURE_PASSES.saturating_sub(expected);
    if passes == 0 {
        return None;
    }
    let start = Instant::now();
    let film = stats.time("features", || {
        render_features(job, passes, interrupt.cancel())
    });
    job.budget.time = (job.budget.time).map(|limit| limit.saturating_sub(start.elapsed()));
    Some(film)
}

/// A denoised image, or the reason why there is none.
pub(super) struct Denoised {
    /// The image.
    pub(super) image: Option<Image>,
    /// The failure of the library, to be reported when the image is written.
    pub(super) failure: Option<Failure>,
}

/// Denoises `film`. A second signal ends it.
pub(super) fn denoise(
    oidn: Option<&Oidn>,
    film: &Film,
    features: Option<&Film>,
    stats: &Stats,
    interrupt: &Interrupt,
) -> Denoised {
    let Some(oidn) = oidn else {
        return Denoised {
            image: None,
            failure: None,
        };
    };
    let films: Vec<&Film> = std::iter::once(film).chain(features).collect();
    let result = interrupt.denoising(|skip| {
        stats.time("denoise", || {
            let features = FeatureImages::from_films(&films);
            denoise_film(oidn, film, features.as_ref(), skip)
        })
    });
    let (image, failure) = match result {
        Ok(image) => (Some(image), None),
        Err(FilterError::Cancelled) => {
            print_warnings(&["denoising was interrupted; the image keeps its noise".into()]);
            (None, None)
        }
        Err(error @ FilterError::Library(_)) => {
            (None, Some(Failure::NotDenoised(error.to_string())))
        }
    };
    Denoised { image, failure }
}
