# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes made in code, in an empty file each."""

import math

import bpy

SIZE = (64, 48)


def empty(world=(0.0, 0.0, 0.0)):
    """An empty scene with a world of one color, or none."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.render.resolution_percentage = 100
    scene.world = bpy.data.worlds.new("world")
    background(scene.world).inputs["Color"].default_value = (*world, 1)
    return scene


def background(world):
    return world.node_tree.nodes["Background"]


def principled(name, **inputs):
    """A principled material; `Base_Color` stands for the input `Base Color`."""
    made = bpy.data.materials.new(name)
    shader = made.node_tree.nodes["Principled BSDF"]
    for key, value in inputs.items():
        shader.inputs[key.replace("_", " ")].default_value = value
    return made


def matte(name, color):
    """A diffuse material without reflection, which means the same in Cycles and manylight."""
    return principled(name, Base_Color=(*color, 1), Specular_IOR_Level=0.0, Roughness=1.0)


def give(made):
    bpy.context.object.data.materials.append(made)
    return bpy.context.object


def plane(made, size, location=(0, 0, 0), rotation=(0, 0, 0)):
    bpy.ops.mesh.primitive_plane_add(size=size, location=location, rotation=rotation)
    return give(made)


def cube(made, size, location):
    bpy.ops.mesh.primitive_cube_add(size=size, location=location)
    return give(made)


def ball(made, radius, location):
    bpy.ops.mesh.primitive_uv_sphere_add(radius=radius, location=location, segments=64, ring_count=32)
    bpy.ops.object.shade_smooth()
    return give(made)


def stage():
    """A matte floor, a wall and a cube."""
    plane(matte("floor", (0.7, 0.6, 0.5)), 8)
    plane(matte("wall", (0.5, 0.6, 0.7)), 8, (0, 3, 2), (math.radians(90), 0, 0))
    cube(matte("cube", (0.8, 0.3, 0.2)), 1, (-1, 0.5, 0.5))


def lamp(kind, location=(1, -1, 3), rotation=(0, 0, 0), scale=(1, 1, 1), **settings):
    data = bpy.data.lights.new(kind.lower(), kind)
    for key, value in settings.items():
        setattr(data, key, value)
    made = bpy.data.objects.new(kind.lower(), data)
    made.location, made.rotation_euler, made.scale = location, rotation, scale
    bpy.context.collection.objects.link(made)
    return made


def camera(location=(0, -7, 3), rotation=(math.radians(72), 0, 0), **settings):
    data = bpy.data.cameras.new("camera")
    for key, value in ({"lens": 35} | settings).items():
        setattr(data, key, value)
    made = bpy.data.objects.new("camera", data)
    made.location, made.rotation_euler = location, rotation
    bpy.context.collection.objects.link(made)
    bpy.context.scene.camera = made
    return made
