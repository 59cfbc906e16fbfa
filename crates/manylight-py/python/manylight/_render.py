"""Renders, parts of renders, and comparison."""

from __future__ import annotations

import contextlib
import json
import os
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _native
from ._cameras import Cameras, frame_words
from ._native import Image
from ._options import default, render_words, with_options
from ._scene import Scene, load_file

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["Comparison", "compare", "merge", "part_info", "read_image", "render", "render_part"]

Progress = Callable[[int, "int | None", float], object]


@with_options
def render(
    scene: Scene | str | os.PathLike[str],
    method: str = default("method"),
    *,
    passes: int | None = None,
    time: float | str | None = None,
    target_error: float | str | None = None,
    seed: int = default("seed"),
    size: tuple[int, int] | None = None,
    cameras: Cameras | None = None,
    frame: int | None = None,
    progress: bool | Progress = False,
    **options: Any,
) -> Image:
    """Renders a scene to an image.

    Ctrl-C stops the render: the image with the passes so far is returned, with a warning, and `Image.interrupted` is true.

    Args:
        scene: A scene, or the path of a scene file.
        method: A method, as ``manylight list methods`` names it.
        passes: Samples per pixel of path tracing, or passes, of several camera paths per pixel. Without ``passes``, ``time`` and
            ``target_error``, a default number.
        time: Seconds, or text such as ``"10m"``; the render stops after the pass that ends closest to it.
        target_error: The render stops when the relative error of the image, denoised if it is, is at most this value with 95 % confidence.
        seed: Images with the same seed have the same bits, for any number of threads.
        size: Width and height in pixels. Default: the size in the scene.
        cameras: The cameras of a walkthrough, of which ``frame`` is rendered, as for `manylight.frames`.
        frame: A frame of a walkthrough, counted from 1. It has the bits of a render of all frames.
        progress: Whether to show a progress bar; or a function that is called with the passes so far, the passes in total (None if another
            limit ends the render), and seconds. An exception of it ends the render.
        **options: Any other option of ``manylight render``, with underscores, as listed below: ``max_depth=5``, ``filter="box"``,
            ``denoise="oidn"``, ``aov=["position"]``, ``lights=4096``, ``light_group={"key": "lamp*"}``.

    Raises:
        UsageError: An option has a wrong value, or contradicts another.
        SceneError: The scene is invalid.
        ComponentError: The denoiser is missing.
    """
    limits = {"passes": passes, "time": time, "target_error": target_error}
    settings = {"method": method, **limits, "seed": seed, "size": size, **options}
    return rendered(as_scene(scene), settings, cameras, frame, progress)


def rendered(
    scene: Scene,
    settings: Mapping[str, Any],
    cameras: Cameras | None,
    frame: int | None,
    progress: bool | Progress,
    files_stay: bool = True,
) -> Image:
    """`render`, with its further keywords as ``settings``. ``files_stay``: whether the files that these name stay."""
    command = render_words(settings)
    with frame_words(cameras, frame) as (of_frame, camera_stays), _shown(progress) as report:
        image = _native.render(scene._native, command + of_frame, report, files_stay=files_stay and camera_stays)
    if image.interrupted:
        warnings.warn(f"interrupted: the image has {image.passes} passes", RuntimeWarning, stacklevel=3)
    return image


def render_part(
    scene: Scene | str | os.PathLike[str],
    path: str | os.PathLike[str],
    *,
    shard: tuple[int, int] | None = None,
    blocks: range | None = None,
    passes: int | None = None,
    method: str = default("method"),
    progress: bool | Progress = False,
    **options: Any,
) -> None:
    """Renders a share of the passes of a render to a part file, for `merge`.

    Args:
        scene: A scene, or the path of a scene file.
        path: The part file. It is written whole or not at all.
        shard: Which share, counted from 1, of how many: ``(2, 8)``.
        blocks: Blocks of passes instead, counted from 0; ``block=`` is their number of passes.
        passes: Passes of the whole render. With ``blocks``, None is a render without end: it has the passes of all parts that are merged.
        method: As for `render`.
        progress: As for `render`, over the passes of this part.
        **options: As for `render`. All parts of a render have the same.

    Raises:
        KeyboardInterrupt: Ctrl-C: no part was written.
        UsageError, SceneError, FileError: As for `render`.
    """
    if (shard is None) == (blocks is None):
        raise TypeError("expected either shard= or blocks=")
    if blocks is not None and blocks.step != 1:
        raise ValueError(f"blocks: found {blocks}, expected consecutive ones")
    is_open = blocks is not None and passes is None
    command = render_words({"method": method, "passes": passes, **options})
    span = None if blocks is None else (blocks.start, blocks.stop)
    with _shown(progress) as report:
        native = as_scene(scene)._native
        _native.render_part(native, command, os.fspath(path), share=shard, blocks=span, open=is_open, progress=report)


def merge(parts: Iterable[str | os.PathLike[str]]) -> Image:
    """Merges the part files of a render, in any order, to the image of one run, with the same bits.

    Raises:
        FileError: A part cannot be read, or is damaged.
        UsageError: A part belongs to another render, or blocks are missing or given twice.
    """
    return _native.merge([os.fspath(part) for part in parts])


def part_info(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Checks a part file, and returns what it says: ``render`` (what decides about its bits), ``film``, ``state``, ``blocks``.

    Raises:
        FileError: The file cannot be read, is damaged, or is no part of a render.
    """
    return json.loads(_native.part_info(os.fspath(path)))


def read_image(path: str | os.PathLike[str]) -> Image:
    """Reads an image file: exr with all layers, png, jpg, tga, bmp, hdr, pfm.

    Raises:
        FileError: The file cannot be read, or is damaged.
    """
    return _native.read_image(os.fspath(path))


class Comparison(dict):
    """How an image differs from a reference: the measures of ``manylight compare --json``, also as attributes.

    ``relmse``, ``block_relmse`` (that of the means of 8x8 blocks), ``mse``, ``mape``, ``smape``, ``psnr``, ``ssim``, ``flip``,
    ``ratio_of_means`` (one number per channel), ``pixels``, and, if both images know their variance, ``noise_floor`` and ``blocks`` (z-scores
    of 8x8 blocks). ``flip_map`` is an array (height, width).
    """

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"no measure {name!r}; there are {', '.join(self)}") from None

    def __repr__(self) -> str:
        return f"<manylight.Comparison relmse {self.relmse:.3g}, smape {self.smape:.3g}, flip {self.flip:.3g}>"


def compare(
    image: Image | ArrayLike | str | os.PathLike[str],
    reference: Image | ArrayLike | str | os.PathLike[str],
    *,
    layer: str | None = None,
) -> Comparison:
    """Measures how an image differs from a reference of the same size.

    Args:
        image: An image, an array (height, width, 3) of linear values, or an image file.
        reference: The same.
        layer: A layer of both instead of the picture.

    Raises:
        UsageError: The sizes differ, or a layer is missing.
    """
    ours, theirs = _comparable(image), _comparable(reference)
    text, flip = _native.compare(ours, theirs, layer)
    measures = Comparison(json.loads(text))
    del measures["image"]
    measures["flip_map"] = np.array(flip, dtype=np.float32).reshape(np.shape(ours)[:2])
    return measures


def _comparable(picture: Any) -> Any:
    if isinstance(picture, Image):
        return picture
    if isinstance(picture, (str, os.PathLike)):
        return read_image(picture)
    return np.asarray(picture, dtype=np.float32)


def as_scene(scene: Scene | str | os.PathLike[str]) -> Scene:
    """The scene, loaded if it is a path."""
    return scene if isinstance(scene, Scene) else load_file(scene)


@contextlib.contextmanager
def _shown(progress: bool | Progress) -> Iterator[Progress | None]:
    """The function to be called after each pass."""
    if not isinstance(progress, bool):
        yield progress
    elif progress:
        # Inside of notebooks, this import looks for widgets, and warns if there are none.
        from tqdm.auto import tqdm

        with tqdm(unit="pass") as bar:

            def show(passes: int, total: int | None, _seconds: float) -> None:
                bar.total = total
                bar.update(passes - bar.n)

            yield show
    else:
        yield None
