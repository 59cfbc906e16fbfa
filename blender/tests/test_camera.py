# SPDX-License-Identifier: GPL-3.0-or-later
"""Cameras against Cycles, in scenes of emitting cubes, which have no noise."""

import math

import pytest
import renders
import scenes

CAMERAS = {
    "wide": dict(size=(72, 40)),
    "tall": dict(size=(40, 72)),
    "fit to the width of a tall picture": dict(size=(40, 72), sensor_fit="HORIZONTAL", lens=50),
    "fit to the height": dict(size=(72, 40), sensor_fit="VERTICAL", sensor_height=16),
    "shifted": dict(size=(72, 40), shift_x=0.13, shift_y=-0.21),
    "shifted, tall": dict(size=(40, 72), shift_x=-0.1, shift_y=0.15),
    "orthographic": dict(size=(72, 40), type="ORTHO", ortho_scale=9),
    "orthographic, tall and shifted": dict(size=(40, 72), type="ORTHO", ortho_scale=9, shift_x=0.2, shift_y=0.1),
    "clipped": dict(size=(72, 40), clip_end=7.3),
}
# Largest difference of blocks of 5 to 9 pixels. A perspective shift is met to a quarter of a pixel, which moves edges.
BLOCK, SHIFTED_BLOCK = 0.08, 0.3


def stage(**settings):
    for i in range(6):
        color = tuple(0.2 + (i >> k & 1) for k in range(3))
        glow = scenes.principled(
            f"glow {i}", Base_Color=(0, 0, 0, 1), Specular_IOR_Level=0.0, Emission_Color=(*color, 1), Emission_Strength=1.0
        )
        scenes.cube(glow, 0.9, (2.2 * (i % 3) - 2.2, 0.7 * (i % 2), 2.4 * (i // 3) + 0.7))
    return scenes.camera(location=(0.4, -7, 2.2), rotation=(math.radians(86), math.radians(5), math.radians(4)), **settings)


def dark_scene(size):
    scene = scenes.empty(world=(0.05, 0.05, 0.05))
    scene.render.resolution_x, scene.render.resolution_y = size
    return scene


@pytest.mark.parametrize("name", CAMERAS)
def test_camera(name):
    settings = dict(CAMERAS[name])
    dark_scene(settings.pop("size"))
    stage(**settings)
    block = SHIFTED_BLOCK if "shift_x" in settings and "type" not in settings else BLOCK
    renders.assert_alike(renders.manylight(passes=64), renders.cycles(64), block=block)


@pytest.mark.parametrize("is_cropped", [True, False])
def test_border(is_cropped):
    scene = dark_scene((200, 120))
    scene.render.resolution_percentage = 50
    render = scene.render
    render.use_border, render.use_crop_to_border = True, is_cropped
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.2, 0.92, 0.1, 0.7
    stage()
    renders.assert_alike(renders.manylight(passes=64), renders.cycles(64), block=BLOCK)
