"""Makes a scene in Blender and exports it as glTF: dielectric, metal, glass; a point, a spot and a sun lamp; an emitting plane.

Usage: python gltf_scene.py OUT.glb [--diffuse]

With --diffuse, all surfaces are diffuse without reflection: then lamps and emission alone decide how bright the image is. Needs the Python
package bpy (Blender).
"""

import argparse
import math

import bpy


def arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("output")
    parser.add_argument("--diffuse", action="store_true")
    return parser.parse_args()


def give_material(name, diffuse, **inputs):
    """Gives the active object a principled material."""
    if diffuse:
        kept = ("Base_Color", "Emission_Color", "Emission_Strength")
        inputs = {key: value for key, value in inputs.items() if key in kept}
        inputs.update(Specular_IOR_Level=0.0, Roughness=1.0)
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    for key, value in inputs.items():
        shader.inputs[key.replace("_", " ")].default_value = value
    bpy.context.object.data.materials.append(material)


def add_lamp(kind, location, rotation=(0, 0, 0), **settings):
    data = bpy.data.lights.new(kind, kind)
    for key, value in settings.items():
        setattr(data, key, value)
    lamp = bpy.data.objects.new(kind, data)
    lamp.location = location
    lamp.rotation_euler = rotation
    bpy.context.collection.objects.link(lamp)


def add_ball(x):
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.8, location=(x, 0, 0.8), segments=64, ring_count=32)
    bpy.ops.object.shade_smooth()


def add_surfaces(diffuse):
    bpy.ops.mesh.primitive_plane_add(size=12)
    give_material("floor", diffuse, Base_Color=(0.6, 0.55, 0.5, 1), Roughness=0.6)
    bpy.ops.mesh.primitive_cube_add(size=1.2, location=(-2, 0, 0.6))
    give_material("red", diffuse, Base_Color=(0.7, 0.1, 0.08, 1), Roughness=0.3)
    add_ball(0)
    give_material("metal", diffuse, Base_Color=(0.9, 0.7, 0.3, 1), Metallic=1.0, Roughness=0.25)
    add_ball(2)
    give_material("glass", diffuse, Base_Color=(0.9, 1, 0.95, 1), Roughness=0.0, Transmission_Weight=1.0, IOR=1.5)
    bpy.ops.mesh.primitive_plane_add(size=1.5, location=(-1, 3, 2.5), rotation=(math.radians(70), 0, 0))
    give_material(
        "panel", diffuse, Base_Color=(0, 0, 0, 1), Emission_Color=(0.3, 0.6, 1, 1), Emission_Strength=6.0
    )


def add_lamps():
    add_lamp("POINT", (-3, -2, 3), energy=150, color=(1, 0.9, 0.8), shadow_soft_size=0)
    turned = (math.radians(35), 0, math.radians(50))
    cone = math.radians(60)
    add_lamp("SPOT", (3, -2, 4), turned, energy=600, spot_size=cone, spot_blend=0.4, shadow_soft_size=0)
    add_lamp("SUN", (0, 0, 5), (math.radians(40), math.radians(20), 0), energy=0.6, angle=0)


def add_camera():
    data = bpy.data.cameras.new("camera")
    data.lens = 35
    camera = bpy.data.objects.new("camera", data)
    camera.location = (0, -8, 3.5)
    camera.rotation_euler = (math.radians(70), 0, 0)
    bpy.context.collection.objects.link(camera)
    bpy.context.scene.camera = camera
    bpy.context.scene.render.resolution_x, bpy.context.scene.render.resolution_y = 480, 270


def main():
    options = arguments()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    add_surfaces(options.diffuse)
    add_lamps()
    add_camera()
    bpy.ops.export_scene.gltf(filepath=options.output, export_lights=True, export_cameras=True)


main()
