# SPDX-License-Identifier: GPL-3.0-or-later
"""Worlds against Cycles: one color, an environment texture that is turned, a sky, transparent film."""

import math

import bpy
import numpy as np
import pytest
import renders
import scenes
from manylight_render.manylight_export import world


def stage(ball=None):
    """Open to the sky, which the camera sees. `ball`: the material of a ball, a mirror by default."""
    ball = ball or scenes.principled("mirror", Base_Color=(1, 1, 1, 1), Metallic=1.0, Roughness=0.0)
    scenes.plane(scenes.matte("floor", (0.7, 0.6, 0.5)), 6)
    scenes.cube(scenes.matte("cube", (0.8, 0.3, 0.2)), 1.5, (-1, 0.5, 0.75))
    scenes.ball(ball, 0.9, (1.2, 0, 0.9))
    scenes.camera(location=(0, -7, 2.5), rotation=(math.radians(80), 0, 0))


def test_one_color():
    scene = scenes.empty(world=(0.4, 0.6, 0.9))
    scenes.background(scene.world).inputs["Strength"].default_value = 1.5
    stage()
    renders.assert_alike(renders.manylight(), renders.cycles())


def patterned_image(folder):
    """An environment that differs in every direction: a bright patch on a gradient."""
    height, width = 64, 128
    v, u = np.mgrid[0:height, 0:width] / [[[height]], [[width]]]
    pixels = np.stack([0.2 + u, 0.3 + 0.5 * v, 1 - 0.8 * u, np.ones_like(u)], -1)
    pixels[40:46, 20:28, :3] = (20, 12, 6)
    image = bpy.data.images.new("environment", width, height, float_buffer=True)
    image.pixels.foreach_set(pixels.astype(np.float32).ravel())
    image.filepath_raw = str(folder / "environment.exr")
    image.file_format = "OPEN_EXR"
    image.save()
    return bpy.data.images.load(image.filepath_raw)


def textured_world(folder):
    """The environment node of a world in the current file that is one image."""
    shown = scenes.empty().world
    texture = shown.node_tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = patterned_image(folder)
    texture.image.colorspace_settings.name = "Linear Rec.709"
    shown.node_tree.links.new(texture.outputs["Color"], scenes.background(shown).inputs["Color"])
    return texture


def test_environment_texture(tmp_path):
    textured_world(tmp_path)
    stage()
    renders.assert_alike(renders.manylight(passes=256), renders.cycles(256))


@pytest.mark.parametrize(
    "name, value", [("translation", (0.5, 0, 0)), ("rotation", (0, 0, 1)), ("scale", (1, 2, 1)), ("mapping_x", "Y")]
)
def test_a_mapping_in_the_texture_node_is_baked(tmp_path, name, value):
    texture = textured_world(tmp_path)
    shown = bpy.context.scene.world
    assert world.plain_image(shown) is not None
    setattr(texture.texture_mapping, name, value)
    assert world.plain_image(shown) is None


def test_environment_texture_that_is_moved(tmp_path):
    texture = textured_world(tmp_path)
    texture.texture_mapping.translation = (0.6, 0.2, 0.1)
    texture.texture_mapping.mapping_x, texture.texture_mapping.mapping_y = "Y", "X"
    stage()
    # The seam of the image, where its colors jump, lies across one part.
    renders.assert_alike(renders.manylight(passes=256), renders.cycles(256), outliers=1)


def test_a_volume_is_a_warning(tmp_path):
    texture = textured_world(tmp_path)
    texture.texture_mapping.scale = (1, 2, 1)
    shown, warnings = bpy.context.scene.world, []
    tree = shown.node_tree
    expected = world.radiance(shown, str(tmp_path), None)
    fog = tree.nodes.new("ShaderNodeVolumeScatter")
    tree.links.new(fog.outputs[0], tree.get_output_node("CYCLES").inputs["Volume"])
    found = world.radiance(shown, str(tmp_path), lambda message, name: warnings.append((message, name)))
    assert warnings == [("volumes of the world are not rendered", "world")]
    assert np.array_equal(found, expected)


def test_environment_texture_with_a_mapping(tmp_path):
    scene = scenes.empty()
    tree = scene.world.node_tree
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = patterned_image(tmp_path)
    mapping = tree.nodes.new("ShaderNodeMapping")
    mapping.inputs["Rotation"].default_value = (0.3, 0.2, 2.0)
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    background = scenes.background(scene.world)
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    background.inputs["Strength"].default_value = 0.7
    stage()
    # The seam of the image, where its colors jump, lies across one part.
    renders.assert_alike(renders.manylight(passes=256), renders.cycles(256), outliers=1)


def test_sky_texture():
    scene = scenes.empty()
    tree = scene.world.node_tree
    sky = tree.nodes.new("ShaderNodeTexSky")
    sky.sky_type = "MULTIPLE_SCATTERING"
    sky.sun_elevation, sky.sun_rotation = 0.6, 2.5
    background = scenes.background(scene.world)
    tree.links.new(sky.outputs["Color"], background.inputs["Color"])
    background.inputs["Strength"].default_value = 0.1
    stage(ball=scenes.matte("ball", (0.5, 0.5, 0.5)))
    renders.assert_alike(renders.manylight(), renders.cycles())


def test_transparent_film():
    scene = scenes.empty(world=(0.4, 0.6, 0.9))
    scene.render.film_transparent = True
    stage()
    scenes.lamp("AREA", (2, -2, 4), (0.4, 0.3, 0), energy=100, size=1.0)
    ours, theirs = renders.manylight(), renders.cycles()
    renders.assert_alike(ours, theirs)
    assert np.abs(ours["Combined"][..., 3] - theirs["Combined"][..., 3]).max() < 0.2
    assert abs(ours["Combined"][..., 3].mean() - theirs["Combined"][..., 3].mean()) < 0.003
