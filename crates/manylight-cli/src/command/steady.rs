//! `manylight steady`: frames of a walkthrough, averaged in time.

use crate::args::SteadyArgs;
use crate::failure::{DONE, Failure};
use crate::frame_files::FrameFiles;
use crate::interrupt::Interrupt;
use crate::output::{print_data, print_message};
use crate::request::check_formats;
use crate::steady::{steadied, walk_frame};
use manylight_denoise::{REACH, WalkFrame, steady};
use manylight_io::image::{LayeredImage, read_layered_image, write_image};
use manylight_io::{check_replaceable, shown_path};
use serde_json::json;
use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Version of the shape of the JSON object.
const SCHEMA: &str = "manylight.steady/1";

/// Averages the frames of files with their neighbors in time, and writes them to files. An
/// interrupt ends it between two frames.
pub(crate) fn run(args: &SteadyArgs) -> Result<u8, Failure> {
    let files = &args.derived;
    check_formats(&files.outputs)?;
    let source = FrameFiles::of(&args.frames);
    let numbers = source.existing()?;
    let outputs =
        |frame: u32| (files.outputs.iter()).map(move |path| FrameFiles::of(path).file(frame));
    // A set: comparing each frame with each output takes seconds for long walks.
    let sources: HashSet<PathBuf> = (numbers.iter())
        .filter_map(|&frame| fs::canonicalize(source.file(frame)).ok())
        .collect();
    for path in numbers.iter().flat_map(|&frame| outputs(frame)) {
        check_is_other(&path, &sources)?;
        check_replaceable(&path)?;
    }
    let interrupt = Interrupt::install()?;
    // The frames that are averaged with the next one, from the number `numbers[start]` on.
    let mut frames: Vec<WalkFrame> = Vec::new();
    let mut size = None;
    let mut start = 0;
    let mut written: Vec<PathBuf> = Vec::new();
    for (index, &number) in numbers.iter().enumerate() {
        while start + frames.len() < numbers.len().min(index + REACH + 1) {
            let path = source.file(numbers[start + frames.len()]);
            let image = read_layered_image(&path)?;
            check_size(&path, &image, &mut size)?;
            frames.push(walk_frame(&path, &image)?);
        }
        if index - start > REACH {
            frames.remove(0);
            start += 1;
        }
        let picture = steady(&frames, index - start);
        // Read again: all layers of seven frames would take gigabytes.
        let image = read_layered_image(&source.file(number))?;
        let range = format!("{}..{}", numbers[start], numbers[start + frames.len() - 1]);
        let image = steadied(&image, &picture, range);
        for path in outputs(number) {
            let _complete_file = interrupt.writing();
            write_image(&path, &image, files.tone.display())?;
            if !files.quiet {
                print_message(format_args!("wrote {}", shown_path(&path)));
            }
            written.push(path);
        }
        if let Some(code) = interrupt.exit_code() {
            return Ok(code);
        }
    }
    if files.json {
        let outputs: Vec<String> = (written.iter())
            .map(|path| path.display().to_string())
            .collect();
        print_data(json!({
            "schema": SCHEMA,
            "version": env!("CARGO_PKG_VERSION"),
            "frames": numbers,
            "outputs": outputs,
        }))?;
    }
    Ok(DONE)
}

/// Checks that `output` is none of the frames that are read, by canonical paths.
fn check_is_other(output: &Path, sources: &HashSet<PathBuf>) -> Result<(), Failure> {
    match fs::canonicalize(output).is_ok_and(|path| sources.contains(&path)) {
        false => Ok(()),
        true => Err(Failure::usage(
            format!("{} is a frame that is read", shown_path(output)),
            "give --output another name",
        )),
    }
}

/// Checks that a frame has the size of those before it.
fn check_size(
    path: &Path,
    image: &LayeredImage,
    expected: &mut Option<[usize; 2]>,
) -> Result<(), Failure> {
    let found = [image.width, image.height];
    let expected = *expected.get_or_insert(found);
    match found == expected {
        true => Ok(()),
        false => Err(Failure::usage(
            format!(
                "{} has {}x{} pixels, the frames before it {}x{}",
                shown_path(path),
                found[0],
                found[1],
                expected[0],
                expected[1]
            ),
            "give frames of one size",
        )),
    }
}
