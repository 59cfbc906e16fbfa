//! The error that a render states of its picture.

use manylight::film::{ErrorBars, Film, StatedError};
use manylight_denoise::DenoisedImage;
use serde_json::{Value, json};
use std::borrow::Cow;

/// Part of the squared error in a hundredth of the picture from which on a warning names it.
const CONCENTRATED: f32 = 0.5;

/// Passes below which the error is called rough.
const FEW_PASSES: u32 = 8;

/// The error bars of the picture of `film`, denoised if it is; `None` if they are not known.
pub(crate) fn error_bars<'d>(
    film: &Film,
    denoised: Option<&'d DenoisedImage>,
) -> Option<Cow<'d, ErrorBars>> {
    match denoised {
        None => ErrorBars::of_film(film).map(Cow::Owned),
        Some(denoised) => denoised.bars.as_ref().map(Cow::Borrowed),
    }
}

/// The error after `passes` passes in a sentence.
pub(crate) fn sentence(error: &StatedError, passes: u32) -> String {
    let percent = |error: f32| {
        let percent = 100.0 * f64::from(error);
        let digits = if percent < 1.0 { 2 } else { 1 };
        format!("{percent:.digits$} %")
    };
    let doubt = match passes < FEW_PASSES {
        true => format!("; rough, from {passes} passes"),
        false => String::new(),
    };
    format!(
        "error of a pixel: {} of its value (root mean square; at most {} with 95 % confidence{doubt}), of 8x8 pixels: {}",
        percent(error.pixels),
        percent(error.at_most),
        percent(error.blocks)
    )
}

/// The error in the report of a render.
pub(crate) fn to_json(error: &StatedError) -> Value {
    json!({
        "pixels": error.pixels,
        "pixels_at_most": error.at_most,
        "blocks": error.blocks,
        "in_a_hundredth": error.concentration,
    })
}

/// The error as metadata of an image (name, value).
pub(crate) fn metadata(error: &StatedError) -> [(String, String); 3] {
    [
        ("error".into(), error.pixels.to_string()),
        ("error.at_most".into(), error.at_most.to_string()),
        ("error.blocks".into(), error.blocks.to_string()),
    ]
}

/// A warning if the error may be larger than stated.
pub(crate) fn doubt(error: &StatedError) -> Option<String> {
    (error.concentration > CONCENTRATED).then(|| {
        format!(
            "{:.0} % of the squared error lie in a hundredth of the picture: some light is found rarely, as in caustics and behind gaps, and the error may be larger than stated",
            100.0 * error.concentration
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_sentences() {
        let error = StatedError {
            pixels: 0.0312,
            blocks: 0.0049,
            at_most: 0.0347,
            concentration: 0.1,
        };
        assert_eq!(
            sentence(&error, 8),
            "error of a pixel: 3.1 % of its value (root mean square; at most 3.5 % with 95 % confidence), of 8x8 pixels: 0.49 %"
        );
        assert!(sentence(&error, 7).contains("confidence; rough, from 7 passes)"));
        assert_eq!(doubt(&error), None);
        let concentrated = StatedError {
            concentration: 0.7,
            ..error
        };
        assert!(doubt(&concentrated).unwrap().starts_with("70 %"));
    }
}
