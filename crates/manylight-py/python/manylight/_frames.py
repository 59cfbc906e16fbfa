"""Walkthroughs: pictures of many cameras with the same virtual lights."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from . import _native
from ._cameras import Cameras, camera_matrices
from ._options import default, is_given, render_words, with_options
from ._render import Progress, as_scene, rendered
from ._scene import Scene
from .errors import UsageError

if TYPE_CHECKING:
    from ._native import Image

__all__ = ["frame_numbers", "frames", "keeps_lights"]


@with_options
def frames(
    scene: Scene | str | os.PathLike[str],
    method: str = default("method"),
    *,
    cameras: Cameras | None = None,
    frames: Iterable[int] | None = None,
    progress: bool | Progress = False,
    **options: Any,
) -> Iterator[Image]:
    """Renders the frames of a walkthrough, and returns an iterator over their images. Frames have the bits of
    ``manylight render --cameras``.

    Photons and virtual lights are made once for the cameras of all frames, and kept in a temporary file. A method without virtual
    lights renders each frame alone.

        for number, image in enumerate(ml.frames(scene, cameras=matrices, passes=16), start=1):
            image.save(f"walk-{number:04}.exr")

    Args:
        scene: A scene, or the path of a scene file.
        method: As for `manylight.render`; ``"auto"`` is ``"rich-vpl"``.
        cameras: Matrices from the camera to the world, (n, 4, 4), or a JSON file of them. As in Mitsuba, a camera looks along +z, with
            +y up and +x to the left. Default: the camera of the scene, which then has to move.
        frames: Numbers of frames, counted from 1. Default: all. The lights serve all frames, also those that are not rendered.
        progress: As for `manylight.render`, for each frame.
        **options: As for `manylight.render`, without limits by time or error. With ``lights_out``, the file of lights stays.

    Raises:
        UsageError, SceneError, ComponentError: As for `manylight.render`.
    """
    scene = as_scene(scene)
    numbers = frame_numbers(scene, cameras, frames, options.get("sensor") or 0)
    keeps = not is_given(options.get("lights_in")) and keeps_lights(method, **options)
    with tempfile.TemporaryDirectory(prefix="manylight-") as folder:
        named = options.pop("lights_out", None) or None
        lights = named or (os.path.join(folder, "walk.lights") if keeps else None)
        files_stay = lights == named
        settings = {"method": method, **options}
        kept = {"lights_out": lights}
        for number in numbers:
            image = rendered(scene, {**settings, **kept}, cameras, number, progress, files_stay)
            yield image
            if image.interrupted:
                return
            if keeps:
                kept = {"lights_in": lights}


def frame_numbers(scene: Scene, cameras: Cameras | None, frames: Iterable[int] | None, sensor: int) -> list[int]:
    """Numbers of the frames that are asked for, by default of all. Raises UsageError if the camera stands still."""
    if frames is not None:
        return list(frames)
    if cameras is not None:
        count = len(camera_matrices(cameras))
    else:
        counts = scene.frame_counts
        count = counts[sensor] if 0 <= sensor < len(counts) else 0
    if count == 0:
        raise UsageError("the camera of the scene stands still", suggestion="give cameras, the matrices of the frames")
    return list(range(1, count + 1))


def keeps_lights(method: str, **options: Any) -> bool:
    """Whether a render with these options has virtual lights that ``lights_out`` can keep.

    Raises:
        UsageError: An option has a wrong value, or contradicts another.
    """
    return _native.keeps_lights(render_words({"method": method, **options}))
