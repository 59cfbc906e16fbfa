# SPDX-License-Identifier: GPL-3.0-or-later
"""Animations in which nothing but the camera moves."""

import os

import bpy
import numpy as np
import pytest
import renders
import scenes

OPTIONS = dict(method="rich-vpl", passes=2, walkthrough=True, more="lights=64 photons=4000 max_depth=4")


@pytest.fixture
def scene():
    """A camera that moves by half a meter a frame, from frame 3 to 5."""
    scene = scenes.empty(world=(0.2, 0.2, 0.2))
    scene.render.resolution_x, scene.render.resolution_y = 32, 24
    scenes.stage()
    scenes.lamp("POINT", energy=200)
    camera = scenes.camera()
    scene.frame_start, scene.frame_end = 3, 5
    for frame in (3, 5):
        camera.location = (0.5 * (frame - 4), -7, 3)
        camera.keyframe_insert("location", frame=frame)
    for layer in camera.animation_data.action.layers:
        for curve in layer.strips[0].channelbag(camera.animation_data.action_slot).fcurves:
            for point in curve.keyframe_points:
                point.interpolation = "LINEAR"
    scene.frame_set(3)
    yield scene
    scene.manylight.walkthrough, scene.manylight.more = False, ""


def frames(scene, numbers, **changes):
    pictures = []
    for frame in numbers:
        scene.frame_set(frame)
        pictures.append(renders.manylight(**(OPTIONS | changes)))
    return pictures


def test_lights_are_made_once_for_all_frames(scene, monkeypatch):
    import manylight
    from manylight_render import walkthrough

    made = []
    original = walkthrough.kept

    def watched(*words):
        made.append(original(*words))
        return made[-1]

    monkeypatch.setattr(walkthrough, "kept", watched)
    pictures = frames(scene, (3, 4, 5))
    assert [next(iter(words)) for words in made] == ["lights_out", "lights_in", "lights_in"]
    lights = made[0]["lights_out"]
    assert len(manylight.read_lights(lights)[0]) >= 64
    # A frame has the same bits in any order.
    walkthrough.forget()
    assert not os.path.exists(lights)
    again = frames(scene, (5,))[0]
    assert np.array_equal(again["Combined"], pictures[2]["Combined"])
    assert not np.array_equal(pictures[0]["Combined"], pictures[2]["Combined"])
    # Other lights for other settings, and none that are kept for path tracing.
    frames(scene, (5,), seed=7)
    frames(scene, (5,), method="path", more="")
    assert [list(words) for words in made[3:]] == [["lights_out"], ["lights_out"], []]


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_the_camera_of_a_frame_is_that_of_a_picture_alone(scene, kind):
    scene.camera.data.type = kind
    scene.camera.data.shift_x = 0.1
    layer = bpy.context.view_layer
    layer.use_pass_position = layer.use_pass_z = True
    walk = frames(scene, (4, 5), method="path", passes=256, more="")
    alone = frames(scene, (4, 5), method="path", passes=256, more="", walkthrough=False)
    for of_walk, of_picture in zip(walk, alone, strict=True):
        renders.assert_alike(of_walk, of_picture, mean=0.01, block=0.05)
        for name in ("Position", "Depth"):
            # Samples of a pixel differ.
            assert np.median(np.abs(of_walk[name] - of_picture[name])) < 0.01, name
    assert not np.allclose(walk[0]["Position"], walk[1]["Position"], atol=0.1)


def test_what_a_walkthrough_cannot_be(scene):
    with pytest.raises(RuntimeError, match="not within the frames 3 to 5"):
        frames(scene, (6,))
    with pytest.raises(RuntimeError, match="--time|time"):
        frames(scene, (3,), time=5.0)
    scene.manylight.time = 0.0
    scene.camera.data.keyframe_insert("lens", frame=3)
    scene.camera.data.lens = 50
    scene.camera.data.keyframe_insert("lens", frame=5)
    with pytest.raises(RuntimeError, match="the lens of the camera differs"):
        frames(scene, (3,))


def test_lights_are_made_anew_where_something_else_moves(scene, capfd):
    cube = bpy.data.objects["Cube"]
    cube.keyframe_insert("location", frame=3)
    cube.location = (2, 0, 1.5)
    cube.keyframe_insert("location", frame=5)
    pictures = frames(scene, (3, 5))
    assert np.abs(renders.color(pictures[0]) - renders.color(pictures[1])).max() > 0.05
    assert "".join(capfd.readouterr()).count("besides the camera") == 1
