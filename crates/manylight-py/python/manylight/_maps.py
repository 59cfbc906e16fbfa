"""Where a many-light method places its lights, and why."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._options import default, render_words
from ._render import as_scene
from ._scene import Scene

__all__ = ["LightPositions", "Maps", "maps"]


@dataclass(frozen=True)
class LightPositions:
    """Virtual lights.

    Attributes:
        positions: (n, 3), in m.
        normals: (n, 3), unit, on the lit side.
        film_positions: (n, 2), in pixels from the upper left corner; NaN for lights that the camera does not see directly.
    """

    positions: NDArray[np.float32]
    normals: NDArray[np.float32]
    film_positions: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.positions)


@dataclass(frozen=True)
class Maps:
    """What a pass of a many-light method knows before it shades: Simon et al. 2015, figure 2.

    The value of a pixel is that at the first surface that is not specular. It is 0 where there is none.

    Attributes:
        importance: Density of importons, (height, width), in 1/m².
        irradiance: Irradiance by the photons that may become lights, (height, width, 3), in W/m².
        product: Importance times the luminance of irradiance, (height, width), in W/m⁴. The density of placed lights is proportional to it.
        shading: Reflectance towards the viewer times cosine, (height, width): a gray picture to draw on.
        placed: The lights, as they are placed.
        relaxed: The same lights, moved apart.
    """

    importance: NDArray[np.float32]
    irradiance: NDArray[np.float32]
    product: NDArray[np.float32]
    shading: NDArray[np.float32]
    placed: LightPositions
    relaxed: LightPositions


def maps(scene: Scene | str | os.PathLike[str], method: str = default("method"), **options: Any) -> Maps:
    """The maps of the first pass of a many-light method, as ``manylight maps`` shows them.

    Args:
        scene: A scene, or the path of a scene file.
        method: A method with virtual lights.
        **options: As for `manylight.render`.

    Raises:
        UsageError: The method has no virtual lights, or an option is wrong.
    """
    found = _native.maps(as_scene(scene)._native, render_words({"method": method, **options}))
    placed, relaxed = (LightPositions(*found.pop(name)) for name in ("placed", "relaxed"))
    return Maps(**found, placed=placed, relaxed=relaxed)
