"""The cameras of a walkthrough: matrices, or a file of them."""

from __future__ import annotations

import contextlib
import json
import os
import tempfile
from collections.abc import Iterator
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from . import _native
from ._options import words
from .errors import UsageError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

#: Matrices from the camera to the world, (n, 4, 4), or a JSON file of them. As in Mitsuba, a camera looks along +z, with +y up and
#: +x to the left.
Cameras: TypeAlias = "ArrayLike | str | os.PathLike[str]"


def camera_matrices(cameras: Cameras) -> np.ndarray:
    """The matrices, (n, 4, 4). Raises UsageError, SceneError or FileError."""
    if isinstance(cameras, (str, os.PathLike)):
        return np.array(_native.read_cameras(os.fspath(cameras)))
    try:
        matrices = np.asarray(cameras, np.float64)
        if matrices.ndim == 2 and matrices.shape[1] == 16:
            matrices = matrices.reshape(-1, 4, 4)
    except (TypeError, ValueError):
        raise UsageError("cameras: found no array of numbers, expected matrices (n, 4, 4)") from None
    if matrices.ndim != 3 or matrices.shape[1:] != (4, 4) or len(matrices) == 0:
        raise UsageError(f"cameras: found an array {matrices.shape}, expected matrices (n, 4, 4)")
    return matrices


@contextlib.contextmanager
def frame_words(cameras: Cameras | None, frame: int | None) -> Iterator[tuple[list[str], bool]]:
    """The words of a frame, and whether the files that they name stay when this context ends. Raises UsageError."""
    if cameras is not None and frame is None:
        raise UsageError("cameras: found no frame", suggestion="give frame, or render all by `manylight.frames`")
    with _camera_file(cameras) as path:
        yield words({"cameras": path, "frames": frame}), cameras is None or isinstance(cameras, (str, os.PathLike))


@contextlib.contextmanager
def _camera_file(cameras: Cameras | None) -> Iterator[str | None]:
    if cameras is None or isinstance(cameras, (str, os.PathLike)):
        yield None if cameras is None else os.fspath(cameras)
        return
    matrices = camera_matrices(cameras)
    with tempfile.TemporaryDirectory(prefix="manylight-") as folder:
        path = os.path.join(folder, "cameras.json")
        with open(path, "w", encoding="utf-8") as file:
            json.dump(matrices.tolist(), file)
        yield path
