"""One render on a cluster: rounds of shares, merging, and the report."""

import math
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import manylight as ml

from .cluster import Cluster, log
from .display import Display
from .folder import Folder
from .rounds import Progress, next_round
from .sender import Sender
from .settings import Goal
from .shares import cut, gaps, share_count
from .worker import Share


@dataclass
class Report:
    """What a render on a cluster has done."""

    shares: list[Share] = field(default_factory=list)  #: in the order of their blocks, with worker and SHA-256
    blocks: int = 0  #: of the image
    passes: int = 0  #: of the image
    found_blocks: int = 0  #: which an earlier call with the same folder had rendered
    retries: int = 0  #: shares that failed and were sent again. Dask repeats those of a dead worker by itself
    repeated_blocks: int = 0  #: blocks that were begun more than once, in this call and the earlier ones
    repeated_passes: int = 0  #: passes that were rendered more than once, to within half a second for killed workers
    rounds: int = 0  #: 1 with `passes`
    seconds: float = 0.0  #: from the first share to the merged image
    merge_seconds: float = 0.0  #: of merging, in all rounds


class Job:
    """One render: rounds of shares, and the image of all parts."""

    def __init__(
        self,
        cluster: Cluster,
        sender: Sender,
        folder: Folder,
        goal: Goal,
        block: int,
        shares: int | None,
        display: Display,
    ):
        self.report = Report()
        self._cluster = cluster
        self._sender = sender
        self._folder = folder
        self._goal = goal
        self._block = block
        self._shares = shares
        self._display = display
        self._complete: list[Share] = []
        self._found: list[range] = []  # shares of earlier calls
        self._merge_seconds = 0.0  # of the last merge, per block

    def run(self) -> Any:
        """Renders and merges."""
        start = time.monotonic()
        image = self._fixed() if self._goal.passes is not None else self._in_rounds(start)
        self.report.seconds = time.monotonic() - start
        self._finish_report(image)
        return image

    def _fixed(self) -> Any:
        assert self._goal.passes is not None
        self._round(math.ceil(self._goal.passes / self._block))
        return self._merge()

    def _in_rounds(self, start: float) -> Any:
        found = self._folder.found()
        blocks = found[-1].stop if found else 0
        image, block_seconds = None, None
        while True:
            now = Progress(
                blocks=len(self._blocks()),
                workers=self._cluster.workers,
                seconds=time.monotonic() - start,
                block_seconds=block_seconds,
                merge_seconds=self._merge_seconds,
                relative_error=None if image is None else image.relative_error,
            )
            # The first round of a repeated call closes the gaps of the earlier one.
            more = blocks if now.blocks == 0 and blocks > 0 else next_round(now, self._goal.time, self._goal.target_error)
            if more == 0:
                return self._merge() if image is None else image
            round_start = time.monotonic()
            rendered = self._round(now.blocks + more)
            block_seconds = self._seconds_per_block(rendered, time.monotonic() - round_start) or block_seconds
            # The time needs no image; the first merge tells how long the last one takes.
            image = self._merge() if self._goal.target_error is not None or self.report.rounds == 1 else None
            if self._goal.target_error is not None and image is not None:
                self._display.note(f"relative error {image.relative_error:.3g} after {image.passes} passes")

    def _seconds_per_block(self, shares: list[Share], seconds: float) -> float | None:
        """Seconds of a worker per block in a round of `seconds`; None if it had nothing to render."""
        blocks = sum(share.rendered for share in shares)
        if blocks == 0:
            return None
        if self.report.rounds == 1:
            # Without the time for loading the scene, which later rounds do not take.
            return sum(share.seconds for share in shares) / blocks
        return seconds * max(self._cluster.workers, 1) / blocks

    def _blocks(self) -> list[int]:
        return [block for share in self._complete for block in share.blocks]

    def _round(self, count: int) -> list[Share]:
        """Completes the blocks below `count`. Returns the shares of this round."""
        existing: list[range] = []
        if self.report.rounds == 0:
            existing = self._found = [blocks for blocks in self._folder.found() if blocks.stop <= count]
        missing = gaps(count, [*existing, *(share.blocks for share in self._complete)])
        blocks = sum(len(run) for run in missing)
        shares = min(self._shares or share_count(blocks, self._cluster.workers), max(blocks, 1))
        # Workers look at what exists, too: it may be damaged.
        done = self._sender.run([*existing, *cut(missing, shares)])
        self._complete = sorted([*self._complete, *done], key=lambda share: share.blocks.start)
        self.report.rounds += 1
        return done

    def _merge(self) -> Any:
        """The image of all parts. Parts that are damaged or lost since they were written are rendered again, once."""
        start = time.monotonic()
        paths = [Path(share.path) for share in self._complete]
        self._folder.wait_for(paths)
        try:
            image = ml.merge([str(path) for path in paths])
        except ml.FileError as error:
            log.warning("the parts cannot be merged, and are examined again: %s", error)
            self._display.restart()
            again = self._sender.run([share.blocks for share in self._complete])
            self._complete = [new if new.rendered else old for old, new in zip(self._complete, again, strict=True)]
            image = ml.merge([str(path) for path in paths])
        seconds = time.monotonic() - start
        self.report.merge_seconds += seconds
        self._merge_seconds = seconds / max(len(self._blocks()), 1)
        return image

    def _finish_report(self, image: Any) -> None:
        report = self.report
        report.shares = self._complete
        report.blocks = len(self._blocks())
        report.passes = image.passes
        report.retries = self._sender.retries
        report.found_blocks = sum(len(share.blocks) for share in self._complete if share.rendered == 0 and share.blocks in self._found)
        attempts = self._folder.passes_of_attempts().values()
        report.repeated_passes = max(0, sum(attempts) - image.passes)
        report.repeated_blocks = max(0, sum(math.ceil(passes / self._block) for passes in attempts) - report.blocks)
        log.info(
            "%d passes in %d shares and %d rounds: %.1f s, %.1f s of it merging; %d blocks were found, "
            "%d blocks (%d passes) were computed more than once, %d retries",
            report.passes,
            len(report.shares),
            report.rounds,
            report.seconds,
            report.merge_seconds,
            report.found_blocks,
            report.repeated_blocks,
            report.repeated_passes,
            report.retries,
        )
