//! `manylight compare`.

use crate::args::CompareArgs;
use crate::compare::{Comparison, Frame, compare, table};
use crate::failure::Failure;
use crate::output::print_data;
use crate::viewer::{self, Group};
use manylight_io::image::{read_layered_image, write_file};
use serde_json::json;
use std::path::Path;
use std::process::ExitCode;

/// Version of the JSON object's shape.
const SCHEMA: &str = "manylight.compare/1";

/// Compares images with a reference.
pub(crate) fn run(args: &CompareArgs) -> Result<ExitCode, Failure> {
    let layer = args.layer.as_deref();
    let reference = read(&args.reference, layer)?;
    let name = args.reference.display().to_string();
    let measured = (args.images.iter())
        .map(|path| measure(path, &args.reference, &reference, layer))
        .collect::<Result<Vec<(Frame, Comparison)>, Failure>>()?;
    let (images, comparisons): (Vec<Frame>, Vec<Comparison>) = measured.into_iter().unzip();
    if let Some(path) = &args.html {
        let group = Group::new(name.clone(), &images, &comparisons, (&reference, &name));
        let page = viewer::page(&format!("Compared with {name}"), &[group]);
        write_file(path, page.as_bytes())?;
    }
    if args.json {
        print_data(json!({
            "schema": SCHEMA,
            "version": env!("CARGO_PKG_VERSION"),
            "reference": name,
            "layer": layer,
            "images": comparisons,
        }))?;
    } else {
        print_data(table(&name, &comparisons))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The image at `path`, and how it differs from a reference that [`read`] has read.
pub(crate) fn measure(
    path: &Path,
    reference_path: &Path,
    reference: &Frame,
    layer: Option<&str>,
) -> Result<(Frame, Comparison), Failure> {
    let image = read(path, layer)?;
    check_sizes(path, &image, reference_path, reference)?;
    let comparison = compare(path.display().to_string(), &image, reference);
    Ok((image, comparison))
}

/// Reads what comparisons need of an image file.
pub(crate) fn read(path: &Path, layer: Option<&str>) -> Result<Frame, Failure> {
    let picture = read_layered_image(path)?;
    Frame::new(&picture, layer).map_err(|error| {
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
