//! The film of a render, from part files of all its blocks.

use super::identity::check_identity;
use super::run_state::RunState;
use super::shard::{PASSES, block_group};
use crate::failure::Failure;
use crate::picture::PictureFacts;
use manylight::film::Film;
use manylight::film::blocks::{block_count, passes_of_block};
use manylight_io::FileError;
use manylight_io::part::PartFile;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::collections::BTreeMap;
use std::num::NonZeroU32;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Most missing blocks that a message lists.
const LISTED: usize = 10;

/// Merges part files. One block of passes is in memory beside the sum of those before.
///
/// # Errors
/// A part cannot be read, is damaged or belongs to another render, or a block is missing or given
/// twice.
pub(crate) fn merge_parts(paths: &[PathBuf]) -> Result<(Film, PictureFacts), Failure> {
    let parts = paths
        .iter()
        .map(|path| PartFile::open(path))
        .collect::<Result<Vec<_>, _>>()?;
    let plan = MergePlan::new(&parts)?;
    let film = merge(&parts, &plan)?;
    let facts = facts(&parts, film.passes())?;
    Ok((film, facts))
}

/// Which part has which block.
struct MergePlan {
    /// Passes of the render.
    passes: u32,
    /// Index of the part of each block.
    part_of: Vec<usize>,
}

/// Consecutive blocks of a part.
struct Run {
    /// Index of the part.
    part: usize,
    blocks: Range<u32>,
}

impl MergePlan {
    /// Refuses parts of several renders, blocks that occur twice, and missing blocks.
    fn new(parts: &[PartFile]) -> Result<Self, Failure> {
        let limit = passes_of_render(parts)?;
        let block_passes = parts[0].header().film.block;
        let blocks = parts
            .iter()
            .map(blocks_of)
            .collect::<Result<Vec<_>, Failure>>()?;
        let passes = match limit {
            Some(passes) => passes,
            None => passes_of_blocks(blocks.iter().flatten(), block_passes),
        };
        let count = block_count(passes, block_passes);
        let mut found: BTreeMap<u32, usize> = BTreeMap::new();
        for (k, (part, blocks)) in parts.iter().zip(blocks).enumerate() {
            for block in blocks {
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

    /// The blocks in their order.
    fn runs(&self) -> Vec<Run> {
        let mut runs: Vec<Run> = Vec::new();
        for (block, &part) in (0..).zip(&self.part_of) {
            match runs.last_mut() {
                Some(run) if run.part == part => run.blocks.end += 1,
                _ => runs.push(Run {
                    part,
                    blocks: block..block + 1,
                }),
            }
        }
        runs
    }
}

/// Passes of a render of the blocks before the last of `blocks`, and of this one.
fn passes_of_blocks<'b>(blocks: impl Iterator<Item = &'b u32>, block_passes: NonZeroU32) -> u32 {
    let count = blocks.max().map_or(0, |last| last.saturating_add(1));
    count.saturating_mul(block_passes.get())
}

/// Passes of the render that the parts belong to; `None` if it has no end. Refuses checkpoints, and
/// parts of several renders.
fn passes_of_render(parts: &[PartFile]) -> Result<Option<u32>, Failure> {
    let passes: Vec<Option<u32>> = parts
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

/// Passes of the render that a share belongs to; `None` if it has no end. A checkpoint does not
/// state them.
fn passes_of_share(part: &PartFile) -> Result<Option<u32>, Failure> {
    let passes = part.header().render.get(PASSES);
    if passes == Some(&Value::Null) {
        return Ok(None);
    }
    let passes = passes.and_then(Value::as_u64);
    let passes = passes.and_then(|n| u32::try_from(n).ok());
    passes.filter(|&n| n > 0).map(Some).ok_or_else(|| {
        let message = "found no share of a render, expected a part file that --shard has written";
        damaged(part.path(), message)
    })
}

/// The blocks of a part.
pub(crate) fn blocks_of(part: &PartFile) -> Result<Vec<u32>, Failure> {
    let number = |group: &String| {
        let number = group.strip_prefix("block.")?.strip_suffix('.')?;
        number.parse::<u32>().ok()
    };
    let blocks: Option<Vec<u32>> = part.groups().iter().map(number).collect();
    blocks.ok_or_else(|| damaged(part.path(), "found a group of arrays that is no block"))
}

/// Adds the blocks in their order. A part is checked just before its blocks are read, while those
/// of the part before are added: the system still has the file in memory, so that it is read from
/// the disk once.
fn merge(parts: &[PartFile], plan: &MergePlan) -> Result<Film, Failure> {
    let mut film = parts[plan.part_of[0]].film(&block_group(0))?;
    let runs = plan.runs();
    let mut is_checked = vec![false; parts.len()];
    check(parts, &mut is_checked, runs.first())?;
    for (i, run) in runs.iter().enumerate() {
        let next = runs.get(i + 1);
        // All blocks are added by this thread: memory that another thread frees would not be used
        // again.
        std::thread::scope(|scope| {
            let checking = scope.spawn(|| check(parts, &mut is_checked, next));
            add(&mut film, &parts[run.part], run.blocks.clone(), plan.passes)?;
            checking
                .join()
                .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        })?;
    }
    Ok(film)
}

/// Checks the part of `run`, unless it was checked before.
fn check(parts: &[PartFile], is_checked: &mut [bool], run: Option<&Run>) -> Result<(), Failure> {
    if let Some(run) = run
        && !std::mem::replace(&mut is_checked[run.part], true)
    {
        parts[run.part].verify()?;
    }
    Ok(())
}

/// Adds blocks of a part to `film`, the film of the blocks before.
fn add(film: &mut Film, part: &PartFile, blocks: Range<u32>, passes: u32) -> Result<(), Failure> {
    for block in blocks {
        let sums = part.sums(&block_group(block), film)?;
        let (found, expected) = (sums.passes(), passes_of_block(block, film.block(), passes));
        if found != expected {
            let message = format!("block {block} has the passes {found:?}, expected {expected:?}");
            return Err(damaged(part.path(), &message));
        }
        film.append(sums);
    }
    Ok(())
}

/// What the first part says about its picture, with the passes and the seconds of all parts. The
/// command is left out if it names no number of passes.
fn facts(parts: &[PartFile], passes: u32) -> Result<PictureFacts, Failure> {
    let mut facts: PictureFacts = from_header(&parts[0], &parts[0].header().picture)?;
    for (name, value) in &mut facts.metadata {
        if ["passes", "samples"].contains(&name.as_str()) {
            *value = passes.to_string();
        }
    }
    if passes_of_share(&parts[0])?.is_none() {
        facts.metadata.retain(|(name, _)| name != "command");
    }
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
