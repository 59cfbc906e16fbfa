"""What runs on the workers: a check before the start, and the task that renders a share."""

import hashlib
import os
import pickle
import socket
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import distributed
import manylight as ml

from .folder import Attempt

#: Each worker has one unit of this resource, and a share takes it: one share at a time has all threads of the worker.
RESOURCE = "manylight"
#: Least seconds between two messages about the progress of a share.
_MESSAGE_INTERVAL = 0.5


@dataclass(frozen=True)
class SceneReference:
    """A scene that each process loads once."""

    digest: str  #: SHA-256 of the scene's files
    pickled: bytes  #: where it was loaded from, with which parameters

    @classmethod
    def of(cls, scene: Any) -> "SceneReference":
        return cls(scene.digest, pickle.dumps(scene))


@dataclass(frozen=True)
class ShareTask:
    """What a worker needs to render a share."""

    scene: SceneReference
    part: str  #: path of the part file
    blocks: range
    passes: int | None  #: of the whole render; None if it is open-ended
    options: Mapping[str, Any]  #: of `render_part`
    topic: str  #: of messages about the progress


@dataclass(frozen=True)
class Share:
    """A share that is complete."""

    name: str
    blocks: range
    path: str
    sha256: str  #: of the part file
    seconds: float  #: of rendering and writing, without loading the scene; 0 if the part existed
    rendered: int  #: blocks that this task has rendered: 0 if the part existed
    worker: str  #: address


class Cancelled(Exception):
    """Nobody waits for this share any more."""


def identity() -> dict[str, str]:
    """What must agree between workers for equal bits."""
    return {"version": ml.__version__, "instruction_set": ml.instruction_set}


def probe(folder: str) -> dict[str, Any]:
    """What the driver asks each worker before it sends shares."""
    return {
        **identity(),
        "host": socket.gethostname(),
        "sees_folder": os.path.isfile(os.path.join(folder, "render.json")),
    }


class Admission(distributed.WorkerPlugin):
    """Gives a worker the resource that shares take, also a worker that comes later. One that would spoil the bits, or
    does not see the folder, gets none, and so no share."""

    def __init__(self, folder: str, expected: Mapping[str, str]):
        self.name = self.name_for(folder)
        self._folder = folder
        self._expected = dict(expected)

    @staticmethod
    def name_for(folder: Any) -> str:
        """Name of the plugin of a render. Registering it again replaces it."""
        return f"manylight-{folder}"

    async def setup(self, worker: distributed.Worker) -> None:
        found = probe(self._folder)
        if found["sees_folder"] and all(found[key] == value for key, value in self._expected.items()):
            await worker.set_resources(**{RESOURCE: 1})


def render_share(task: ShareTask, name: str) -> Share:
    """Renders a share to its part file, unless a complete part exists. Raises what `render_part` raises."""
    worker = distributed.get_worker()
    part = Path(task.part)
    existing = checksum(part)
    if existing is not None:
        return Share(name, task.blocks, task.part, existing, 0.0, 0, worker.address)
    scene = scene_of(task.scene)
    options = {"threads": worker.state.nthreads, **task.options}
    watch = _Watch(worker, Attempt(part), task.topic)
    start = time.monotonic()
    ml.render_part(scene, task.part, blocks=task.blocks, passes=task.passes, progress=watch, **options)
    watch.attempt.count(watch.passes, last=True)
    seconds = time.monotonic() - start
    return Share(name, task.blocks, task.part, sha256(part), seconds, len(task.blocks), worker.address)


def checksum(part: Path) -> str | None:
    """SHA-256 of a complete part file. None if there is none; a damaged one is deleted."""
    try:
        ml.part_info(str(part))
    except ml.FileError:
        try:
            part.unlink(missing_ok=True)
        except OSError as error:
            raise ml.FileError(error.strerror or str(error), file=str(part)) from error
        return None
    return sha256(part)


def sha256(path: Path) -> str:
    """SHA-256 of a file, in hexadecimal digits."""
    digest = hashlib.sha256()
    with open(path, "rb") as file:
        while chunk := file.read(1 << 20):
            digest.update(chunk)
    return digest.hexdigest()


class _Watch:
    """Called after each pass: tells the driver, counts, and stops a share that nobody waits for."""

    def __init__(self, worker: distributed.Worker, attempt: Attempt, topic: str):
        self.attempt = attempt
        self.passes = 0
        self._worker = worker
        self._key = worker.get_current_task()
        self._topic = topic
        self._told = float("-inf")

    def __call__(self, passes: int, _total: int | None, _seconds: float) -> None:
        self.passes = passes
        self.attempt.count(passes)
        task = self._worker.state.tasks.get(self._key)
        closing = self._worker.status not in (distributed.Status.running, distributed.Status.paused)
        if closing or task is None or task.state == "cancelled":
            self.attempt.count(passes, last=True)
            raise Cancelled(f"{self._key} was cancelled")
        now = time.monotonic()
        if now - self._told >= _MESSAGE_INTERVAL:
            self._told = now
            self._worker.log_event(self._topic, {"key": self._key, "passes": passes})


_loading = threading.Lock()
#: The scene of the last share of this process: a farm renders many shares of one scene.
_last: tuple[SceneReference, Any] | None = None


def scene_of(reference: SceneReference) -> Any:
    """The scene, loaded once."""
    global _last
    with _loading:
        if _last is None or _last[0] != reference:
            scene = pickle.loads(reference.pickled)
            if scene.digest != reference.digest:
                raise ml.UsageError(
                    f"the files of the scene differ between machines: their SHA-256 is {scene.digest} on "
                    f"{socket.gethostname()}, and {reference.digest} where the render was started"
                )
            _last = (reference, scene)
        return _last[1]
