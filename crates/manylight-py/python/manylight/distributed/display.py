"""Shows how far a render on a cluster is: a bar, or calls of a function."""

import sys
import time
from collections.abc import Callable
from typing import Any

from tqdm import tqdm

from .worker import Share

ProgressOption = bool | Callable[[int, int | None, float], None]


class Display:
    """Counts passes of all shares.

    ``progress`` is True for a bar on standard error, False for nothing, or a function of the passes done, the passes in
    all (None if open-ended), and the seconds since the start. An exception in the function ends the render.
    """

    def __init__(self, progress: ProgressOption, passes: int | None, block: int):
        self._passes = passes
        self._block = block
        self._start = time.monotonic()
        self._complete = 0
        self._begun: dict[str, int] = {}
        self._largest: dict[str, int] = {}
        self._shares = 0
        self._note = ""
        self._told = -1
        self._function = progress if callable(progress) else None
        self._wants_bar = progress is True
        self._bar: Any = None

    def begin(self, key: str, blocks: range) -> None:
        """A share was sent."""
        self._begun[key] = 0
        self._largest[key] = self._passes_of(blocks)

    def hear(self, event: tuple[float, dict[str, Any]]) -> None:
        """A message of a worker: the passes of a share that it has rendered. Called on another thread."""
        _, message = event
        key = message["key"]
        if key in self._begun:
            self._begun[key] = min(message["passes"], self._largest[key])

    def drop(self, key: str) -> None:
        """An attempt at a share failed: its passes do not count."""
        self._begun.pop(key, None)

    def end(self, key: str, share: Share) -> None:
        """A share is complete."""
        self._begun.pop(key, None)
        self._complete += self._passes_of(share.blocks)
        self._shares += 1

    def note(self, note: str) -> None:
        """Says more about the state, such as the error after a round."""
        self._note = note

    def restart(self) -> None:
        """All shares are looked at again."""
        self._complete = 0
        self._shares = 0

    def show(self, workers: int) -> None:
        """Updates what is seen."""
        passes = self._complete + sum(list(self._begun.values()))
        if self._function is not None and passes != self._told:
            self._told = passes
            self._function(passes, self._passes, time.monotonic() - self._start)
        if self._wants_bar and self._bar is None:
            # Not before shares were sent: until then the workers are checked, which may fail.
            self._bar = tqdm(total=self._passes, unit="pass", file=sys.stderr, dynamic_ncols=True)
        if self._bar is not None:
            self._bar.n = passes
            note = f", {self._note}" if self._note else ""
            self._bar.set_postfix_str(f"{self._shares} shares, {workers} workers{note}")

    def close(self) -> None:
        """Ends the bar."""
        if self._bar is not None:
            self._bar.close()

    def _passes_of(self, blocks: range) -> int:
        passes = len(blocks) * self._block
        if self._passes is None:
            return passes
        return max(0, min(passes, self._passes - blocks.start * self._block))
