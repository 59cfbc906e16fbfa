//! Shares of a render in part files.

use super::render::Picture;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::kept_lights::ShadingLights;
use crate::part::{blocks_of, merge_parts, render_share};
use crate::pre_pass::choose;
use crate::session::Session;
use crate::values::Shard;
use manylight::film::blocks::block_count;
use manylight::render::{Observer, RenderJob};
use manylight_io::part::PartFile;
use serde_json::{Value, json};
use std::num::NonZeroU32;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The blocks of passes of a share.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PartBlocks {
    /// Share `index`, from 1, of `count`, as `--shard` takes it.
    Share {
        /// Which share.
        index: u32,
        /// Number of shares.
        count: NonZeroU32,
    },
    /// Blocks of a render with the number of passes of the session.
    Blocks(Range<u32>),
    /// Blocks of a render without end: it has as many passes as the parts that are merged.
    OpenBlocks(Range<u32>),
}

/// Renders blocks of passes to the part file `path`. `false` if it was interrupted: nothing is
/// written then.
///
/// # Errors
/// There are no such blocks, the session has a limit that depends on all shares or an option of
/// whole pictures, the memory limit is too small, or the file cannot be written.
pub fn render_part(
    session: &Session,
    blocks: PartBlocks,
    path: &Path,
    interrupt: &Interrupt,
    observer: &mut (dyn Observer + Send),
) -> Result<bool, Failure> {
    if session.request.frames.is_walkthrough() {
        return Err(Failure::usage(
            "a part is a share of one picture, not of the frames of a walkthrough",
            "render frames one by one",
        ));
    }
    let request = &session.request;
    let options_of_pictures = [
        ("denoise", request.denoise.denoise.is_some()),
        ("checkpoint", request.parts.checkpoint.is_some()),
        ("resume", request.parts.resume.is_some()),
        ("lights-out", request.kept.lights_out.is_some()),
    ];
    if let Some((name, _)) = options_of_pictures.iter().find(|(_, is_given)| *is_given) {
        return Err(Failure::usage(
            format!("--{name}: a part is a share of a picture"),
            format!("omit --{name}"),
        ));
    }
    choose(session, None)?;
    let lights = ShadingLights::of(session, interrupt)?;
    let mut job = RenderJob {
        lights: lights.kept(),
        ..session.job()
    };
    if job.budget.time.is_some() || job.budget.relative_error.is_some() {
        return Err(Failure::usage(
            "a part has neither a time nor an error limit: they depend on all parts",
            "give the number of passes of the whole render",
        ));
    }
    if matches!(blocks, PartBlocks::OpenBlocks(_)) {
        job.budget.passes = None;
    }
    let blocks = checked(blocks, &job)?;
    render_share(session, &job, blocks, path, interrupt, observer)
}

/// The range of blocks, if it is not empty and part of the render.
fn checked(blocks: PartBlocks, job: &RenderJob) -> Result<Range<u32>, Failure> {
    let count = job.budget.passes.map_or(u32::MAX / job.block, |passes| {
        block_count(passes, job.block)
    });
    let range = match blocks {
        PartBlocks::Share {
            index,
            count: shares,
        } if (1..=shares.get()).contains(&index) => Shard {
            index,
            count: shares,
        }
        .range(count),
        PartBlocks::Share { index, count } => {
            return Err(Failure::usage(
                format!("found share {index} of {count}"),
                "shares are counted from 1",
            ));
        }
        PartBlocks::Blocks(range) | PartBlocks::OpenBlocks(range) => range,
    };
    if range.is_empty() || range.end > count {
        return Err(Failure::usage(
            format!(
                "found the blocks {range:?} of a render of {count} blocks of {} passes",
                job.block
            ),
            "use fewer shares, or a smaller block in all of them",
        ));
    }
    Ok(range)
}

/// Merges part files to a picture, as `manylight merge` does.
///
/// # Errors
/// A part cannot be read, is damaged or belongs to another render, or a block is missing or given
/// twice.
pub fn merge(parts: &[PathBuf]) -> Result<Picture, Failure> {
    if parts.is_empty() {
        return Err(Failure::usage(
            "found no part",
            "give the parts of all shares of a render",
        ));
    }
    let (film, facts) = merge_parts(parts)?;
    Ok(Picture::new(&film, None, &facts))
}

/// Checks a part file of a share, and returns what it says: `render`, `film`, `state`, and the
/// indices of its `blocks`.
///
/// # Errors
/// The file cannot be read, is damaged, or is no share.
pub fn part_header(path: &Path) -> Result<Value, Failure> {
    let part = PartFile::open(path)?;
    part.verify()?;
    let header = part.header();
    Ok(json!({
        "render": header.render,
        "film": header.film,
        "state": header.state,
        "blocks": blocks_of(&part)?,
    }))
}
