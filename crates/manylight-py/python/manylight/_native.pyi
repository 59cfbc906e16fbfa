"""Types of the native module."""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, final

import numpy as np
from numpy.typing import DTypeLike, NDArray

__version__: str
instruction_set: str

@final
class Scene:
    @property
    def digest(self) -> str: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def cameras(self) -> list[str]: ...
    @property
    def frame_counts(self) -> list[int]: ...

@final
class Image:
    """A picture: layers of linear values, and metadata. Arrays are read-only, and share the memory of the image."""

    @property
    def width(self) -> int:
        """Width in pixels."""
    @property
    def height(self) -> int:
        """Height in pixels."""
    @property
    def passes(self) -> int:
        """Number of passes; 0 if it is unknown."""
    @property
    def relative_error(self) -> float:
        """Upper bound of the relative error, with 95 % confidence; infinite if it is unknown."""
    @property
    def interrupted(self) -> bool:
        """Whether the render was interrupted."""
    @property
    def layers(self) -> dict[str, NDArray[np.float32]]:
        """Arrays by the names of the layers: ``beauty`` is the picture.

        Shape (height, width, channels), or (height, width) for one channel.
        """
    @property
    def variance(self) -> NDArray[np.float32] | None:
        """Variance of the mean of each value of the picture, (height, width, 3).

        Infinite with fewer than two passes; None if it is unknown.
        """
    @property
    def metadata(self) -> dict[str, str]:
        """What is known of the render: settings, times, the command that repeats it."""
    def relight(self, groups: Mapping[str, float | Sequence[float]]) -> Image:
        """The picture with other factors on the light of its light groups, without a render.

        The picture must be one with ``light_groups=True``. Layers that depend on the light in another way are left out: the terms, and
        the denoised image. The variance is an estimate, exact for equal factors and for one group alone.

        Args:
            groups: A factor, or three for red, green and blue, by the name of the group. Other groups stay as they are.

        Raises:
            UsageError: The picture has no light groups, or none of a name.
        """
    def save(self, path: str | os.PathLike[str], *, exposure: float = 0.0, view: str = ...) -> None:
        """Writes the image to a file: exr (all layers, linear), png or jpg (sRGB), hdr, pfm.

        Args:
            path: The file. It is written whole or not at all.
            exposure: Exposure of png and jpg files in stops.
            view: Tone curve of png and jpg files: ``"standard"``, ``"neutral"`` or ``"agx"``.
        """
    def png(self, *, exposure: float = 0.0, view: str = ...) -> bytes:
        """The picture as the bytes of a PNG file."""
    def _repr_png_(self) -> bytes: ...
    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]: ...

@final
class Passes(Iterator[Image]):
    """An iterator over the images after each pass."""

    def __iter__(self) -> Passes: ...
    def __next__(self) -> Image: ...
    def close(self) -> None:
        """Stops the render. Further images are not made."""

def load(words: list[str], label: str | None = None) -> Scene: ...
def read_cameras(path: str) -> list[list[list[float]]]: ...
def plugins() -> dict[str, list[str]]: ...
def render(
    scene: Scene,
    words: list[str],
    progress: Callable[[int, int | None, float], object] | None = None,
    files_stay: bool = True,
) -> Image: ...
def passes(scene: Scene, words: list[str], files_stay: bool = True) -> Passes: ...
def render_part(
    scene: Scene,
    words: list[str],
    path: str,
    share: tuple[int, int] | None = None,
    blocks: tuple[int, int] | None = None,
    open: bool = False,
    progress: Callable[[int, int | None, float], object] | None = None,
) -> None: ...
def merge(parts: list[str]) -> Image: ...
def part_info(path: str) -> str: ...
def maps(scene: Scene, words: list[str]) -> dict[str, Any]: ...
def read_image(path: str) -> Image: ...
def compare(
    image: Image | NDArray[np.float32], reference: Image | NDArray[np.float32], layer: str | None = None
) -> tuple[str, list[float]]: ...
def options() -> dict[str, tuple[str, Any, bool]]: ...
def pass_limit(words: list[str]) -> int | None: ...
def keeps_lights(words: list[str]) -> bool: ...
def frame_file(path: str, frame: int) -> str: ...
def seconds(text: str) -> float: ...
def relative_error(text: str) -> float: ...
def run_command(words: list[str]) -> int: ...
