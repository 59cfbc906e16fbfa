"""Shares of a render: runs of whole blocks of passes. Pure functions.

A block is `block` passes, counted from 0. A share is a ``range`` of blocks, which one task renders to one part file.
"""

import math
import re
from collections.abc import Iterable

#: Most blocks in a share, unless ``shares`` says otherwise. A share holds the sums of all its blocks in memory.
MOST_BLOCKS = 4
#: Shares per worker, so that a slow worker does not delay the end by more than a part of its work.
SHARES_PER_WORKER = 4

_PART = re.compile(r"blocks-(\d+)-(\d+)\.part")


def part_name(blocks: range) -> str:
    """Name of the part file of a share: its first block, and the block after its last."""
    return f"blocks-{blocks.start:05}-{blocks.stop:05}.part"


def blocks_of(name: str) -> range | None:
    """The blocks of a part file by its name, or None if the name is another's."""
    match = _PART.fullmatch(name)
    if match is None or int(match[1]) >= int(match[2]):
        return None
    return range(int(match[1]), int(match[2]))


def disjoint(found: Iterable[range]) -> list[range]:
    """Of the shares found, those that do not overlap one before them, in the order of their blocks."""
    kept: list[range] = []
    for blocks in sorted(found, key=lambda blocks: (blocks.start, -blocks.stop)):
        if not kept or blocks.start >= kept[-1].stop:
            kept.append(blocks)
    return kept


def gaps(count: int, existing: Iterable[range]) -> list[range]:
    """The runs of blocks below ``count`` that no share in ``existing`` has; ``existing`` is in order."""
    missing, start = [], 0
    for blocks in [*existing, range(count, count)]:
        if start < min(blocks.start, count):
            missing.append(range(start, min(blocks.start, count)))
        start = max(start, blocks.stop)
    return missing


def share_count(blocks: int, workers: int) -> int:
    """Number of shares for ``blocks`` blocks on ``workers`` workers. See the constants of this module."""
    return min(blocks, max(SHARES_PER_WORKER * workers, math.ceil(blocks / MOST_BLOCKS)))


def cut(runs: Iterable[range], shares: int) -> list[range]:
    """Cuts runs of blocks into about `shares` shares; exactly this number for one run.

    The shares of a run differ by at most one block. The larger ones are first, so that workers end at the same time.
    """
    runs = list(runs)
    blocks = sum(len(run) for run in runs)
    pieces = []
    for run in runs:
        count = max(1, min(len(run), round(shares * len(run) / blocks)))
        size, larger = divmod(len(run), count)
        start = run.start
        for k in range(count):
            stop = start + size + (k < larger)
            pieces.append(range(start, stop))
            start = stop
    return pieces
