//! `manylight compare`.

use crate::args::CompareArgs;
use crate::failure::{DONE, Failure};
use crate::output::{print_data, print_text};
use manylight_io::{check_replaceable, is_same_file, shown_path, write_file};
use manylight_lab::LabError;
use manylight_lab::compare::{Comparison, ComparisonImage, compare_file, read_image, table};
use manylight_lab::viewer::{self, ImageGroup};
use serde_json::json;
use std::path::Path;

/// Version of the shape of the JSON object.
const SCHEMA: &str = "manylight.compare/1";

/// Compares images with a reference.
pub(crate) fn run(args: &CompareArgs) -> Result<u8, Failure> {
    if let Some(page) = &args.html {
        check_page(args, page)?;
    }
    let layer = args.layer.as_deref();
    let reference = read_image(&args.reference, layer)?;
    let name = args.reference.display().to_string();
    let measured = (args.images.iter())
        .map(|path| compare_file(path, &args.reference, &reference, layer))
        .collect::<Result<Vec<(ComparisonImage, Comparison)>, LabError>>()?;
    let (images, comparisons): (Vec<ComparisonImage>, Vec<Comparison>) =
        measured.into_iter().unzip();
    if let Some(path) = &args.html {
        let group = ImageGroup::new(name.clone(), &images, &comparisons, (&reference, &name));
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
        print_text(&table(&name, &comparisons))?;
    }
    Ok(DONE)
}

/// Refuses a page that cannot be written or would replace an image.
fn check_page(args: &CompareArgs, page: &Path) -> Result<(), Failure> {
    let mut images = args.images.iter().chain([&args.reference]);
    if images.any(|image| is_same_file(image, page)) {
        return Err(Failure::usage(
            format!(
                "--html: {} is an image, which the page would replace",
                shown_path(page)
            ),
            "use a name such as compared.html",
        ));
    }
    Ok(check_replaceable(page)?)
}
