# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors, warnings, and that the user's data stay as they are."""

import math
import sys

import bpy
import numpy as np
import pytest
import renders
import scenes


def small():
    scene = scenes.empty(world=(0.2, 0.2, 0.2))
    scene.render.resolution_x, scene.render.resolution_y = 16, 12
    scenes.stage()
    scenes.camera()
    return scene


def test_without_a_camera():
    small().camera = None
    with pytest.raises(RuntimeError, match="[Cc]amera"):
        renders.manylight(passes=1)


def test_panoramic_camera():
    small().camera.data.type = "PANO"
    with pytest.raises(RuntimeError, match="perspective"):
        renders.manylight(passes=1)


def test_messages_of_manylight_are_shown():
    small()
    with pytest.raises(RuntimeError, match="emission"):
        renders.manylight("rich-vpl", passes=1, more="emission=bulb")
    with pytest.raises(RuntimeError, match="expected NAME=VALUE"):
        renders.manylight("rich-vpl", passes=1, more="emission")
    with pytest.raises(RuntimeError, match="never end"):
        renders.manylight("rich-vpl", passes=0, more="")


def test_without_the_package(monkeypatch):
    small()
    monkeypatch.setitem(sys.modules, "manylight", None)
    with pytest.raises(RuntimeError, match="pip install"):
        renders.manylight(passes=1)


def test_what_is_not_converted_is_a_warning(capfd):
    scene = small()
    scenes.lamp("AREA", spread=math.radians(60), energy=10)
    scenes.lamp("AREA", spread=math.radians(90), energy=10)
    scene.camera.data.dof.use_dof = True
    bpy.context.view_layer.use_pass_mist = True
    velvet = bpy.data.materials.new("velvet")
    tree = velvet.node_tree
    sheen = tree.nodes.new("ShaderNodeBsdfSheen")
    tree.links.new(sheen.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    scenes.cube(velvet, 1, (0, 0, 0))
    renders.manylight(passes=1)
    shown = "".join(capfd.readouterr())
    for words in ("spread of area lamps", "depth of field", "Mist", "cannot be converted"):
        assert shown.count(words) == 1, words


def state():
    """Names and users of all data."""
    return {
        kind: sorted((item.name, item.users) for item in getattr(bpy.data, kind))
        for kind in ("scenes", "objects", "meshes", "materials", "lights", "cameras", "images", "worlds", "collections")
    }


def test_the_data_stay_as_they_are():
    scene = small()
    scenes.lamp("AREA", energy=50)
    scenes.lamp("SUN", energy=1)
    scene.render.engine = "MANYLIGHT"
    before, nodes = state(), len(bpy.data.materials["cube"].node_tree.nodes)
    renders.manylight(passes=1)
    after = state()
    after["images"] = [image for image in after["images"] if image[0] != "Render Result"]
    before["images"] = [image for image in before["images"] if image[0] != "Render Result"]
    assert after == before
    assert len(bpy.data.materials["cube"].node_tree.nodes) == nodes
    assert bpy.context.scene == scene


def test_frames_of_an_animation_differ():
    scene = small()
    cube = bpy.data.objects["Cube"]
    cube.keyframe_insert("location", frame=1)
    cube.location = (2, 0, 1.5)
    cube.keyframe_insert("location", frame=10)
    pictures = []
    for frame in (1, 10):
        scene.frame_set(frame)
        pictures.append(renders.manylight(passes=256))
    assert np.abs(renders.color(pictures[0]) - renders.color(pictures[1])).max() > 0.05
    renders.assert_alike(pictures[1], renders.cycles(256), block=0.1)


def test_the_same_seed_gives_the_same_picture():
    small()
    first, second, other = (renders.manylight("rich-vpl", passes=2, seed=seed) for seed in (3, 3, 4))
    assert np.array_equal(first["Combined"], second["Combined"])
    assert not np.array_equal(first["Combined"], other["Combined"])


def test_cancel_keeps_what_is_there(monkeypatch):
    import time

    from manylight_render.engine import ManylightEngine

    small()
    end = time.monotonic() + 4
    monkeypatch.setattr(ManylightEngine, "is_cancelled", lambda self: time.monotonic() > end)
    picture = renders.color(renders.manylight("path", passes=20000))
    assert time.monotonic() < end + 2
    assert picture.min() > 0
    monkeypatch.setattr(ManylightEngine, "is_cancelled", lambda self: True)
    renders.manylight("path", passes=20000)
    assert time.monotonic() < end + 4


def test_panels_and_settings():
    from manylight_render import panels

    names = {panel.__name__ for panel in panels.shared_panels()}
    assert names >= {"RENDER_PT_color_management", "DATA_PT_lens", *panels.FROM_EEVEE}
    assert all(panels.ENGINE in panel.COMPAT_ENGINES for panel in panels.shared_panels())


def test_time_limit():
    small()
    assert renders.color(renders.manylight("path", passes=0, time=0.5)).max() > 0
