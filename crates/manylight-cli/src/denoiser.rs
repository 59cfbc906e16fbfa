//! The denoiser that a command names, and what it makes of a film.

use crate::args::DenoiseArgs;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::print_warnings;
use manylight::film::Film;
use manylight_denoise::{
    DenoisedImage, FeatureImages, FilterError, Oidn, SearchPlaces, denoise_film,
};

/// The denoiser that `args` name, with this number of threads, all by default; `None` if they name
/// none.
///
/// # Errors
/// The library is not found or cannot be used.
pub(crate) fn open_denoiser(
    args: &DenoiseArgs,
    threads: Option<usize>,
) -> Result<Option<Oidn>, Failure> {
    if args.denoise.is_none() {
        return Ok(None);
    }
    let places = SearchPlaces::from_environment(args.oidn_lib.clone());
    Ok(Some(Oidn::open(&places, threads)?))
}

/// A denoised image, or the reason why there is none.
#[derive(Default)]
pub(crate) struct Denoised {
    /// The image.
    pub(crate) picture: Option<DenoisedImage>,
    /// The failure of the library, to be reported when the image is written.
    pub(crate) failure: Option<Failure>,
    /// Whether a second signal ended the denoising.
    pub(crate) interrupted: bool,
}

impl Denoised {
    /// The image of `film`, with the albedo and normals of both films. A second signal ends it.
    pub(crate) fn of_film(
        oidn: &Oidn,
        film: &Film,
        features: Option<&Film>,
        interrupt: &Interrupt,
    ) -> Self {
        let films: Vec<&Film> = std::iter::once(film).chain(features).collect();
        let result = interrupt.denoising(|skip| {
            let features = FeatureImages::from_films(&films);
            denoise_film(oidn, film, features.as_ref(), skip)
        });
        match result {
            Ok(picture) => Denoised {
                picture: Some(picture),
                ..Denoised::default()
            },
            Err(FilterError::Cancelled) => Denoised {
                interrupted: true,
                ..Denoised::default()
            },
            Err(error @ FilterError::Library(_)) => Denoised {
                failure: Some(Failure::NotDenoised(error.to_string())),
                ..Denoised::default()
            },
        }
    }

    /// Warns if the image keeps its noise because a signal ended the denoising.
    pub(crate) fn warn_if_interrupted(&self) {
        if self.interrupted {
            print_warnings(&["denoising was interrupted; the image keeps its noise".into()]);
        }
    }
}
