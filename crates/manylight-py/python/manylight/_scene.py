"""Scenes from files and from dictionaries."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from . import _native
from ._cameras import Cameras, frame_words
from ._dictionary import written
from ._options import default, render_words, words
from .errors import Error

if TYPE_CHECKING:
    from ._native import Image

__all__ = ["Scene", "load_dict", "load_file"]


class Scene:
    """A loaded scene, from `load_file` or `load_dict`.

    The first render builds it: acceleration structures, emitters, materials. Further renders use them, with any camera and film.
    A scene is pickled by its file names or its dictionary; the other process loads it again.
    """

    def __init__(self, native: _native.Scene, source: tuple[str, Any, dict[str, Any]], warnings: list[str] | None = None) -> None:
        self._native = native
        self._source = source
        self._warnings = native.warnings if warnings is None else warnings

    @property
    def source(self) -> Any:
        """The path or the dictionary that the scene was loaded from."""
        return self._source[1]

    @property
    def options(self) -> dict[str, Any]:
        """Options and parameters that the scene was loaded with."""
        return dict(self._source[2])

    @property
    def digest(self) -> str:
        """SHA-256 over all files of the scene, in hexadecimal digits. Parts of a render are merged if it agrees."""
        return self._native.digest

    @property
    def warnings(self) -> list[str]:
        """Unsupported or suspicious features of the scene."""
        return list(self._warnings)

    @property
    def cameras(self) -> list[str]:
        """Names of the cameras, in the order of their indices; a name may be empty."""
        return self._native.cameras

    @property
    def frame_counts(self) -> list[int]:
        """Number of frames of each camera: 0 for one that stands still."""
        return self._native.frame_counts

    def passes(
        self,
        method: str = default("method"),
        *,
        cameras: Cameras | None = None,
        frame: int | None = None,
        **options: Any,
    ) -> Iterator[Image]:
        """Renders the scene, and returns an iterator over the images after each pass.

        The options are those of `manylight.render`, without ``denoise`` and ``progress``. A further pass is rendered while the program
        looks at an image. Leaving the loop stops the render.

            for image in scene.passes(passes=64):
                if image.relative_error < 0.02:
                    break
        """
        with frame_words(cameras, frame) as (of_frame, files_stay):
            return _native.passes(self._native, render_words({"method": method, **options}) + of_frame, files_stay=files_stay)

    def __reduce__(self) -> tuple:
        return _load_again, self._source

    def __repr__(self) -> str:
        name = self.source if self._source[0] == "file" else "dictionary"
        return f"<manylight.Scene {name}>"


def _load_again(kind: str, source: Any, options: dict[str, Any]) -> Scene:
    return load_file(source, **options) if kind == "file" else load_dict(source, **options)


def load_file(
    path: str | os.PathLike[str],
    *,
    strict: bool = False,
    light_units: str | None = None,
    environment: str | os.PathLike[str] | None = None,
    environment_scale: float | None = None,
    variant: str | None = None,
    fps: float | None = None,
    **defines: Any,
) -> Scene:
    """Loads a scene: Mitsuba XML, PBRT, or glTF 2.0.

    Args:
        path: The scene file.
        strict: Whether unsupported features of the scene are errors.
        light_units: Units of the lights of a glTF scene: ``"W"``, ``"lm"`` or ``"raw"``, as ``--light-units`` of the command.
        environment: Environment of a glTF scene: an equirectangular image (exr or hdr), or ``"white"`` for a radiance of 1.
        environment_scale: Factor of the radiance of this environment.
        variant: Material variant of a glTF scene.
        fps: Frames per second of a camera that moves in the scene.
        **defines: Values of ``$name`` parameters of a Mitsuba scene.

    Raises:
        SceneError: The scene is invalid. The error has file, line and column.
        FileError: A file cannot be read.
        UsageError: An option does not fit the format of the scene.
    """
    path = os.path.abspath(os.fspath(path))
    options = {
        "strict": strict,
        "light_units": light_units,
        "environment": environment,
        "environment_scale": environment_scale,
        "variant": variant,
        "fps": fps,
    }
    command = [path, *words(options)]
    for name, value in defines.items():
        command.append(f"-D{name}={_define(value)}")
    given = {name: value for name, value in options.items() if value}
    return Scene(_native.load(command), ("file", path, {**given, **defines}))


def _define(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def load_dict(scene: Mapping[str, Any], *, strict: bool = False) -> Scene:
    """Loads a scene from a dictionary, as Mitsuba's ``load_dict`` takes it.

    Each plugin is a dictionary with its name as ``"type"``; the other entries are its parameters and children. Values are numbers, text,
    booleans, sequences of three numbers (points and vectors), 4x4 matrices (transforms), nested dictionaries, and
    ``{"type": "ref", "id": ...}``. Relative file names belong to the current folder.

    Beyond Mitsuba, arrays may stand for files:

    * a shape ``{"type": "mesh", "vertices": (n, 3), "faces": (m, 3)}``, with optional ``"normals"`` (n, 3) and ``"uvs"`` (n, 2);
    * a texture ``{"type": "bitmap", "data": (height, width, 3)}``, and an emitter ``{"type": "envmap", "data": ...}``, with linear values.

    Args:
        scene: The dictionary, with ``"type": "scene"``.
        strict: Whether unsupported features of the scene are errors.

    Raises:
        SceneError: The scene is invalid. `Error.key` has the keys of the entry.
        TypeError: A value has no meaning in a scene.
    """
    with written(scene) as file:
        try:
            native = _native.load([file.path, *words({"strict": strict})], label="dictionary")
        except Error as error:
            raise file.located(error) from None
        warnings = [file.warning(text) for text in native.warnings]
    return Scene(native, ("dict", scene, {"strict": strict} if strict else {}), warnings)
