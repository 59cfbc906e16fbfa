#!/usr/bin/env python3
"""Draws a picture, its stated relative error, and how far it is from a reference in error bars, side by side.

    python3 error_bars_picture.py IMAGE.exr REFERENCE.exr OUT.webp

The error has a logarithmic scale from 0.3 % (blue) to 30 % (yellow). The last panel shows the channel that is farthest off, from
two bars too dark (blue) to two bars too bright (orange); the noise of the reference widens the bars.
Needs: pip install OpenEXR numpy Pillow.
"""
import sys

import numpy as np
import OpenEXR
from PIL import Image

#: Viridis at nine even steps, in sRGB.
VIRIDIS = [(68, 1, 84), (71, 45, 123), (59, 82, 139), (44, 114, 142), (33, 145, 140), (40, 174, 128), (94, 201, 98), (173, 220, 48), (253, 231, 37)]
#: The colors of differences on pages of `manylight compare --html`.
SIGNED = [(80, 170, 255), (20, 60, 140), (0, 0, 0), (150, 40, 20), (255, 150, 80)]


def rgb(channels: dict, layer: str = "") -> np.ndarray:
    return np.stack([np.asarray(channels[layer + c].pixels, np.float64) for c in "RGB"], -1)


def colored(place: np.ndarray, colors: list) -> np.ndarray:
    """Colors at places from 0 to 1."""
    steps = np.arange(len(colors)) / (len(colors) - 1)
    return np.stack([np.interp(place, steps, [color[c] for color in colors]) for c in range(3)], -1)


def srgb(linear: np.ndarray) -> np.ndarray:
    x = np.clip(linear, 0, 1)
    return 255 * np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 1e-9) ** (1 / 2.4) - 0.055)


def main() -> None:
    image, reference = (OpenEXR.File(path, separate_channels=True).channels() for path in sys.argv[1:3])
    x, bars, r = rgb(image), rgb(image, "error."), rgb(reference)
    variance = rgb(reference, "variance.") if "variance.R" in reference else np.zeros_like(r)
    relative = (bars / 1.96 / np.sqrt(x**2 + 0.01 * x.mean() ** 2)).mean(-1)
    error = colored(np.log(np.maximum(relative, 1e-9) / 0.003) / np.log(100), VIRIDIS)
    off = (x - r) / np.maximum(np.hypot(bars, 1.96 * np.sqrt(variance)), 1e-12)
    farthest = np.take_along_axis(off, np.abs(off).argmax(-1)[..., None], -1)[..., 0]
    panels = np.concatenate([srgb(x), error, colored(0.5 + farthest / 4, SIGNED)], 1)
    Image.fromarray(panels.round().astype(np.uint8)).save(sys.argv[3], quality=90)


if __name__ == "__main__":
    main()
