# SPDX-License-Identifier: GPL-3.0-or-later
"""The world as an equirectangular image. One color is read from the nodes; every other world is baked by Cycles, so that
all nodes work: environment textures with their mapping, skies, gradients, mixtures."""

import math
import os

import bpy
import numpy as np

from . import sky
from .materials import source

DEFAULT_WIDTH = 1024
SMALLEST_WIDTH, FINE_WIDTH, LARGEST_WIDTH = 256, 2048, 4096
# Width in pixels for a sky with a sun disc.
SUN_WIDTH = 2048
# Samples of a pixel, and of a pixel near the sun.
SAMPLES, BRIGHT_SAMPLES = 4, 256
# Radiance over its median from which on a pixel belongs to a sun, and the largest part of the sky that is one.
BRIGHT, LARGEST_PART = 50.0, 0.05
MARGIN = 3  # pixels
# Color spaces of images whose values are linear already.
LINEAR = ("Linear Rec.709", "Non-Color", "Raw")


def radiance(world, folder, warn):
    """The radiance from around, (height, width, 3) with the first row on top; one pixel for a single color."""
    if world is None:
        return np.zeros((1, 1, 3), np.float32)
    drop_volume(world, warn)
    color = single_color(world)
    if color is not None:
        return np.array(color, np.float32).reshape(1, 1, 3)
    image = plain_image(world)
    if image is not None:
        return image
    nodes = list(used_nodes(world))
    if any(node.type == "LIGHT_PATH" for node in nodes):
        warn("the world depends on the kind of ray; what camera rays see lights the scene too")
    return baked(world, nodes, folder)


def drop_volume(world, warn):
    """Unlinks the volume, which would darken a baked image."""
    output = world.node_tree and world.node_tree.get_output_node("CYCLES")
    if output and output.inputs["Volume"].is_linked:
        warn("volumes of the world are not rendered", world.name)
        world.node_tree.links.remove(output.inputs["Volume"].links[0])


def single_color(world):
    """(r, g, b) of a world without a texture; None for others."""
    output = world.node_tree and world.node_tree.get_output_node("CYCLES")
    if output is None:
        return tuple(world.color)
    shader = source(output.inputs["Surface"])
    if shader is None:
        return (0.0, 0.0, 0.0)
    if shader.type != "BACKGROUND" or any(socket.is_linked for socket in shader.inputs):
        return None
    strength = shader.inputs["Strength"].default_value
    return tuple(strength * c for c in shader.inputs["Color"].default_value[:3])


def plain_image(world):
    """The pixels of an equirectangular, linear image that is the world as it is; None for others."""
    output = world.node_tree.get_output_node("CYCLES")
    shader = output and source(output.inputs["Surface"])
    if shader is None or shader.type != "BACKGROUND" or shader.inputs["Strength"].is_linked:
        return None
    texture = source(shader.inputs["Color"])
    if texture is None or texture.type != "TEX_ENVIRONMENT" or texture.inputs["Vector"].is_linked:
        return None
    image = texture.image
    if texture.projection != "EQUIRECTANGULAR" or has_mapping(texture.texture_mapping):
        return None
    if image is None or image.source not in ("FILE", "GENERATED"):
        return None
    if not image.is_float or image.colorspace_settings.name not in LINEAR or image.size[0] > LARGEST_WIDTH:
        return None
    return shader.inputs["Strength"].default_value * pixels_of(image)


def has_mapping(mapping):
    """Whether the mapping in a texture node changes directions."""
    vectors = (mapping.translation[:], mapping.rotation[:], mapping.scale[:])
    axes = (mapping.mapping_x, mapping.mapping_y, mapping.mapping_z)
    return vectors != ((0, 0, 0), (0, 0, 0), (1, 1, 1)) or axes != ("X", "Y", "Z")


def used_nodes(world):
    """All nodes of the world, those of groups included."""
    trees = [world.node_tree]
    for tree in trees:
        for node in tree.nodes:
            yield node
            if node.type == "GROUP" and node.node_tree and node.node_tree not in trees:
                trees.append(node.node_tree)


def width_of(nodes):
    """Width in pixels of the baked image: that of its largest texture; twice that for small ones, which resampling would blur."""
    textures = [node.image.size[0] for node in nodes if node.type in ("TEX_ENVIRONMENT", "TEX_IMAGE") and node.image]
    widths = [max(width, min(2 * width, FINE_WIDTH)) for width in textures]
    if any(node.type == "TEX_SKY" and getattr(node, "sun_disc", False) for node in nodes):
        widths.append(SUN_WIDTH)
    width = min(max([*widths, SMALLEST_WIDTH] if widths else [DEFAULT_WIDTH]), LARGEST_WIDTH)
    return width - width % 2


def baked(world, nodes, folder):
    """The image that a panoramic camera of Cycles sees in an empty scene. A small, bright part of the sky, a sun, is
    rendered again with more samples."""
    scene = panorama(world, width_of(nodes), folder)
    image = rendered(scene, SAMPLES)
    part = bright_part(image)
    if part is not None:
        rows, columns = part
        height, width = image.shape[:2]
        render = scene.render
        render.use_border, render.use_crop_to_border = True, False
        render.border_min_x, render.border_max_x = columns.start / width, columns.stop / width
        render.border_min_y, render.border_max_y = 1 - rows.stop / height, 1 - rows.start / height
        image[rows, columns] = rendered(scene, BRIGHT_SAMPLES)[rows, columns]
    return image


def bright_part(image):
    """Rows and columns around the pixels of a sun, as slices; None without one."""
    level = image.max(2)
    is_bright = level > BRIGHT * np.median(level)
    if not is_bright.any():
        return None
    part = tuple(around(np.flatnonzero(is_bright.any(axis)), length) for axis, length in zip((1, 0), level.shape))
    sizes = [s.stop - s.start for s in part]
    return part if sizes[0] * sizes[1] < LARGEST_PART * level.size else None


def around(indices, length):
    return slice(max(0, int(indices[0]) - MARGIN), min(length, int(indices[-1]) + 1 + MARGIN))


def panorama(world, width, folder):
    """A scene whose camera sees all of the world."""
    scene = bpy.data.scenes.new("world")
    scene.world = world
    lens = bpy.data.cameras.new("world")
    lens.type = "PANO"
    lens.panorama_type = "EQUIRECTANGULAR"
    camera = bpy.data.objects.new("world", lens)
    # Looks along +x with z up: the center of the image.
    camera.rotation_euler = (math.pi / 2, 0, -math.pi / 2)
    scene.collection.objects.link(camera)
    scene.camera = camera
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, width // 2, 100
    render.use_compositing = render.use_sequencer = False
    render.filepath = os.path.join(folder, "world.exr")
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    render.image_settings.color_mode = "RGB"
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.pixel_filter_type = "BOX"
    return scene


def rendered(scene, samples):
    scene.cycles.samples = samples
    bpy.ops.render.render(write_still=True, scene=scene.name)
    image = bpy.data.images.load(scene.render.filepath)
    image.colorspace_settings.name = "Non-Color"
    pixels = pixels_of(image)
    bpy.data.images.remove(image)
    return pixels


def pixels_of(image):
    """(height, width, 3), the first row on top."""
    width, height = image.size
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(height, width, image.channels)[::-1]
    return pixels[..., :3].copy() if image.channels >= 3 else pixels[..., :1].repeat(3, 2)


def with_suns(image, suns):
    """The image as the renderer takes it, with the discs of sun lamps; one pixel for a single color without suns."""
    if suns:
        image = sky.enlarged(image, sky.width_for_suns(suns))
    if image.shape[:2] == (1, 1):
        return image
    image = sky.with_poles(image)
    for sun in suns:
        sky.add_sun(image, sun)
    return image
