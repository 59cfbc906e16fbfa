"""How many blocks of passes the next round of an open-ended render has. Pure functions.

A render with ``time=`` or ``target_error=`` goes in rounds, because both depend on all passes.

* The first round has one block per worker.
* A round at most doubles the blocks, because what the first rounds measure is uncertain.
* ``time``: a round has the blocks for which the time is left, by the seconds that a worker took for a block in the
  last round, and by the seconds of merging. The render ends when the next wave of blocks (one per worker) would end
  farther beyond the time than the present moment is before it.
* ``target_error``: the relative error falls as one over the square root of the passes, which tells the number of
  blocks. A round adds at least an eighth of the blocks, so that all merges together read at most about nine times
  the data of the last one, and mostly two or three times.
* Rounds are whole waves.
"""

import math
from dataclasses import dataclass

#: Least growth of a round with a target error, as a fraction of the blocks so far.
LEAST_GROWTH = 1 / 8


@dataclass(frozen=True)
class Progress:
    """What is known after a round."""

    blocks: int  #: blocks of passes that exist
    workers: int  #: workers now
    seconds: float  #: seconds since the start of the first round
    block_seconds: float | None  #: seconds of a worker per block in the last round; None if it rendered none
    merge_seconds: float  #: seconds of merging per block
    relative_error: float | None  #: of the image of all blocks; None if it is not known


def next_round(now: Progress, time: float | None, target_error: float | None) -> int:
    """Number of blocks of the next round; 0 if the render is at its end. ``time`` is in seconds."""
    wave = max(now.workers, 1)
    if now.blocks == 0:
        return wave
    more = max(now.blocks, wave)
    if target_error is not None:
        if now.relative_error is not None and now.relative_error <= target_error:
            return 0
        more = min(more, max(_missing(now, target_error), math.ceil(now.blocks * LEAST_GROWTH)))
    more = wave * math.ceil(more / wave)
    if time is not None:
        more = min(more, wave * _waves(now, time))
    return more


def _missing(now: Progress, target_error: float) -> int:
    """Blocks that are missing for an error, if the error falls as one over the square root of the passes."""
    if now.relative_error is None or not math.isfinite(now.relative_error):
        return now.blocks
    factor = (now.relative_error / target_error) ** 2
    # The doubling of rounds is the lower limit of the two; this one keeps the product finite.
    return math.ceil(now.blocks * min(factor - 1, 1e6))


def _waves(now: Progress, time: float) -> int:
    """Waves of blocks whose end is nearest to ``time``, with the merging after them."""
    left = time - now.seconds - now.merge_seconds * now.blocks
    if now.block_seconds is None:
        return 1 if left > 0 else 0
    wave_seconds = now.block_seconds + now.merge_seconds * max(now.workers, 1)
    return max(0, math.floor(left / max(wave_seconds, 1e-9) + 0.5))
