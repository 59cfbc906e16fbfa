"""Sends shares to the workers, again if they are lost, and brings back which part files were written."""

import queue
import time
import uuid
from collections import deque
from collections.abc import Iterable, Mapping
from concurrent.futures import CancelledError
from dataclasses import dataclass
from typing import Any

import distributed
import manylight as ml

from .cluster import GONE, Cluster, log
from .display import Display
from .folder import Folder
from .worker import RESOURCE, Cancelled, SceneReference, Share, ShareTask, render_share

#: Seconds between two updates of the display.
_TICK = 0.25
#: Seconds before the first repetition of a share; doubled for each further one.
_FIRST_PAUSE = 0.5
#: Failures that another attempt may not meet: workers that died, and the file system.
_PASSING = (distributed.scheduler.KilledWorker, OSError, TimeoutError)


@dataclass(frozen=True)
class Piece:
    """A share that is to be rendered."""

    name: str
    blocks: range
    failures: int = 0
    not_before: float = 0.0  #: by the monotonic clock, in seconds


class Sender:
    """Sends the shares of one render."""

    def __init__(
        self,
        cluster: Cluster,
        folder: Folder,
        scene: SceneReference,
        passes: int | None,
        options: Mapping[str, Any],
        retries: int,
        display: Display,
    ):
        self.retries = 0  #: shares that failed and were sent again
        self._cluster = cluster
        self._folder = folder
        self._scene = scene
        self._passes = passes
        self._options = options
        self._most_retries = retries
        self._display = display
        self._finished: queue.SimpleQueue[distributed.Future] = queue.SimpleQueue()
        self._waiting: deque[Piece] = deque()
        self._running: dict[distributed.Future, Piece] = {}
        self._unassigned: set[distributed.Future] = set()

    def run(self, shares: Iterable[range]) -> list[Share]:
        """Renders shares, and returns them in the order of their blocks.

        There are as many tasks as workers: Dask counts the death of a worker against all tasks that were sent to it,
        also against those that it had not begun.
        """
        shares = list(shares)
        digits = max(3, len(str(len(shares))))
        names = (f"share-{k:0{digits}}-of-{len(shares):0{digits}}" for k in range(1, len(shares) + 1))
        self._waiting = deque(map(Piece, names, shares))
        done: list[Share] = []
        try:
            while self._waiting or self._running:
                self._send_waiting()
                future = self._next_finished()
                if future in self._running:
                    share = self._take(future, self._running.pop(future))
                    done += [share] if share is not None else []
                if self._cluster.look():
                    self._free_unassigned()
                self._display.show(self._cluster.workers)
        finally:
            self._cancel()
        return sorted(done, key=lambda share: share.blocks.start)

    def _send_waiting(self) -> None:
        while self._waiting and len(self._running) < self._cluster.workers:
            if self._waiting[0].not_before > time.monotonic():
                return
            if self._cluster.client.status != "running":
                self._cluster.recover()
            self._send(self._waiting.popleft())

    def _send(self, piece: Piece) -> None:
        attempt = f"-retry-{piece.failures}" if piece.failures else ""
        # Keys are unique on a scheduler: two renders may run there.
        key = f"{piece.name}{attempt}-{uuid.uuid4().hex[:8]}"
        part, topic = str(self._folder.part(piece.blocks)), self._cluster.topic
        task = ShareTask(self._scene, part, piece.blocks, self._passes, self._options, topic)
        self._display.begin(key, piece.blocks)
        future = self._cluster.client.submit(render_share, task, piece.name, key=key, resources={RESOURCE: 1}, pure=False)
        self._running[future] = piece
        future.add_done_callback(self._finished.put)

    def _next_finished(self) -> distributed.Future | None:
        try:
            return self._finished.get(timeout=_TICK)
        except queue.Empty:
            return None

    def _take(self, future: distributed.Future, piece: Piece) -> Share | None:
        """The result of a task that ended. If it failed, the share waits to be sent once more."""
        try:
            share = future.result()
        except (CancelledError, Cancelled):
            self._take_back(future, piece)
            return None
        except _PASSING as error:
            if self._cluster.client.status != "running":
                self._take_back(future, piece)
                return None
            self._display.drop(str(future.key))
            if piece.failures >= self._most_retries:
                raise _final(piece, error) from error
            self.retries += 1
            log.warning("%s failed, and is rendered again: %s", piece.name, error)
            # A file system may need a moment. The others go first.
            later = time.monotonic() + _FIRST_PAUSE * 2**piece.failures
            self._waiting.append(Piece(piece.name, piece.blocks, piece.failures + 1, later))
            return None
        finally:
            future.release()
        self._display.end(str(future.key), share)
        return share

    def _take_back(self, future: distributed.Future, piece: Piece) -> None:
        """The scheduler is gone, or the worker was told to stop. The folder has what was complete."""
        self._display.drop(str(future.key))
        self._waiting.appendleft(piece)
        self._cluster.recover()

    def _free_unassigned(self) -> None:
        """Sends tasks again that no worker has: Dask does not look again at a task that found no worker with the
        resource, when a worker that came later has got it."""
        assigned = self._cluster.assigned
        unassigned = {future for future in self._running if future.status == "pending" and future.key not in assigned}
        # A task may be on its way. So only those that were seen twice.
        for future in unassigned & self._unassigned if self._cluster.workers else ():
            piece = self._running.pop(future)
            self._display.drop(str(future.key))
            self._waiting.appendleft(piece)
            future.cancel()
        self._unassigned = unassigned

    def _cancel(self) -> None:
        """Cancels what still runs: the tasks end after their pass."""
        futures, self._running, self._waiting = list(self._running), {}, deque()
        client = self._cluster.client
        if futures and client.status == "running":
            try:
                client.cancel(futures, force=True)
            except GONE as error:
                log.warning("shares could not be cancelled: %s", error)


def _final(piece: Piece, error: Exception) -> Exception:
    """The exception after the last attempt at a share."""
    attempts = piece.failures + 1
    if isinstance(error, distributed.scheduler.KilledWorker):
        deaths = attempts * (error.allowed_failures + 1)
        return ml.Error(
            f"{piece.name}: {deaths} workers died while they rendered it, the last at {error.last_worker.address}",
            suggestion="look at the log of the worker; if it lacks memory, give more shares, or a larger block",
        )
    if hasattr(error, "add_note"):
        error.add_note(f"{piece.name} failed {attempts} times")
    return error
