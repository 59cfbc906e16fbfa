//! `--shard`: a share of the blocks of passes, to a part file.

use super::{Run, check_memory, dropped_samples};
use crate::failure::Failure;
use crate::output::print_message;
use crate::part::{RunState, write_shard};
use crate::picture::PictureFacts;
use crate::progress::{self, ProgressGoal};
use crate::values::Shard;
use manylight::film::PassSums;
use manylight::film::blocks::{block_count, passes_of_block};
use manylight::render::{Budget, RenderJob, render_blocks};
use manylight_io::part::PartHeader;
use serde_json::json;
use std::process::ExitCode;

impl Run<'_> {
    /// Renders a share of the blocks. Nothing is written if it is interrupted.
    pub(super) fn share(&mut self, shard: Shard) -> Result<ExitCode, Failure> {
        let (stats, interrupt, display) = (self.stats, self.interrupt, self.args.display);
        let job = self.job();
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
        self.pool
            .install(|| check_memory(self.request, &job, blocks.len(), None))?;
        let own_passes = blocks
            .clone()
            .map(|block| passes_of_block(block, job.block, passes));
        let own_passes = own_passes.map(|range| range.len() as u32).sum();
        let goal = ProgressGoal::new(Budget::passes(own_passes), display);
        let rendered = progress::show(goal, stats, interrupt.cancel(), &self.console, |observer| {
            self.pool
                .install(|| render_blocks(&job, blocks, stats, interrupt.cancel(), observer))
        });
        self.warnings.extend(dropped_samples(stats, display));
        let Some(sums) = rendered else {
            print_message("interrupted: no part was written");
            return self.exit_code();
        };
        self.write_share(&job, &sums)?;
        super::finish(&self.report(&job, own_passes), display)?;
        self.exit_code()
    }

    fn write_share(&self, job: &RenderJob, sums: &[PassSums]) -> Result<(), Failure> {
        let (film, stats) = (job.film(0), self.stats);
        let passes = job.budget.passes.unwrap_or_default();
        let mut identity = self.settings(job).identity(self.digest);
        identity.insert("passes".into(), passes.into());
        let report = self.report(job, passes);
        let facts = PictureFacts::new(self.scene, film.id_layers(), report.metadata());
        let seconds = stats.stages().iter().map(|(_, time)| *time).sum();
        let state = json!(RunState::new(stats, seconds));
        let header = PartHeader::new(&film, identity, state, json!(facts));
        let part = &self.request.outputs[0];
        let _complete_file = self.interrupt.writing();
        stats.time("write", || write_shard(part, &header, &film, sums))
    }
}
