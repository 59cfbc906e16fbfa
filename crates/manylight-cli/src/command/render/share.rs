//! `--shard`: a share of the blocks of passes, to a part file.

use super::Run;
use crate::failure::Failure;
use crate::memory::{Surroundings, check_memory};
use crate::output::print_message;
use crate::part::write_share;
use crate::progress::{self, ProgressGoal};
use crate::values::Shard;
use manylight::film::blocks::{block_count, passes_of_block};
use manylight::render::{Budget, render_blocks};

impl Run<'_> {
    /// Renders a share of the blocks. Nothing is written if it is interrupted.
    pub(super) fn share(&self, shard: Shard) -> Result<u8, Failure> {
        let (session, interrupt, display) = (&self.session, self.interrupt, self.args.display);
        let (request, pool, stats) = (&session.request, &session.pool, &session.stats);
        self.choose(None)?;
        let job = session.job();
        let passes = job.budget.passes.unwrap_or_default();
        let count = block_count(passes, job.block);
        let blocks = shard.range(count);
        if blocks.is_empty() {
            return Err(Failure::usage(
                format!(
                    "--shard {}/{}: {passes} passes are {count} blocks of {}",
                    shard.index, shard.count, job.block
                ),
                "use fewer shares, or a smaller --block in all of them",
            ));
        }
        let surroundings = Surroundings::of_part(&blocks);
        pool.install(|| check_memory(request.memory_limit, &job, surroundings))?;
        let own_passes = blocks
            .clone()
            .map(|block| passes_of_block(block, job.block, passes));
        let own_passes = own_passes.map(|range| range.len() as u32).sum();
        let goal = ProgressGoal::new(Budget::passes(own_passes), display);
        let rendered = progress::show(goal, stats, interrupt.cancel(), &self.console, |observer| {
            pool.install(|| render_blocks(&job, blocks, stats, interrupt.cancel(), observer))
        });
        self.warn_of_samples();
        let Some(sums) = rendered else {
            print_message("interrupted: no part was written");
            return self.exit_code();
        };
        write_share(session, &job, &request.outputs[0], &sums, interrupt)?;
        super::finish(&session.report(&job, own_passes), display)?;
        self.exit_code()
    }
}
