//! `manylight compare`.

use crate::args::CompareArgs;
use crate::compare::{Frame, compare, table};
use crate::failure::Failure;
use crate::output::print_data;
use manylight_io::image::read_picture;
use serde_json::json;
use std::path::Path;
use std::process::ExitCode;

/// Version of the JSON object's shape.
const SCHEMA: &str = "manylight.compare/1";

/// Compares images with a reference.
pub(crate) fn run(args: &CompareArgs) -> Result<ExitCode, Failure> {
    let reference_path = &args.reference;
    let reference = read(reference_path)?;
    let mut comparisons = Vec::with_capacity(args.images.len());
    for path in &args.images {
        let image = read(path)?;
        check_sizes(path, &image, reference_path, &reference)?;
        comparisons.push(compare(path.display().to_string(), &image, &reference));
    }
    let name = reference_path.display().to_string();
    if args.json {
        print_data(json!({
            "schema": SCHEMA,
            "version": env!("CARGO_PKG_VERSION"),
            "reference": name,
            "images": comparisons,
        }))?;
    } else {
        print_data(table(&name, &comparisons))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn read(path: &Path) -> Result<Frame, Failure> {
    let picture = read_picture(path)?;
    Frame::new(&picture).map_err(|error| {
        Failure::usage(
            format!("{}: {error}", path.display()),
            "images with color are compared",
        )
    })
}

fn check_sizes(
    path: &Path,
    image: &Frame,
    reference_path: &Path,
    reference: &Frame,
) -> Result<(), Failure> {
    if (image.width, image.height) == (reference.width, reference.height) {
        return Ok(());
    }
    Err(Failure::usage(
        format!(
            "{} is {}x{} pixels, {} is {}x{}",
            path.display(),
            image.width,
            image.height,
            reference_path.display(),
            reference.width,
            reference.height
        ),
        "render both at the same --size",
    ))
}
