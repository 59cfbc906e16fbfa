# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports a scene in a background Blender: `worker.py REQUEST.json`, a file that `launch` writes.

Writes `scene.glb`, the images of the world, and `result.json` into the folder of the request. Nothing that happens here
reaches the user's file.
"""

import json
import os
import sys
import traceback

import bpy
import mathutils
import numpy as np

sys.path.append(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

from manylight_export import cameras, collect, exr, materials, shells, world  # noqa: E402
from manylight_export.glb import Glb  # noqa: E402
from manylight_export.lamps import PUNCTUAL, SMALLEST_SUN, LampWriter, group_extras  # noqa: E402

EXPORTED = dict(
    export_format="GLB",
    use_active_scene=True,
    export_lights=False,
    export_cameras=False,
    export_animations=False,
    export_skins=False,
    export_morph=False,
    export_apply=False,
    export_extras=False,
    export_yup=True,
    export_tangents=False,
    export_materials="EXPORT",
    export_image_format="AUTO",
)


class ExportError(Exception):
    """What the user has to change, in words."""


def main(path):
    with open(path) as file:
        request = json.load(file)
    folder = os.path.dirname(os.path.abspath(path))
    try:
        result = export(request, folder)
    except ExportError as error:
        result = {"error": str(error)}
    except Exception:
        result = {"error": "the export failed:\n" + traceback.format_exc()}
    with open(os.path.join(folder, "result.json"), "w") as file:
        json.dump(result, file)


def export(request, folder):
    scene = load(request)
    size = tuple(request["size"])
    found = collect.collect(scene, request["view_layer"], size)
    if found.error:
        raise ExportError(found.error)
    if found.camera is None:
        raise ExportError(f"the view layer `{request['view_layer']}` was not rendered")
    if abs(cameras.pixel_aspect(found.camera, size) - 1) > 1e-3:
        found.warn("pixels are rendered square, whatever the aspect ratio of pixels")
    film = cameras.film(found.camera, size, request["border"])
    walk = []
    if request["frames"]:
        first, last = request["frames"]
        walk = collect.cameras_of_frames(scene, range(first, last + 1), size, found)
        if found.error:
            raise ExportError(found.error)
    glb_path = os.path.join(folder, "scene.glb")
    groups = export_meshes(found, glb_path)
    glb = Glb.read(glb_path)
    for node in glb.json.get("nodes", []):
        node["extras"] = group_extras(groups.get(node.get("name")))
    emitting = {i for i, material in enumerate(glb.json.get("materials", [])) if shells.emits(material)}
    writer = LampWriter(glb)
    for lamp in found.lamps:
        writer.add(lamp)
    world_group = found.world.lightgroup if found.world else ""
    if found.has_groups:
        warn_about_suns(found, world_group)
    has_hidden = writer.hidden > 0 or not all(sun.is_seen for sun in writer.suns)
    hides = has_hidden or scene.render.film_transparent or not camera_sees(found.world) or request["needs_coverage"]
    if hides:
        shells.add_shells(glb, emitting | writer.seen)
    # The file of a walkthrough is the same in all frames.
    cameras.add_camera(glb, walk[0] if walk else found.camera, size, film)
    glb.write(glb_path)
    view = Glb.empty()
    cameras.add_camera(view, found.camera, size, film)
    view.write(os.path.join(folder, "background.glb"))
    sky = world.radiance(found.world, folder, found.warn)
    return {
        "warnings": collect.messages(found.warnings),
        "hide_emitters": hides,
        "environment": lighting(glb, sky, writer.suns, folder),
        **background(sky, writer.suns, scene, found.world, folder),
        "size": film.size,
        "window": film.window,
        "camera": found.camera.matrix.tolist(),
        "cameras": cameras.of_frames(walk),
        "world_group": world_group,
    }


def warn_about_suns(found, world_group):
    for lamp in found.lamps:
        if lamp.kind == "SUN" and lamp.angle >= SMALLEST_SUN and lamp.group != world_group:
            found.warn("sun lamps of an angle from 0.2 degrees on have the light group of the world", lamp.name)


def load(request):
    """The scene of the request, at its frame, in an empty file: so that its names stay."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(request["blend"]) as (_, wanted):
        wanted.scenes = [request["scene"]]
    scene = wanted.scenes[0]
    bpy.context.window.scene = scene
    scene.frame_set(request["frame"], subframe=request["subframe"])
    if request.get("camera"):
        scene.camera = scene.objects[request["camera"]]
        for marker in scene.timeline_markers:
            marker.camera = None
    scene.render.resolution_x, scene.render.resolution_y = request["size"]
    scene.render.resolution_percentage = 100
    return scene


def export_meshes(found, path):
    """Writes what was collected by Blender's glTF exporter, from a scene made for it. The light groups of its nodes, by name."""
    scene = bpy.data.scenes.new("export")
    used, groups = {}, {}
    fallback = None
    for name, mesh, matrix, group in found.placed:
        if not mesh.materials:
            fallback = fallback or materials.default_material()
            mesh.materials.append(fallback)
        for i, material in enumerate(mesh.materials):
            if material is None:
                fallback = fallback or materials.default_material()
                mesh.materials[i] = fallback
            else:
                used[material.name_full] = material
        groups[place(scene, name, mesh, matrix)] = group
    for material in used.values():
        materials.prepare(material, found.warn)
    bpy.context.window.scene = scene
    bpy.ops.export_scene.gltf(filepath=path, **EXPORTED)
    return groups


def place(scene, name, mesh, matrix):
    """Adds an object; its name, of which there is one in the file."""
    transform = mathutils.Matrix(matrix)
    item = bpy.data.objects.new(name, mesh)
    location, rotation, scale = transform.decompose()
    recomposed = mathutils.Matrix.LocRotScale(location, rotation, scale)
    if collect.has_shear(matrix, np.array(recomposed)):
        # Nodes of glTF files have no shear.
        item.data = mesh.copy()
        item.data.transform(transform)
        if transform.determinant() < 0:
            item.data.flip_normals()
    else:
        item.matrix_world = transform
    scene.collection.objects.link(item)
    return item.name


def lighting(glb, sky, suns, folder):
    """The image of the environment with the discs of suns: its path, or None if there is none."""
    image = world.with_suns(sky, suns)
    if not image.any() and has_light(glb):
        return None
    # A black one as well: the loader lights files without light by a white environment.
    return write_image(image, folder, "environment.exr")


def has_light(glb):
    """Whether the file has a light, or a surface that emits one color: what the loader counts as light."""
    plain = (shells.emits(m) and "emissiveTexture" not in m for m in glb.json.get("materials", []))
    return bool(glb.json.get("extensions", {}).get(PUNCTUAL)) or any(plain)


def background(sky, suns, scene, shown_world, folder):
    """What the camera sees behind all surfaces: the path of an image, or a color."""
    if scene.render.film_transparent or not camera_sees(shown_world):
        return {"background": None, "background_color": [0.0, 0.0, 0.0]}
    seen = world.with_suns(sky, [sun for sun in suns if sun.is_seen])
    if seen.shape[:2] == (1, 1):
        return {"background": None, "background_color": seen[0, 0].tolist()}
    return {"background": write_image(seen, folder, "background.exr"), "background_color": None}


def camera_sees(shown_world):
    return shown_world is not None and shown_world.cycles_visibility.camera


def write_image(image, folder, name):
    """Writes an image of the sky; its path."""
    if image.shape[:2] == (1, 1):
        image = np.broadcast_to(image, (2, 4, 3))
    path = os.path.join(folder, name)
    exr.write(path, np.maximum(image, 0))
    return path


if __name__ == "__main__":
    main(sys.argv[-1])
