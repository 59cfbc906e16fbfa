//! `manylight relight`: a picture with other factors on its light groups.

use crate::args::RelightArgs;
use crate::failure::{DONE, Failure};
use crate::interrupt::Interrupt;
use crate::output::{print_data, print_message};
use crate::relight::{RelitContent, relight};
use crate::request::{check_formats, check_keeps, have_layers};
use manylight_io::image::{read_layered_image, write_image};
use manylight_io::{check_replaceable, shown_path};
use serde_json::{Map, Value, json};

/// Version of the shape of the JSON object.
const SCHEMA: &str = "manylight.relight/1";

/// Weighs the light groups of an image, and writes it to files.
pub(crate) fn run(args: &RelightArgs) -> Result<u8, Failure> {
    let files = &args.derived;
    check_formats(&files.outputs)?;
    (files.outputs.iter()).try_for_each(|path| check_replaceable(path))?;
    let inputs = std::slice::from_ref(&args.image);
    let what = "the picture with the light groups, which the result";
    check_keeps(inputs, &files.outputs, what)?;
    let interrupt = Interrupt::install()?;
    let image = read_layered_image(&args.image)?;
    let content = match have_layers(&files.outputs) {
        true => RelitContent::Layers,
        false => RelitContent::Picture,
    };
    let picture = relight(&args.image, &image, &args.groups, content)?;
    for path in &files.outputs {
        let _complete_file = interrupt.writing();
        write_image(path, &picture, files.tone.display())?;
        if !files.quiet {
            print_message(format_args!("wrote {}", shown_path(path)));
        }
    }
    if files.json {
        let factors = args.groups.iter();
        let factors = factors.map(|group| (group.name.clone(), group.factors.to_vec().into()));
        let outputs: Vec<String> = (files.outputs.iter())
            .map(|path| path.display().to_string())
            .collect();
        print_data(json!({
            "schema": SCHEMA,
            "version": env!("CARGO_PKG_VERSION"),
            "groups": factors.collect::<Map<String, Value>>(),
            "outputs": outputs,
        }))?;
    }
    Ok(interrupt.exit_code().unwrap_or(DONE))
}
