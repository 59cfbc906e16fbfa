"""The workers of a Dask client: which of them may take shares, and what is done when the scheduler is lost."""

import logging
import time
from collections.abc import Callable, Mapping
from concurrent.futures import CancelledError
from typing import Any

import distributed
import manylight as ml

from .folder import Folder
from .worker import RESOURCE, Admission, identity, probe

log = logging.getLogger("manylight.distributed")

#: Seconds between two looks at the state of the cluster, at least.
_LOOK_EVERY = 1.0
#: Looks take at most this fraction of the time of the driver; they are long for a thousand workers.
_LOOK_SHARE = 0.02
#: Seconds for which a worker is asked again whose connection was closed before it answered. Workers leave and come back after the
#: loss of a scheduler.
_ANSWER_WITHIN = 10.0
#: Seconds between two warnings that there is no worker.
_WARN_EVERY = 30.0
#: What a call to a scheduler raises that is gone.
GONE = (OSError, TimeoutError, CancelledError)


class Cluster:
    """The workers of a client, for one render. `hear` gets the messages of the workers, on another thread."""

    def __init__(self, client: distributed.Client, folder: Folder, topic: str, hear: Callable[[Any], None]):
        self.client = client
        self.topic = topic
        #: Workers that take shares, at the last look.
        self.workers = 0
        #: Keys of the tasks that the scheduler has sent to a worker, at the last look.
        self.assigned: set[str] = set()
        self._folder = folder
        self._hear = hear
        self._next_look = float("-inf")
        self._warned = time.monotonic()
        self._admit()

    def _admit(self) -> None:
        """Checks all workers, and lets them take shares. Again for a scheduler that was started anew."""
        folder = str(self._folder.path)
        expected = check_workers(self._answers(folder), self._folder)
        self._folder.claim("workers", expected)
        self._scheduler = self._scheduler_id()
        self.client.register_plugin(Admission(folder, expected))
        self.client.subscribe_topic(self.topic, self._hear)
        self._next_look = float("-inf")
        self.look()

    def _answers(self, folder: str) -> dict[str, Any]:
        """What the workers answer to `probe`, at least one. A worker that leaves meanwhile is asked again, if it comes back."""
        give_up = time.monotonic() + _ANSWER_WITHIN
        while True:
            found = self.client.run(probe, folder, on_error="return")
            has_left = any(isinstance(answer, GONE) for answer in found.values())
            if found and (not has_left or time.monotonic() > give_up):
                return found
            if not found:
                self._warn_of_no_workers()
            time.sleep(_LOOK_EVERY)

    def _scheduler_id(self) -> str:
        return self.client.scheduler_info(n_workers=0)["id"]

    def look(self) -> bool:
        """Looks at the workers, if the last look was some time ago. Returns whether it did."""
        start = time.monotonic()
        if start < self._next_look:
            return False
        try:
            workers = self.client.scheduler_info(n_workers=-1)["workers"].values()
            self.workers = sum(1 for worker in workers if worker["resources"].get(RESOURCE))
            self.assigned = {key for keys in self.client.processing().values() for key in keys}
        except GONE:
            self.workers = 0
        end = time.monotonic()
        self._next_look = end + max(_LOOK_EVERY, (end - start) / _LOOK_SHARE)
        if self.workers > 0:
            self._warned = end
        else:
            self._warn_of_no_workers()
        return True

    def _warn_of_no_workers(self) -> None:
        if time.monotonic() - self._warned >= _WARN_EVERY:
            self._warned = time.monotonic()
            log.warning("no worker takes shares; the render goes on when one comes")

    def recover(self) -> None:
        """After a task was lost: waits until the client has found a scheduler again, and its workers."""
        try:
            if self.client.status == "running" and self._scheduler_id() == self._scheduler:
                return
        except GONE:
            pass
        log.warning("the connection to the scheduler is lost; waiting for a new one")
        while True:
            while self.client.status == "connecting":
                time.sleep(0.1)
            if self.client.status != "running":
                raise ml.Error(
                    f"the scheduler of the Dask client is gone; {self._folder.path} has {len(self._folder.found())} part files",
                    suggestion="start the scheduler, and render again with the same folder",
                )
            try:
                self._admit()
                return
            except GONE as error:
                if isinstance(error, ml.Error):
                    raise
                time.sleep(0.1)

    def close(self) -> None:
        """Takes back what the render has told the scheduler."""
        if self.client.status == "running":
            try:
                self.client.unsubscribe_topic(self.topic)
                self.client.unregister_worker_plugin(Admission.name_for(self._folder.path))
            except (*GONE, ValueError) as error:
                log.debug("closing: %s", error)


def check_workers(found: Mapping[str, Any], folder: Folder) -> dict[str, str]:
    """Compares what the workers have answered, by address. Returns what all have in common.

    Raises UsageError, with all workers that differ.
    """
    for address, answer in found.items():
        if isinstance(answer, BaseException):
            raise _unanswered(address, answer)
    # This process merges: it reads parts of its version. Its instruction set does not matter, as it adds sums only.
    here = [("this process", ml.__version__)]
    workers = {f"{address} on {answer['host']}": answer for address, answer in found.items()}
    _check_same("versions of manylight", [*((name, answer["version"]) for name, answer in workers.items()), *here])
    _check_same("instruction sets", [(name, answer["instruction_set"]) for name, answer in workers.items()])
    blind = [name for name, answer in workers.items() if not answer["sees_folder"]]
    if blind:
        raise ml.UsageError(
            f"folder: the workers {', '.join(blind)} do not see {folder.path}",
            suggestion="give a folder of a file system that all machines share, at the same path",
        )
    some = next(iter(found.values()))
    return {key: some[key] for key in identity()}


def _unanswered(address: str, error: BaseException) -> BaseException:
    """What is raised for a worker that could not answer."""
    # Dask reports a function that cannot be imported as an Exception with the text of the ImportError.
    if isinstance(error, ImportError) or "No module named" in str(error):
        return ml.UsageError(
            f"the worker {address} cannot import manylight.distributed: {error}",
            suggestion="install the package manylight[distributed] there, in the same version",
        )
    return error


def _check_same(what: str, values: list[tuple[str, str]]) -> None:
    names: dict[str, list[str]] = {}
    for name, value in values:
        names.setdefault(value, []).append(name)
    if len(names) > 1:
        listed = "; ".join(f"{value}: {', '.join(where)}" for value, where in sorted(names.items()))
        raise ml.UsageError(
            f"the workers have different {what}: {listed}",
            suggestion="parts of different ones cannot be merged; use workers with the same",
        )
