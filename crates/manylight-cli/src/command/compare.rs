//! `manylight compare`.

use crate::args::CompareArgs;
use crate::failure::{DONE, Failure};
use crate::output::print_data;
use manylight_io::write_file;
use manylight_lab::LabError;
use manylight_lab::compare::{Comparison, ComparisonImage, compare_file, read_image, table};
use manylight_lab::viewer::{self, ImageGroup};
use serde_json::json;

/// Version of the shape of the JSON object.
const SCHEMA: &str = "manylight.compare/1";

/// Compares images with a reference.
pub(crate) fn run(args: &CompareArgs) -> Result<u8, Failure> {
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
        print_data(table(&name, &comparisons))?;
    }
    Ok(DONE)
}
