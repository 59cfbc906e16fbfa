# SPDX-License-Identifier: GPL-3.0-or-later
"""What a render of a scene sees: a render engine that takes meshes, lamps and the camera from Blender's dependency graph,
with render visibility, modifiers at their render settings, and all instances. Runs in the background Blender."""

import math

import bpy
import numpy as np

from .cameras import Camera
from .lamps import Lamp

MESH_LIKE = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
UNSUPPORTED = {
    "CURVES": "hair curves",
    "VOLUME": "volumes",
    "POINTCLOUD": "point clouds",
    "GREASEPENCIL": "grease pencil objects",
}
RAYS = ("visible_camera", "visible_diffuse", "visible_glossy", "visible_transmission", "visible_shadow")
# Largest difference of matrix elements, relative to the greatest, up to which a transform has no shear.
SHEAR = 1e-5


class Collected:
    """The content of a view layer."""

    def __init__(self):
        self.placed = []  # (name, mesh, matrix, light group)
        self.lamps = []
        self.camera = None
        self.frame = None
        self.world = None
        self.has_groups = False  # whether the view layer has light groups
        self.error = None
        self.warnings = {}  # message -> name of the first, or None

    def warn(self, message, first=None):
        """Warns once for each message, and names the first object or material that it is about."""
        self.warnings.setdefault(message, first)


def collect(scene, view_layer, size):
    """Renders `view_layer` of `scene` with an engine that collects. `size`: the picture in pixels."""
    result = Collected()

    class Collector(bpy.types.RenderEngine):
        bl_idname = "MANYLIGHT_COLLECTOR"
        bl_label = "manylight collector"

        def render(self, depsgraph):
            if depsgraph.view_layer.name == view_layer:
                take(depsgraph, size, result)

    bpy.utils.register_class(Collector)
    scene.render.engine = Collector.bl_idname
    scene.render.use_compositing = scene.render.use_sequencer = False
    scene.render.use_border = False
    scene.render.use_multiview = False
    try:
        bpy.ops.render.render(scene=scene.name, layer=view_layer)
    finally:
        bpy.utils.unregister_class(Collector)
    return result


def take(depsgraph, size, result):
    scene = depsgraph.scene_eval
    result.frame = scene.frame_current
    meshes = {}
    override = depsgraph.view_layer_eval.material_override
    for instance in depsgraph.object_instances:
        item = instance.object
        if not instance.show_self and not instance.is_instance:
            continue
        warn_about(item, result)
        matrix = np.array(instance.matrix_world, np.float64)
        if item.type == "LIGHT":
            add_lamp(item, matrix, result)
        elif item.type in MESH_LIKE:
            key = (item.data.as_pointer(), tuple(slot.material for slot in item.material_slots))
            if key not in meshes:
                meshes[key] = mesh_of(item, depsgraph, override)
            if meshes[key] is not None:
                result.placed.append((item.name, meshes[key], matrix, item.lightgroup))
        elif item.type in UNSUPPORTED:
            result.warn(f"{UNSUPPORTED[item.type]} are not rendered", item.name)
    result.world = scene.world and scene.world.original
    result.has_groups = len(depsgraph.view_layer_eval.lightgroups) > 0
    add_camera(depsgraph, size, result)
    if scene.render.use_motion_blur:
        result.warn("motion blur is ignored")


def warn_about(item, result):
    if item.type in MESH_LIKE and not all(getattr(item, ray) for ray in RAYS):
        result.warn("ray visibility of objects is ignored", item.name)
    if item.type in MESH_LIKE and (item.is_holdout or item.is_shadow_catcher):
        result.warn("holdouts and shadow catchers are rendered as usual surfaces", item.name)
    if any(system.settings.type == "HAIR" and system.settings.render_type == "PATH" for system in item.particle_systems):
        result.warn("particle hair is not rendered", item.name)


def mesh_of(item, depsgraph, override):
    """The evaluated mesh of an object with the materials that its slots show; None without polygons."""
    mesh = bpy.data.meshes.new_from_object(item, preserve_all_data_layers=True, depsgraph=depsgraph)
    if mesh is None or not mesh.polygons:
        return None
    if override:
        mesh.materials.clear()
        mesh.materials.append(override.original)
        return mesh
    for i, slot in enumerate(item.material_slots):
        material = slot.material and slot.material.original
        if i < len(mesh.materials):
            mesh.materials[i] = material
        else:
            mesh.materials.append(material)
    return mesh


def add_lamp(item, matrix, result):
    light = item.data
    if light.type == "AREA" and light.cycles.is_portal:
        return
    color = np.array(light.color[:])
    if light.use_temperature:
        color = color * np.array(light.temperature_color[:])
    lamp = Lamp(
        name=item.name,
        kind=light.type,
        matrix=matrix,
        energy=light.energy * 2.0**light.exposure,
        color=tuple(color * shader_factor(light, result)),
        normalize=light.normalize,
        is_seen=item.visible_camera,
        group=item.lightgroup,
    )
    if light.type in ("POINT", "SPOT"):
        lamp.radius = light.shadow_soft_size
    if light.type == "SPOT":
        lamp.spot_size, lamp.spot_blend = light.spot_size, light.spot_blend
        if light.shadow_soft_size > 0:
            result.warn("spot lamps with a radius are replaced by points on a disc", item.name)
        if not is_uniform(matrix):
            result.warn("the cone of a scaled spot lamp is rendered round", item.name)
    if light.type == "SUN":
        lamp.angle = light.angle
    if light.type == "AREA":
        lamp.shape, lamp.size, lamp.size_y = light.shape, light.size, light.size_y
        if light.spread < math.radians(179.9):
            result.warn("the spread of area lamps is ignored: they emit into all directions", item.name)
    if not light.use_shadow:
        result.warn("lamps without shadows cast shadows", item.name)
    if not all(getattr(item, ray) for ray in RAYS if ray != "visible_camera"):
        result.warn("ray visibility of lamps is ignored", item.name)
    result.lamps.append(lamp)


def shader_factor(light, result):
    """Factor of a lamp's color by its emission node."""
    if not light.use_nodes or light.node_tree is None:
        return np.ones(3)
    output = light.node_tree.get_output_node("CYCLES")
    links = output.inputs["Surface"].links if output else ()
    node = links[0].from_node if links else None
    if node is None:
        return np.zeros(3)
    if node.type != "EMISSION" or any(socket.is_linked for socket in node.inputs):
        result.warn("shader nodes of lamps other than one emission node are ignored", light.name)
        return np.ones(3)
    return np.array(node.inputs["Color"].default_value[:3]) * node.inputs["Strength"].default_value


def is_uniform(matrix):
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    return np.ptp(lengths) <= 1e-3 * lengths.max()


def cameras_of_frames(scene, frames, size, result):
    """The camera at each of the frames, which all have the lens of the collected one; none after an error."""
    cameras = []
    for frame in frames:
        scene.frame_set(frame)
        here = Collected()
        add_camera(bpy.context.evaluated_depsgraph_get(), size, here)
        if here.error:
            result.error = f"frame {frame}: {here.error}"
            return []
        if not np.allclose(here.camera.projection, result.camera.projection, rtol=1e-4, atol=1e-5):
            result.error = (
                f"the lens of the camera differs between the frames {frame} and {result.frame}: in a walkthrough, nothing but "
                "the place of the camera may change"
            )
            return []
        cameras.append(here.camera)
    return cameras


def add_camera(depsgraph, size, result):
    scene = depsgraph.scene_eval
    item = scene.camera
    if item is None or item.type != "CAMERA":
        result.error = "the scene has no camera"
        return
    lens = item.data
    if lens.type not in ("PERSP", "ORTHO"):
        result.error = (
            f"the camera `{item.name}` is of type {lens.type}; manylight renders perspective (PERSP) and orthographic "
            "(ORTHO) cameras"
        )
        return
    if lens.dof.use_dof:
        result.warn("depth of field is ignored")
    render = scene.render
    projection = item.calc_matrix_camera(
        depsgraph, x=size[0], y=size[1], scale_x=render.pixel_aspect_x, scale_y=render.pixel_aspect_y
    )
    result.camera = Camera(
        name=item.name,
        is_orthographic=lens.type == "ORTHO",
        matrix=np.array(item.matrix_world, np.float64),
        projection=np.array(projection, np.float64),
        clip_start=lens.clip_start,
        clip_end=lens.clip_end,
    )


def messages(warnings):
    """Warnings as text."""
    return [f"{message} (first: `{first}`)" if first else message for message, first in warnings.items()]


def has_shear(matrix, recomposed):
    return np.abs(matrix - recomposed).max() > SHEAR * np.abs(matrix).max()
