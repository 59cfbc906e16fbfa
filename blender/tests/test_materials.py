# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole scenes against Cycles: glossy metal, glass, mixed shaders, instances; by path tracing and by virtual lights."""

import math

import bpy
import numpy as np
import pytest
import renders
import scenes
from manylight_render.manylight_export import materials


def metal(roughness):
    made = scenes.principled("metal", Base_Color=(0.9, 0.7, 0.3, 1), Metallic=1.0, Roughness=roughness)
    # Without multiple scattering between facets, which manylight does not have.
    made.node_tree.nodes["Principled BSDF"].distribution = "GGX"
    return made


def all_lamps():
    """A matte room, open to the sky, with a metal and a glass ball, and every kind of lamp."""
    scene = scenes.empty(world=(0.15, 0.2, 0.3))
    scenes.stage()
    scenes.ball(metal(0.2), 0.6, (0.6, -0.4, 0.6))
    glass = scenes.principled("glass", Base_Color=(1, 1, 1, 1), Roughness=0.0, Transmission_Weight=1.0, IOR=1.45)
    scenes.ball(glass, 0.5, (-0.6, -1.4, 0.5))
    glow = scenes.principled(
        "glow", Base_Color=(0, 0, 0, 1), Specular_IOR_Level=0.0, Emission_Color=(0.4, 1, 0.5, 1), Emission_Strength=2.0
    )
    scenes.cube(glow, 0.4, (1.9, -0.8, 0.2))
    scenes.lamp("POINT", (-2, -1, 2), energy=40, shadow_soft_size=0.1, color=(1, 0.6, 0.4))
    scenes.lamp("SPOT", (2, -2, 3), (0.5, 0.3, 0.4), energy=150, spot_size=1.0, shadow_soft_size=0)
    scenes.lamp("SUN", (0, 0, 5), (0.6, 0.3, 0), energy=0.7, angle=math.radians(5))
    scenes.lamp("AREA", (0, 0, 3), (0.2, 0, 0), energy=50, size=1.0, color=(0.6, 0.8, 1))
    scenes.camera()
    return scene


@pytest.mark.parametrize("method, passes", [("path", 256), ("rich-vpl", 16)])
def test_all_lamps_metal_and_glass(method, passes):
    all_lamps()
    # Light that the glass focuses is noise in both path tracers, and that of the spot lamp, a point, is missing there.
    renders.assert_alike(renders.manylight(method, passes), renders.cycles(512), block=0.1, outliers=4)


def shader_nodes(name, build):
    """A material whose surface is what `build(new, link)` returns as a node."""
    made = bpy.data.materials.new(name)
    tree = made.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    node = build(lambda kind: tree.nodes.new("ShaderNode" + kind), tree.links.new)
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return made


def diffuse(new, link):
    node = new("BsdfDiffuse")
    node.inputs["Color"].default_value = (0.2, 0.6, 0.3, 1)
    return node


def half_transparent(new, link):
    mix = new("MixShader")
    mix.inputs[0].default_value = 0.4
    link(new("BsdfTransparent").outputs[0], mix.inputs[1])
    link(diffuse(new, link).outputs[0], mix.inputs[2])
    return mix


def glowing(new, link):
    total, emission = new("AddShader"), new("Emission")
    emission.inputs["Color"].default_value = (1, 0.5, 0.2, 1)
    emission.inputs["Strength"].default_value = 0.8
    link(diffuse(new, link).outputs[0], total.inputs[0])
    link(emission.outputs[0], total.inputs[1])
    return total


def glass(new, link):
    node = new("BsdfGlass")
    node.inputs["Roughness"].default_value = 0.0
    return node


def test_other_shader_nodes():
    scenes.empty(world=(0.3, 0.35, 0.4))
    scenes.stage()
    for x, build in zip((-0.2, 0.9, 2.0, -2.2), (diffuse, half_transparent, glowing, glass)):
        scenes.ball(shader_nodes(build.__name__, build), 0.5, (x, -1, 0.5))
    bpy.ops.mesh.primitive_cube_add(size=0.6, location=(0.3, 0.5, 1.6))  # without a material
    scenes.lamp("AREA", (0, -1, 4), energy=100, size=2.0)
    scenes.camera()
    renders.assert_alike(renders.manylight(passes=256), renders.cycles(256))


def shining(new, link):
    """Light without a surface."""
    total, emission = new("AddShader"), new("Emission")
    emission.inputs["Color"].default_value = (1, 0.5, 0.2, 1)
    emission.inputs["Strength"].default_value = 1.5
    link(emission.outputs[0], total.inputs[0])
    link(new("BsdfTransparent").outputs[0], total.inputs[1])
    return total


def faint(new, link):
    """A mixture of transparency and a mixture."""
    mix = new("MixShader")
    mix.inputs[0].default_value = 0.5
    link(half_transparent(new, link).outputs[0], mix.inputs[1])
    link(new("BsdfTransparent").outputs[0], mix.inputs[2])
    return mix


def test_sums_and_mixtures_with_transparent_shaders():
    scenes.empty(world=(0.1, 0.12, 0.15))
    scenes.stage()
    for x, build in ((-1.4, shining), (1.2, faint)):
        scenes.ball(shader_nodes(build.__name__, build), 0.7, (x, -1, 0.7))
    scenes.camera()
    renders.assert_alike(renders.manylight(passes=256), renders.cycles(256))


def prepared(build):
    """The principled node that an exported material has, and the warnings."""
    made, warnings = shader_nodes(build.__name__, build), []
    materials.prepare(made, lambda message, name: warnings.append(message))
    return materials.source(materials.active_output(made).inputs["Surface"]), warnings


def test_opacities_of_mixtures_are_multiplied():
    scenes.empty()

    def textured(new, link, factor=0.25, is_linked=False):
        mix, shader, image = new("MixShader"), new("BsdfPrincipled"), new("TexImage")
        mix.inputs[0].default_value = factor
        if is_linked:
            link(image.outputs["Alpha"], mix.inputs[0])
        link(image.outputs["Alpha"], shader.inputs["Alpha"])
        link(new("BsdfTransparent").outputs[0], mix.inputs[1])
        link(shader.outputs[0], mix.inputs[2])
        return mix

    shader, warnings = prepared(faint)
    assert shader.inputs["Alpha"].default_value == pytest.approx(0.2) and not warnings
    shader, warnings = prepared(textured)
    product = materials.source(shader.inputs["Alpha"])
    assert product.operation == "MULTIPLY" and product.inputs[1].default_value == 0.25 and not warnings
    assert materials.source(product.inputs[0]).type == "TEX_IMAGE"

    def textured_twice(new, link):
        return textured(new, link, is_linked=True)

    shader, warnings = prepared(textured_twice)
    assert materials.source(shader.inputs["Alpha"]).type == "TEX_IMAGE"
    assert len(warnings) == 1 and "opacity of the shader" in warnings[0]

    def faded_by_a_texture(new, link):
        mix = new("MixShader")
        link(new("TexImage").outputs["Alpha"], mix.inputs[0])
        link(new("BsdfTransparent").outputs[0], mix.inputs[1])
        link(half_transparent(new, link).outputs[0], mix.inputs[2])
        return mix

    shader, warnings = prepared(faded_by_a_texture)
    product = materials.source(shader.inputs["Alpha"])
    assert product.operation == "MULTIPLY" and product.inputs[1].default_value == pytest.approx(0.4) and not warnings


def test_emission_in_a_sum_keeps_its_strength():
    scenes.empty()

    def bright(new, link):
        total = shining(new, link)
        materials.source(total.inputs[0]).inputs["Strength"].default_value = 1000.0
        return total

    for build, strength in ((shining, 1.5), (bright, 1000.0)):
        shader, warnings = prepared(build)
        opacity = shader.inputs["Alpha"].default_value
        assert 0 < opacity < 0.002 and not warnings
        assert shader.inputs["Emission Strength"].default_value * opacity == pytest.approx(strength)

    def textured(new, link):
        total = shining(new, link)
        link(new("TexImage").outputs["Color"], materials.source(total.inputs[0]).inputs["Strength"])
        return total

    assert "scaled by opacity" in prepared(textured)[1][0]


def colored_mixture(new, link):
    mix = half_transparent(new, link)
    materials.source(mix.inputs[1]).inputs["Color"].default_value = (1, 0, 0, 1)
    return mix


def brushed(new, link):
    node = new("BsdfAnisotropic")
    node.inputs["Anisotropy"].default_value = 0.5
    return node


@pytest.mark.parametrize("build, words", [(colored_mixture, "color of transparent"), (brushed, "anisotropy of glossy")])
def test_losses_are_warnings(build, words):
    scenes.empty()
    warnings = prepared(build)[1]
    assert len(warnings) == 1 and words in warnings[0]


def test_a_volume_of_a_material_is_a_warning():
    scenes.empty()
    made, warnings = scenes.matte("foggy", (1, 1, 1)), []
    tree = made.node_tree
    volume = tree.nodes.new("ShaderNodeVolumeScatter")
    tree.links.new(volume.outputs[0], tree.nodes["Material Output"].inputs["Volume"])
    materials.prepare(made, lambda message, name: warnings.append(message))
    assert warnings == ["volumes of materials are not rendered"]


def test_instances_modifiers_and_hidden_objects():
    scene = scenes.empty(world=(0.3, 0.35, 0.4))
    scenes.stage()
    cone = bpy.data.collections.new("cones")
    bpy.ops.mesh.primitive_cone_add(radius1=0.3, depth=0.7)
    item = scenes.give(scenes.matte("cone", (0.3, 0.4, 0.8)))
    scene.collection.objects.unlink(item)
    cone.objects.link(item)
    for i in range(3):
        empty = bpy.data.objects.new(f"copy {i}", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", cone
        empty.location, empty.scale = (i - 1, -1.5, 0.35), (1, 1, 1 + 0.5 * i)
        scene.collection.objects.link(empty)
    array = scenes.cube(scenes.matte("array", (0.7, 0.7, 0.2)), 0.3, (0.4, 0.2, 0.15))
    modifier = array.modifiers.new("array", "ARRAY")
    modifier.count, modifier.relative_offset_displace = 5, (0.8, 0, 1.1)
    modifier.show_viewport = False
    scenes.cube(scenes.matte("hidden", (1, 0, 0)), 3, (0, -1, 1)).hide_render = True
    bpy.ops.object.text_add(location=(0.5, -1, 1), rotation=(1.4, 0, 0))
    bpy.context.object.data.body = "text"
    scenes.camera()
    renders.assert_alike(renders.manylight(), renders.cycles())


def test_textures():
    scenes.empty(world=(0.5, 0.5, 0.5))
    made = scenes.matte("checked", (1, 1, 1))
    tree = made.node_tree
    image = bpy.data.images.new("checks", 64, 64)
    checks = np.indices((64, 64)).sum(0) // 1 % 2 * 0 + (np.indices((64, 64)) // 16).sum(0) % 2
    colors = np.where(checks[..., None] == 1, (0.9, 0.3, 0.2, 1.0), (0.1, 0.3, 0.8, 1.0))
    image.pixels.foreach_set(colors.astype(np.float32).ravel())
    image.pack()
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    tree.links.new(node.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Base Color"])
    scenes.plane(made, 4, (0, 0, 1), (math.radians(60), 0, 0))
    scenes.camera()
    renders.assert_alike(renders.manylight(), renders.cycles())
