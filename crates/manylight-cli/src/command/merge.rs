//! `manylight merge`: the image of a render from part files of all its blocks.

use crate::args::MergeArgs;
use crate::denoiser::{Denoised, open_denoiser};
use crate::failure::{DONE, Failure};
use crate::interrupt::Interrupt;
use crate::output::{print_data, print_message};
use crate::part::merge_parts;
use crate::picture::PictureSource;
use crate::request::{check_formats, check_keeps};
use crate::stated_error::{error_bars, sentence, to_json};
use manylight::film::{Film, StatedError};
use manylight_io::{check_replaceable, shown_path};
use serde_json::json;

/// Version of the shape of the JSON object.
const SCHEMA: &str = "manylight.merge/1";

/// Merges parts to image files.
pub(crate) fn run(args: &MergeArgs) -> Result<u8, Failure> {
    check_formats(&args.outputs)?;
    args.outputs
        .iter()
        .try_for_each(|path| check_replaceable(path))?;
    check_keeps(&args.parts, &args.outputs, "a part, which the image")?;
    let oidn = open_denoiser(&args.denoise, None)?;
    let interrupt = Interrupt::install()?;
    let (film, facts) = merge_parts(&args.parts)?;
    let denoise = |oidn| Denoised::of_film(oidn, &film, None, &interrupt);
    let denoised = oidn.as_ref().map(denoise).unwrap_or_default();
    denoised.warn_if_interrupted();
    let bars = error_bars(&film, denoised.picture.as_ref());
    let source = PictureSource {
        film: &film,
        denoised: denoised.picture.as_ref(),
        bars: bars.as_deref(),
        facts: &facts,
    };
    source.write(&args.outputs, &args.picture, &interrupt)?;
    report(args, &film, bars.map(|bars| bars.stated))?;
    match denoised.failure {
        Some(failure) => Err(failure),
        None => Ok(interrupt.exit_code().unwrap_or(DONE)),
    }
}

fn report(args: &MergeArgs, film: &Film, error: Option<StatedError>) -> Result<(), Failure> {
    let outputs: Vec<String> = args
        .outputs
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    if !args.quiet {
        print_message(format_args!(
            "merged {} passes of {} parts",
            film.passes(),
            args.parts.len()
        ));
        if let Some(error) = &error {
            print_message(sentence(error, film.passes()));
        }
        args.outputs
            .iter()
            .for_each(|path| print_message(format_args!("wrote {}", shown_path(path))));
    }
    if !args.json {
        return Ok(());
    }
    print_data(json!({
        "schema": SCHEMA,
        "version": env!("CARGO_PKG_VERSION"),
        "parts": args.parts.len(),
        "passes": film.passes(),
        "error": error.as_ref().map(to_json),
        "outputs": outputs,
    }))
}
