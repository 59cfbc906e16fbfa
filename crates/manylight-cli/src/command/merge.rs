//! `manylight merge`: the image of a render from part files of all its blocks.

use crate::args::MergeArgs;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::{print_data, print_message};
use crate::part::{RunState, block_group, check_identity};
use crate::picture::{PictureFacts, PictureSource};
use crate::request::check_formats;
use manylight::film::Film;
use manylight_io::part::PartFile;
use manylight_io::{FileError, check_replaceable};
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;

/// Version of the shape of the JSON object.
const SCHEMA: &str = "manylight.merge/1";

/// Merges parts to image files. One block of passes is in memory beside the sum of those before.
pub(crate) fn run(args: &MergeArgs) -> Result<ExitCode, Failure> {
    check_formats(&args.outputs)?;
    args.outputs
        .iter()
        .try_for_each(|path| check_replaceable(path))?;
    let interrupt = Interrupt::install()?;
    let mut parts = args
        .parts
        .iter()
        .map(|path| PartFile::open(path))
        .collect::<Result<Vec<_>, _>>()?;
    let plan = MergePlan::new(&parts)?;
    parts.iter_mut().try_for_each(PartFile::verify)?;
    let film = merge(&mut parts, &plan)?;
    let facts = facts(&parts)?;
    let source = PictureSource {
        film: &film,
        denoised: None,
        facts: &facts,
    };
    source.write(&args.outputs, &args.picture, &interrupt)?;
    report(args, &film)?;
    Ok(interrupt
        .exit_code()
        .map_or(ExitCode::SUCCESS, ExitCode::from))
}

/// Which part has which block.
struct MergePlan {
    /// Passes of the render.
    passes: u32,
    /// Index of the part of each block.
    part_of: Vec<usize>,
}

impl MergePlan {
    /// Refuses parts of several renders, blocks that occur twice, and missing blocks.
    fn new(parts: &[PartFile]) -> Result<Self, Failure> {
        let first = &parts[0];
        let name = |k: usize| parts[k].path().display().to_string();
        for part in parts {
            check_identity(part, &first.header().render, &name(0))?;
            if part.header().film != first.header().film {
                return Err(damaged(
                    part.path(),
                    "its film differs from that of the other parts",
                ));
            }
        }
        let passes = first.header().render.get("passes").and_then(Value::as_u64);
        let Some(passes) = passes
            .and_then(|n| u32::try_from(n).ok())
            .filter(|&n| n > 0)
        else {
            let message =
                "found no share of a render, expected a part file that --shard has written";
            return Err(FileError::malformed(first.path(), message).into());
        };
        let count = passes.div_ceil(first.header().film.block.get());
        let mut found: BTreeMap<u32, usize> = BTreeMap::new();
        for (k, part) in parts.iter().enumerate() {
            for block in blocks_of(part)? {
                if block >= count {
                    return Err(damaged(
                        part.path(),
                        &format!("found block {block} of {count}"),
                    ));
                }
                if let Some(other) = found.insert(block, k) {
                    return Err(Failure::usage(
                        format!(
                            "{} and {} both have block {block} of {count}",
                            name(other),
                            name(k)
                        ),
                        "give each share once",
                    ));
                }
            }
        }
        let missing: Vec<String> = (0..count)
            .filter(|block| !found.contains_key(block))
            .map(|block| block.to_string())
            .collect();
        if !missing.is_empty() {
            return Err(Failure::usage(
                format!(
                    "{} of {count} blocks of passes are in no part: {}",
                    missing.len(),
                    missing.join(", ")
                ),
                "blocks are counted from 0; render their shares",
            ));
        }
        Ok(MergePlan {
            passes,
            part_of: found.into_values().collect(),
        })
    }
}

/// The blocks that the header of a part names.
fn blocks_of(part: &PartFile) -> Result<Vec<u32>, Failure> {
    let number = |group: &String| {
        let number = group.strip_prefix("block.")?.strip_suffix('.')?;
        number.parse::<u32>().ok()
    };
    let blocks: Option<Vec<u32>> = part.header().groups.iter().map(number).collect();
    blocks.ok_or_else(|| damaged(part.path(), "found a group of arrays that is no block"))
}

/// Adds the blocks in their order.
fn merge(parts: &mut [PartFile], plan: &MergePlan) -> Result<Film, Failure> {
    let size = parts[0].header().film.block.get();
    let mut film = parts[plan.part_of[0]].film(&block_group(0))?;
    for (block, &k) in plan.part_of.iter().enumerate() {
        let block = block as u32;
        let sums = parts[k].sums(&block_group(block), &film)?;
        let expected = block * size..((block + 1) * size).min(plan.passes);
        if sums.passes() != expected {
            let found = sums.passes();
            let message = format!("block {block} has the passes {found:?}, expected {expected:?}");
            return Err(damaged(parts[k].path(), &message));
        }
        film.append(sums);
    }
    Ok(film)
}

/// What the first part says about its picture, with the seconds of all parts.
fn facts(parts: &[PartFile]) -> Result<PictureFacts, Failure> {
    let mut facts: PictureFacts = from_header(&parts[0], &parts[0].header().picture)?;
    let mut seconds = 0.0;
    for part in parts {
        let state: RunState = from_header(part, &part.header().state)?;
        seconds += state.seconds;
    }
    // Those of the stages belong to one part.
    facts
        .metadata
        .retain(|(name, _)| !name.starts_with("seconds"));
    facts
        .metadata
        .push(("seconds".into(), format!("{seconds:.3}")));
    Ok(facts)
}

fn from_header<T: DeserializeOwned>(part: &PartFile, value: &Value) -> Result<T, Failure> {
    serde_json::from_value(value.clone())
        .map_err(|error| damaged(part.path(), &format!("the header is damaged: {error}")))
}

fn damaged(path: &Path, message: &str) -> Failure {
    FileError::malformed(path, message).into()
}

fn report(args: &MergeArgs, film: &Film) -> Result<(), Failure> {
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
        outputs
            .iter()
            .for_each(|path| print_message(format_args!("wrote {path}")));
    }
    if !args.json {
        return Ok(());
    }
    print_data(json!({
        "schema": SCHEMA,
        "version": env!("CARGO_PKG_VERSION"),
        "parts": args.parts.len(),
        "passes": film.passes(),
        "outputs": outputs,
    }))
}
