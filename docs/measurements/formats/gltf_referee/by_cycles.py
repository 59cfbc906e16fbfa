"""Renders a glTF file by Cycles as `manylight render FILE -m path --filter box` renders it."""

import math
from dataclasses import dataclass

import bpy
import mathutils


@dataclass
class Settings:
    """What a picture shows besides the file."""

    size: tuple[int, int]
    spp: int
    #: A file, `white` or `black`. Without one, the environment is white if nothing emits.
    environment: str | None = None
    seed: int = 0
    #: `None`: one per processor.
    threads: int | None = None


def emits(material):
    """Whether a material has an emission that is not black."""
    if not material or not material.use_nodes:
        return False
    for node in material.node_tree.nodes:
        if node.type == "BSDF_PRINCIPLED":
            color = node.inputs["Emission Color"]
            strength = node.inputs["Emission Strength"].default_value
            if strength > 0 and (color.is_linked or any(color.default_value[:3])):
                return True
        if node.type == "EMISSION":
            return True
    return False


def framing_camera():
    """The camera of manylight for files without one: see `cameras.rs`. Blender has z up; glTF's (x, y, z) is Blender's (x, -z, y)."""
    corners = [o.matrix_world @ mathutils.Vector(c) for o in bpy.data.objects if o.type == "MESH" for c in o.bound_box]
    low = mathutils.Vector([min(c[i] for c in corners) for i in range(3)])
    high = mathutils.Vector([max(c[i] for c in corners) for i in range(3)])
    center = 0.5 * (low + high)
    back = mathutils.Vector((0.35, -1.0, 0.25)).normalized()
    right = mathutils.Vector((0, 0, 1)).cross(back).normalized()
    up = back.cross(right)
    tan_y = math.tan(math.radians(20.0)) * 0.9
    tan_x = tan_y * 16.0 / 9.0
    distance = 0.0
    for i in range(8):
        c = mathutils.Vector([(high if i >> k & 1 else low)[k] for k in range(3)]) - center
        distance = max(distance, c.dot(back) + max(abs(c.dot(right)) / tan_x, abs(c.dot(up)) / tan_y))
    data = bpy.data.cameras.new("framing")
    data.sensor_fit = "VERTICAL"
    data.angle_y = math.radians(40.0)
    data.clip_start, data.clip_end = 1e-4, 1e6
    camera = bpy.data.objects.new("framing", data)
    camera.matrix_world = mathutils.Matrix.Translation(center + back * distance) @ mathutils.Matrix((right, up, back)).transposed().to_4x4()
    bpy.context.collection.objects.link(camera)
    return camera


def set_environment(scene, environment):
    world = bpy.data.worlds.new("environment")
    scene.world = world
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    if environment and environment not in ("white", "black"):
        image = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
        image.image = bpy.data.images.load(environment)
        world.node_tree.links.new(image.outputs["Color"], background.inputs["Color"])
        return
    level = 1.0 if environment == "white" else 0.0
    background.inputs["Color"].default_value = (level, level, level, 1.0)


def set_camera(scene):
    cameras = [o for o in bpy.data.objects if o.type == "CAMERA"]
    scene.camera = cameras[0] if cameras else framing_camera()
    # The scale of parallel rays is that of the longer edge, which the importer sets.
    if cameras and scene.camera.data.type != "ORTHO":
        # manylight keeps the vertical field of view.
        angle = scene.camera.data.angle_y
        scene.camera.data.sensor_fit = "VERTICAL"
        scene.camera.data.angle_y = angle


def set_sampling(scene, settings):
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = settings.size
    scene.render.resolution_percentage = 100
    if settings.threads:
        scene.render.threads_mode, scene.render.threads = "FIXED", settings.threads
    cycles = scene.cycles
    cycles.samples, cycles.seed = settings.spp, settings.seed
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    cycles.pixel_filter_type = "BOX"
    cycles.blur_glossy = 0.0
    cycles.sample_clamp_indirect = 0.0
    cycles.light_sampling_threshold = 0.0
    for name in ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces", "transparent_max_bounces"):
        setattr(cycles, name, 64)


def read(file, settings):
    """Makes the scene of the file that of Blender."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=file)
    scene = bpy.context.scene
    set_camera(scene)
    lit = any(o.type == "LIGHT" for o in bpy.data.objects)
    lit = lit or any(emits(s.material) for o in bpy.data.objects if o.type == "MESH" for s in o.material_slots)
    set_environment(scene, settings.environment or (None if lit else "white"))
    set_sampling(scene, settings)


def render(output):
    """Writes the picture of the scene as an EXR file."""
    scene = bpy.context.scene
    image = scene.render.image_settings
    image.file_format = "OPEN_EXR"
    image.color_depth = "32"
    scene.view_settings.view_transform = "Raw"
    scene.render.filepath = output
    bpy.ops.render.render(write_still=True)
