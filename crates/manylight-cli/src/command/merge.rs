//! `manylight merge`: the image of a render from part files of all its blocks.

use crate::args::MergeArgs;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::{print_data, print_message};
use crate::part::{RunState, block_group, check_identity};
use crate::picture::{PictureFacts, PictureSource};
use crate::request::check_formats;
use manylight::film::Film;
use manylight::film::blocks::{block_count, passes_of_block};
use manylight_io::part::PartFile;
use manylight_io::{FileError, check_replaceable};
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;

/// Version of the shape of the JSON object.
const SCHEMA: &str = "manylight.merge/1";
/// Most missing blocks that a message lists.
const LISTED: usize = 10;

/// Merges parts to image files. One block of passes is in memory beside the sum of those before.
pub(crate) fn run(args: &MergeArgs) -> Result<ExitCode, Failure> {
    check_formats(&args.outputs)?;
    args.outputs
        .iter()
        .try_for_each(|path| check_replaceable(path))?;
    let interrupt = Interrupt::install()?;
    let parts = args
        .parts
        .iter()
        .map(|path| PartFile::open(path))
        .collect::<Result<Vec<_>, _>>()?;
    let plan = MergePlan::new(&parts)?;
    parts.iter().try_for_each(PartFile::verify)?;
    let film = merge(&parts, &plan)?;
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
        let passes = passes_of_render(parts)?;
        let count = block_count(passes, parts[0].header().film.block);
        let mut found: BTreeMap<u32, usize> = BTreeMap::new();
        for (k, part) in parts.iter().enumerate() {
            for block in blocks_of(part)? {
                if block >= count {
                    let message = format!("found block {block} of {count}");
                    return Err(damaged(part.path(), &message));
                }
                if let Some(other) = found.insert(block, k) {
                    let [other, part] = [other, k].map(|k| parts[k].path().display());
                    return Err(Failure::usage(
                        format!("{other} and {part} both have block {block} of {count}"),
                        "give each share once",
                    ));
                }
            }
        }
        let missing = count as usize - found.len();
        if missing > 0 {
            let absent = (0..count).filter(|block| !found.contains_key(block));
            let first: Vec<String> = absent.take(LISTED).map(|block| block.to_string()).collect();
            let more = if missing > LISTED { ", ..." } else { "" };
            return Err(Failure::usage(
                format!(
                    "{missing} of {count} blocks of passes are in no part: {}{more}",
                    first.join(", ")
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

/// Passes of the render that the parts belong to. Refuses checkpoints, and parts of several renders.
fn passes_of_render(parts: &[PartFile]) -> Result<u32, Failure> {
    let passes: Vec<u32> = parts
        .iter()
        .map(passes_of_share)
        .collect::<Result<_, _>>()?;
    let first = &parts[0];
    for part in parts {
        let other = first.path().display().to_string();
        check_identity(part, &first.header().render, &other)?;
        if part.header().film != first.header().film {
            let message = "its film differs from that of the other parts";
            return Err(damaged(part.path(), message));
        }
    }
    Ok(passes[0])
}

/// Passes of the render that a share belongs to. A checkpoint does not state them.
fn passes_of_share(part: &PartFile) -> Result<u32, Failure> {
    let passes = part.header().render.get("passes").and_then(Value::as_u64);
    let passes = passes.and_then(|n| u32::try_from(n).ok());
    passes.filter(|&n| n > 0).ok_or_else(|| {
        let message = "found no share of a render, expected a part file that --shard has written";
        damaged(part.path(), message)
    })
}

/// The blocks of a part.
fn blocks_of(part: &PartFile) -> Result<Vec<u32>, Failure> {
    let number = |group: &String| {
        let number = group.strip_prefix("block.")?.strip_suffix('.')?;
        number.parse::<u32>().ok()
    };
    let blocks: Option<Vec<u32>> = part.groups().iter().map(number).collect();
    blocks.ok_or_else(|| damaged(part.path(), "found a group of arrays that is no block"))
}

/// Adds the blocks in their order.
fn merge(parts: &[PartFile], plan: &MergePlan) -> Result<Film, Failure> {
    let mut film = parts[plan.part_of[0]].film(&block_group(0))?;
    for (block, &k) in (0..).zip(&plan.part_of) {
        let sums = parts[k].sums(&block_group(block), &film)?;
        let (found, expected) = (
            sums.passes(),
            passes_of_block(block, film.block(), plan.passes),
        );
        if found != expected {
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
