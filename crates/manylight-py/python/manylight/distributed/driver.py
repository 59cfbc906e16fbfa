"""The call that renders on a cluster."""

import contextlib
import os
import uuid
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import distributed
import manylight as ml
from manylight._options import default

from .cluster import Cluster
from .display import Display, ProgressOption
from .folder import Folder
from .job import Job, Report
from .sender import Sender
from .settings import Goal, check, given, goal_of
from .worker import SceneReference


def render(
    scene: ml.Scene | str | os.PathLike[str],
    *,
    client: distributed.Client | None = None,
    folder: str | os.PathLike[str] | None = None,
    passes: int | None = None,
    time: float | str | None = None,
    target_error: float | str | None = None,
    method: str = default("method"),
    block: int = default("block"),
    shares: int | None = None,
    retries: int = 2,
    progress: ProgressOption = True,
    report: Callable[[Report], object] | None = None,
    **options: Any,
) -> ml.Image:
    """Renders a scene on the workers of a Dask client.

    The image has the bits of one `manylight.render` with as many passes, the same settings, and the same instruction set.
    With Ctrl-C, the workers stop after their pass, and no image is returned.

    Args:
        scene: A scene, or the path of a scene file. Workers load it from the same path.
        client: A ``distributed.Client``. Default: the current one, or else this process with all processors.
        folder: Where the part files are, on a file system that all machines see at the same path. Parts that an earlier call with the same
            settings has left are used. The files are deleted after success. Default: a temporary folder, if all workers see it.
        passes: Samples per pixel in total. Default: as for `manylight.render`.
        time: Seconds, or text such as ``"10m"``. The render goes in rounds (`manylight.distributed.rounds`), and ends with the wave of
            blocks (one per worker) that ends closest to this time.
        target_error: Relative error of the image at which the render ends, after a round: a number, or text such as ``"2%"``.
        method: As for `manylight.render`.
        block: Passes of a block, a multiple of 8. Another block changes the rounding.
        shares: Shares of the render, or of a round, at most the number of blocks. Default: four per worker, and at least one per four
            blocks. A share is a task of Dask; its worker holds the sums of all its blocks in memory.
        retries: How often a share is sent again after a failure of the file system, or after Dask has given it up because its workers died
            (``distributed.scheduler.allowed-failures``).
        progress: Whether to show a progress bar; or a function that is called with the passes so far, the passes in total (None if another
            limit ends the render), and seconds. An exception of it ends the render.
        report: A function that is called at the end with a `Report` of shares, retries, and blocks that were rendered more than once.
        **options: As for `manylight.render`; ``threads`` is by default the number of threads of the worker.

    Raises:
        UsageError: A setting is wrong; the workers differ in version or instruction set, or do not see the folder; the folder has parts of
            another render.
        SceneError, FileError: As for `manylight.render`, from the workers.
        Error: The scheduler is gone, or workers died again and again in the same share.
    """
    goal = goal_of(passes, time, target_error)
    check(block, shares, retries, options)
    if not isinstance(scene, ml.Scene):
        scene = ml.load_file(scene)
    options = {"method": method, "block": block, **given(options)}
    description = {**render_description(scene, options), "passes": goal.passes}
    with connected(client) as client, opened(folder, description) as files:
        display = Display(progress, goal.passes, block)
        topic = f"manylight-{uuid.uuid4().hex[:12]}"
        cluster = Cluster(client, files, topic, display.hear)
        try:
            sender = Sender(cluster, files, SceneReference.of(scene), goal.passes, options, retries, display)
            job = Job(cluster, sender, files, goal, block, shares, display)
            image = job.run()
            if report is not None:
                report(job.report)
            return image
        finally:
            cluster.close()
            display.close()


def render_description(scene: ml.Scene, options: Mapping[str, Any]) -> dict[str, Any]:
    """What the files of one render have in common. The number of threads does not change the bits."""
    settings = {name: value for name, value in options.items() if name != "threads" and value is not None}
    return {"version": ml.__version__, "scene": scene.digest, "loading": scene.options, **settings}


@contextlib.contextmanager
def connected(client: distributed.Client | None) -> Iterator[distributed.Client]:
    """The client; the current one; or a worker in this process with all processors."""
    if client is None:
        with contextlib.suppress(ValueError):
            client = distributed.default_client()
    if client is None:
        with distributed.Client(
            n_workers=1, threads_per_worker=os.cpu_count(), processes=False, dashboard_address=":0", memory_limit=0
        ) as local:
            yield local
        return
    if client.asynchronous:
        raise ml.UsageError("client: found an asynchronous client, expected one that waits for results")
    if client.status != "running":
        raise ml.UsageError(f"client: found a client whose state is {client.status}, expected one that is connected")
    yield client


@contextlib.contextmanager
def opened(path: str | os.PathLike[str] | None, description: Mapping[str, Any]) -> Iterator[Folder]:
    """The folder; cleaned after success, and kept after a failure unless it is temporary."""
    folder = Folder(None if path is None else Path(path), description)
    try:
        yield folder
    except BaseException:
        if folder.temporary:
            folder.clean()
        raise
    folder.clean()
