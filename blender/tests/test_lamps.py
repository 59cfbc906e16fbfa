# SPDX-License-Identifier: GPL-3.0-or-later
"""Each kind of lamp against Cycles, on matte surfaces."""

import math

import pytest
import renders
import scenes

TILTED = (math.radians(25), math.radians(-20), math.radians(40))
LAMPS = {
    "point": dict(kind="POINT", energy=200, shadow_soft_size=0, color=(1, 0.7, 0.4)),
    "point with a radius": dict(kind="POINT", energy=200, shadow_soft_size=0.3, use_soft_falloff=False),
    "point, not normalized": dict(kind="POINT", energy=30, shadow_soft_size=0.4, use_soft_falloff=False, normalize=False),
    "point with temperature and exposure": dict(
        kind="POINT", energy=50, shadow_soft_size=0, use_temperature=True, temperature=3000, exposure=1.5
    ),
    "spot": dict(kind="SPOT", rotation=TILTED, energy=500, shadow_soft_size=0, spot_size=1.2, spot_blend=0.4),
    "spot with a radius": dict(kind="SPOT", rotation=TILTED, energy=500, shadow_soft_size=0.2, spot_size=1.2, spot_blend=0.4),
    "sun": dict(kind="SUN", rotation=TILTED, energy=2, angle=0),
    "sun with an angle": dict(kind="SUN", rotation=TILTED, energy=2, angle=math.radians(10)),
    "sun of the default angle": dict(kind="SUN", rotation=TILTED, energy=2),
    "square": dict(kind="AREA", rotation=TILTED, energy=150, shape="SQUARE", size=1.0),
    "rectangle": dict(kind="AREA", rotation=TILTED, energy=150, shape="RECTANGLE", size=1.5, size_y=0.4),
    "disk": dict(kind="AREA", rotation=TILTED, energy=150, shape="DISK", size=1.0),
    "ellipse, scaled": dict(kind="AREA", rotation=TILTED, scale=(2, 0.5, 1), energy=150, shape="ELLIPSE", size=0.6, size_y=0.9),
    "square, mirrored and not normalized": dict(
        kind="AREA", rotation=TILTED, scale=(-1, 1, 1), energy=40, size=0.8, normalize=False
    ),
}


@pytest.mark.parametrize("name", LAMPS)
def test_lamp(name):
    scenes.empty()
    scenes.stage()
    scenes.camera()
    scenes.lamp(**LAMPS[name])
    renders.assert_alike(renders.manylight(passes=256), renders.cycles(256))


def test_lamps_in_view_are_not_seen_and_emitting_meshes_are():
    scenes.empty(world=(0.1, 0.15, 0.2))
    scenes.stage()
    scenes.camera(location=(0, -7, 2), rotation=(math.radians(85), 0, 0))
    facing = (math.radians(-90), 0, 0)
    scenes.lamp("AREA", (1.5, 1, 1.5), (math.radians(90), 0, 0), energy=60, size=1.5)
    scenes.lamp("AREA", (-1.5, 1, 2.5), facing, energy=60, size=1.0, shape="DISK")
    scenes.lamp("POINT", (0, 0, 2), energy=60, shadow_soft_size=0.4, use_soft_falloff=False)
    glow = scenes.principled(
        "glow", Base_Color=(0, 0, 0, 1), Specular_IOR_Level=0.0, Emission_Color=(1, 0.5, 0.2, 1), Emission_Strength=3.0
    )
    scenes.cube(glow, 0.5, (2.5, 0, 0.3))
    scenes.plane(glow, 0.8, (-2.5, 0, 1.2), (math.radians(60), 0, 0))
    renders.assert_alike(renders.manylight(passes=256), renders.cycles(256))


def test_area_lamps_have_one_side():
    scenes.empty()
    scenes.stage()
    scenes.camera()
    scenes.lamp("AREA", (0, 0, 2), (math.radians(180), 0, 0), energy=100, size=1.0)
    scenes.plane(scenes.matte("screen", (0.2, 0.2, 0.2)), 12, (0, 0, 5))
    renders.assert_alike(renders.manylight(passes=256), renders.cycles(256))


def test_lamps_that_the_camera_sees():
    scenes.empty()
    scenes.stage()
    scenes.camera(location=(0, -7, 2), rotation=(math.radians(85), 0, 0))
    scenes.lamp("AREA", (1.5, 1, 1.5), (math.radians(90), 0, 0), energy=60, size=1.5).visible_camera = True
    scenes.lamp("POINT", (0, 0, 2), energy=60, shadow_soft_size=0.4, use_soft_falloff=False).visible_camera = True
    scenes.lamp("AREA", (-1.5, 1, 2.5), (math.radians(-90), 0, 0), energy=60, size=1.0)
    renders.assert_alike(renders.manylight(passes=256), renders.cycles(256))
