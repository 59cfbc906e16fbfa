"""Compares pictures of manylight with the views of Blender's OpenColorIO configuration.

Usage: python views.py RENDER.exr STANDARD.png NEUTRAL.png AGX.png [CONFIG.ocio]

Needs the Python packages opencolorio, OpenEXR, numpy and pillow. The three pictures are renders of the same command with
`--view standard`, `neutral` and `agx`, or `-` to leave one out. CONFIG.ocio is that of Blender
(`datafiles/colormanagement/config.ocio`), by default the one in the Python package bpy.
"""

import importlib.util
import pathlib
import sys

import numpy as np
import OpenEXR
import PyOpenColorIO as ocio
from PIL import Image

VIEWS = ["Standard", "Khronos PBR Neutral", "AgX"]


def blender_config():
    package = pathlib.Path(importlib.util.find_spec("bpy").origin).parent
    return next(package.glob("**/colormanagement/config.ocio"))


def main(render, *files):
    config = ocio.Config.CreateFromFile(str(files[3] if len(files) > 3 else blender_config()))
    channels = OpenEXR.File(render, separate_channels=True).channels()
    linear = np.stack([np.asarray(channels[c].pixels) for c in "RGB"], axis=-1).astype(np.float32)
    for view, file in zip(VIEWS, files):
        if file == "-":
            continue
        transform = ocio.DisplayViewTransform(src="Linear Rec.709", display="sRGB", view=view)
        expected = np.ascontiguousarray(np.maximum(linear, 0)).reshape(-1, 3)
        config.getProcessor(transform).getDefaultCPUProcessor().applyRGB(expected)
        picture = Image.open(file)
        found = np.asarray(picture).reshape(-1, 3) / 255.0
        error = np.abs(found - np.clip(expected, 0, 1)) * 255
        print(f"{view}: differences in steps of 8 bits: mean {error.mean():.2f}, 99 % {np.quantile(error, 0.99):.2f},"
              f" largest {error.max():.2f}; sRGB chunk {picture.info.get('srgb')}, text {sorted(picture.text)}")


main(*sys.argv[1:])
