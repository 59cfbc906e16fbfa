# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes of view layers against those of Cycles."""

import math

import bpy
import numpy as np
import renders
import scenes


def stage():
    scenes.empty(world=(0.2, 0.3, 0.4))
    scenes.stage()
    scenes.ball(scenes.matte("ball", (0.2, 0.5, 0.3)), 0.6, (1, 0, 0.6))
    glow = scenes.principled("glow", Base_Color=(0.2, 0.2, 0.2, 1), Emission_Color=(1, 0.5, 0.2, 1), Emission_Strength=2.0)
    scenes.cube(glow, 0.4, (0.2, -1, 0.2))
    scenes.lamp("AREA", (0, -1, 2), (0.3, 0, 0), energy=80, size=0.8)
    scenes.camera(location=(0, -7, 2.5), rotation=(math.radians(76), 0, 0))


def inner(alpha):
    """Pixels whose whole neighborhood surfaces cover or leave free."""
    edges = np.zeros(alpha.shape, bool)
    for axis in (0, 1):
        change = np.abs(np.diff(alpha, axis=axis)) > 0.01
        pad = [(0, 0), (0, 0)]
        for before in (0, 1):
            pad[axis] = (before, 1 - before)
            edges |= np.pad(change, pad)
    return ~edges & ((alpha < 0.001) | (alpha > 0.999))


def test_depth_position_normal_albedo():
    stage()
    layer = bpy.context.view_layer
    layer.use_pass_z = layer.use_pass_position = layer.use_pass_normal = True
    layer.manylight.albedo = True
    layer.cycles.denoising_store_passes = True
    ours, theirs = renders.manylight(passes=4), renders.cycles(16)
    depth, reference = ours["Depth"][..., 0], theirs["Depth"][..., 0]
    covered = (reference < 1e9) & (depth < 1e9)
    assert np.mean(covered != (reference < 1e9)) < 0.02
    # Cycles takes depth and position from one sample; the median leaves edges out.
    assert np.median(np.abs(depth / reference - 1)[covered]) < 0.005
    assert np.median(np.abs(ours["Position"] - theirs["Position"])[covered]) < 0.01
    assert np.all(depth[~covered & (reference > 1e9) & (depth > 1e9)] == np.float32(1e10))
    assert np.median(np.abs(ours["Normal"] - theirs["Normal"])[covered]) < 0.01
    assert np.abs(ours["Normal"] - theirs["Normal"]).mean() < 0.02
    matte = covered & (ours["Denoising Albedo"].max(-1) > 0.05)
    albedo = np.abs(ours["Denoising Albedo"] - theirs["Denoising Albedo"])
    assert np.median(albedo[matte]) < 0.01


def test_terms_add_up_to_the_picture():
    stage()
    layer = bpy.context.view_layer
    layer.manylight.terms = True
    found = renders.manylight("rich-vpl", passes=4)
    names = ("emission", "direct", "virtual_lights", "compensation", "caustics")
    total = sum(found[name] for name in names)
    assert all(found[name].max() > 0 for name in ("emission", "direct", "virtual_lights"))
    surfaces = renders.manylight("rich-vpl", passes=4)
    assert np.array_equal(found["Combined"], surfaces["Combined"])
    # The sky behind all surfaces is no term: the lamp is hidden, so that the camera sees no emitter of the renderer.
    rest = renders.color(found) - total
    sky = np.array([0.2, 0.3, 0.4])
    assert rest.min() > -1e-3 and np.all(rest.max((0, 1)) < sky + 1e-3)
    assert np.allclose(rest[0, 0], sky, atol=1e-3)


def test_light_groups_are_those_of_cycles():
    stage()
    layer, scene = bpy.context.view_layer, bpy.context.scene
    for name in ("key", "glow", "sky", "empty"):
        layer.lightgroups.add(name=name)
    scenes.lamp("POINT", (2, -2, 2), energy=100)
    scene.objects["area"].lightgroup = "key"
    scene.objects["Cube.001"].lightgroup = "glow"
    scene.world.lightgroup = "sky"
    ours, theirs = renders.manylight("path"), renders.cycles()
    for name in ("key", "glow", "sky"):
        a, b = (found[f"Combined_{name}"] for found in (ours, theirs))
        ratios = a.mean((0, 1)) / b.mean((0, 1))
        print(name, ratios.round(4))
        assert np.abs(ratios - 1).max() < 0.02, f"{name}: {ratios}"
    assert ours["Combined_empty"].max() == 0
    # The point lamp is in no group.
    groups = sum(ours[f"Combined_{name}"] for name in ("key", "glow", "sky"))
    assert renders.color(ours).mean() > 1.05 * groups.mean()
