"""Walkthroughs on a cluster: a task renders a frame to its image file, by virtual lights that one task has made."""

from __future__ import annotations

import contextlib
import os
import uuid
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import distributed
import manylight as ml
from manylight._cameras import Cameras, camera_matrices
from manylight._frames import frame_numbers
from manylight._native import frame_file
from manylight._options import default
from tqdm import tqdm

from .cluster import Cluster
from .driver import connected, opened, render_description
from .settings import check_retries, given, refuse
from .worker import RESOURCE, SceneReference, scene_of

#: Virtual lights of the walkthrough, in the folder of its frames until all are rendered.
_LIGHTS = "walk.lights"
#: Options that are of one picture, or of the calling process.
_NOT_OF_FRAMES = ("time", "target_error", "checkpoint", "checkpoint_every", "resume", "lights_out", "blocks")


@dataclass(frozen=True)
class FrameTask:
    """What a worker needs to render a frame."""

    scene: SceneReference
    frame: int  #: counted from 1
    file: str  #: path of the image file
    cameras: list | None  #: matrices of all frames
    options: Mapping[str, Any]  #: of `manylight.render`


def render_frames(
    scene: ml.Scene | str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    cameras: Cameras | None = None,
    frames: Iterable[int] | None = None,
    client: distributed.Client | None = None,
    method: str = default("method"),
    retries: int = 2,
    progress: bool = True,
    **options: Any,
) -> list[Path]:
    """Renders the frames of a walkthrough on the workers of a Dask client, to image files with the pixels of `manylight.frames`.

    The first task makes photons and virtual lights, and keeps them in the folder of the frames until all are rendered. Frames that have a
    file are not rendered again, so that the same call goes on after a failure.

    Args:
        scene: A scene, or the path of a scene file. Workers load it from the same path.
        output: Image files, such as ``"/shared/walk-####.exr"``: the number of the frame is in the place of the last ``#``. All machines
            see their folder at the same path.
        cameras: As for `manylight.frames`.
        frames: As for `manylight.frames`.
        client: A ``distributed.Client``. Default: the current one, or else this process with all processors.
        method: As for `manylight.frames`.
        retries: How often a frame is rendered again after its worker died or failed.
        progress: Whether to show a progress bar.
        **options: As for `manylight.frames`; ``threads`` is by default the number of threads of the worker.

    Returns:
        The files, in the order of the frames.

    Raises:
        UsageError: A setting is wrong; the workers differ in version or instruction set, or do not see the folder; the folder has frames
            of another walkthrough that was not completed.
        SceneError, FileError: As for `manylight.render`, from the workers.
    """
    check_retries(retries)
    refuse(options, _NOT_OF_FRAMES, "frames")
    if not isinstance(scene, ml.Scene):
        scene = ml.load_file(scene)
    output = os.path.abspath(os.fspath(output))
    numbers = frame_numbers(scene, cameras, frames, options.get("sensor") or 0)
    files = {number: Path(frame_file(output, number)) for number in numbers}
    options = {"method": method, **given(options)}
    makes_lights = "lights_in" not in options and ml.keeps_lights(**options)
    matrices = None if cameras is None else camera_matrices(cameras).tolist()
    description = {**render_description(scene, options), "cameras": matrices}
    with connected(client) as client, opened(os.path.dirname(output), description) as folder:
        cluster = Cluster(client, folder, f"manylight-{uuid.uuid4().hex[:12]}", lambda _: None)
        lights = folder.path / _LIGHTS
        with contextlib.closing(cluster), tqdm(total=len(files), unit="frame", disable=not progress) as bar:
            missing = [number for number, file in files.items() if not file.exists()]
            bar.update(len(files) - len(missing))
            reference = SceneReference.of(scene)

            def send(frame: int, kept: Mapping[str, str]) -> distributed.Future:
                task = FrameTask(reference, frame, str(files[frame]), matrices, {**options, **kept})
                key = f"frame-{frame:05}-{uuid.uuid4().hex[:8]}"
                return client.submit(render_frame, task, key=key, resources={RESOURCE: 1}, retries=retries, pure=False)

            kept: dict[str, str] = {}
            if makes_lights and missing:
                if not lights.exists():
                    send(missing.pop(0), {"lights_out": str(lights)}).result()
                    bar.update()
                kept = {"lights_in": str(lights)}
            futures = [send(frame, kept) for frame in missing]
            try:
                for future in distributed.as_completed(futures):
                    future.result()
                    bar.update()
            finally:
                client.cancel([future for future in futures if not future.done()])
        lights.unlink(missing_ok=True)
    folder.wait_for(files.values())
    return list(files.values())


def render_frame(task: FrameTask) -> str:
    """Renders a frame to its file. Raises what `manylight.render` raises."""
    worker = distributed.get_worker()
    options = {"threads": worker.state.nthreads, **task.options}
    image = ml.render(scene_of(task.scene), cameras=task.cameras, frame=task.frame, **options)
    image.save(task.file)
    return task.file
