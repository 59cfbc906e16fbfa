//! `--shard`: a share of the blocks of passes, to a part file.

use super::Run;
use crate::failure::Failure;
use crate::kept_lights::ShadingLights;
use crate::output::print_message;
use crate::part::render_share;
use crate::progress::{self, ProgressGoal};
use crate::values::Shard;
use manylight::film::blocks::{BLOCK_STEP, block_count, passes_of_block};
use manylight::render::{Budget, RenderJob};
use manylight_lab::text::plural;

impl Run<'_> {
    /// Renders a share of the blocks. Nothing is written if it is interrupted.
    pub(super) fn share(&self, shard: Shard) -> Result<u8, Failure> {
        let (session, interrupt, display) = (&self.session, self.interrupt, self.args.display);
        self.check_share(shard)?;
        self.choose(None)?;
        let lights = ShadingLights::of(session, interrupt)?;
        let job = RenderJob {
            lights: lights.kept(),
            ..session.job()
        };
        let passes = job.budget.passes.unwrap_or_default();
        let count = block_count(passes, job.block);
        let blocks = shard.range(count);
        let own_passes = blocks
            .clone()
            .map(|block| passes_of_block(block, job.block, passes));
        let own_passes = own_passes.map(|range| range.len() as u32).sum();
        let goal = ProgressGoal::new(
            Budget::passes(own_passes),
            "no part will be written",
            display,
        );
        let (cancel, part) = (interrupt.cancel(), &session.request.outputs[0]);
        let is_written = progress::show(goal, &session.stats, cancel, &self.console, |observer| {
            render_share(session, &job, blocks, part, interrupt, observer)
        })?;
        self.warn_of_samples();
        if !is_written {
            print_message("interrupted: no part was written");
            return self.exit_code();
        }
        super::finish(&session.report(&job, own_passes), display)?;
        self.exit_code()
    }

    /// Checks that every share of the render has a block, so that all shares answer alike.
    fn check_share(&self, shard: Shard) -> Result<(), Failure> {
        // What was asked for: path tracing takes more passes in larger blocks, but as many blocks.
        let request = &self.session.request;
        let passes = request.budget.passes.unwrap_or_default();
        let block = request.parts.block;
        let blocks = block_count(passes, block);
        let Shard { index, count } = shard;
        if blocks >= count.get() {
            return Ok(());
        }
        let s = |count: u32| plural(count as usize);
        Err(Failure::usage(
            format!(
                "--shard {index}/{count}: found {blocks} block{} of up to {block} passes in {passes} pass{}, expected at least {count} blocks",
                s(blocks),
                if passes == 1 { "" } else { "es" },
            ),
            format!(
                "give more --passes, or fewer shares, or a smaller --block, a multiple of {BLOCK_STEP}; the same in all shares"
            ),
        ))
    }
}
