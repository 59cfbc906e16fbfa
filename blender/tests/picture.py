# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the picture of the README: the scene with all lamps by `rich-vpl`, beside Cycles. Usage: picture.py OUT.jpg"""

import os
import sys

sys.path[:0] = [os.path.dirname(os.path.abspath(__file__)), os.path.dirname(os.path.dirname(os.path.abspath(__file__)))]

import manylight_render  # noqa: E402
import numpy as np  # noqa: E402
import renders  # noqa: E402
import test_materials  # noqa: E402
from PIL import Image  # noqa: E402


def main(path):
    manylight_render.register()
    scene = test_materials.all_lamps()
    scene.render.resolution_x, scene.render.resolution_y = 256, 192
    pictures = [renders.color(renders.manylight("rich-vpl", 16)), renders.color(renders.cycles(256))]
    values = np.clip(np.concatenate(pictures, 1), 0, 1) ** (1 / 2.2)
    Image.fromarray((255 * values).astype(np.uint8)).save(path, quality=88)


main(sys.argv[1])
