# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders of the current scene by Cycles and by manylight, and comparisons of them."""

import os
import tempfile

import bpy
import numpy as np
import OpenEXR

BLOCKS = 8


def manylight(method="path", passes=128, **settings):
    """The layers of a render by manylight: name -> (height, width, channels)."""
    scene = bpy.context.scene
    scene.render.engine = "MANYLIGHT"
    scene.manylight.method, scene.manylight.passes = method, passes
    for key, value in settings.items():
        setattr(scene.manylight, key, value)
    return rendered(scene)


def cycles(samples=128):
    """The same by Cycles, with settings that make its picture the physical one."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    settings = scene.cycles
    settings.device = "CPU"
    settings.samples, settings.seed = samples, 1
    settings.use_adaptive_sampling = settings.use_denoising = False
    settings.pixel_filter_type = "BOX"
    settings.blur_glossy = 0.0
    settings.sample_clamp_direct = settings.sample_clamp_indirect = 0.0
    settings.light_sampling_threshold = 0.0
    for name in ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces", "transparent_max_bounces"):
        setattr(settings, name, 64)
    return rendered(scene)


def rendered(scene):
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "picture.exr")
        output = scene.render.image_settings
        output.media_type = "MULTI_LAYER_IMAGE"
        output.file_format = "OPEN_EXR_MULTILAYER"
        output.color_depth = "32"
        scene.render.filepath = path
        bpy.ops.render.render(write_still=True)
        return layers(path)


def layers(path):
    """The passes of a file: name without the view layer -> (height, width, channels)."""
    found = {}
    for part in OpenEXR.File(path, separate_channels=True).parts:
        for name, channel in part.channels.items():
            *_, layer, letter = name.split(".")
            found.setdefault(layer, {})[letter] = np.asarray(channel.pixels, np.float32)
    order = "RGBAXYZV"
    return {
        layer: np.stack([letters[letter] for letter in sorted(letters, key=order.index)], -1)
        for layer, letters in found.items()
    }


def color(result):
    return result["Combined"][..., :3]


def blocks(image):
    """Means over BLOCKS x BLOCKS parts of the picture."""
    height, width = (edge - edge % BLOCKS for edge in image.shape[:2])
    cut = image[:height, :width]
    return cut.reshape(BLOCKS, height // BLOCKS, BLOCKS, width // BLOCKS, -1).mean((1, 3))


def assert_alike(ours, theirs, mean=0.02, block=0.06, outliers=0):
    """Asserts that means agree by channel within the part `mean`, and all but `outliers` parts of the picture within `block`
    of them, or of half the mean where they are darker."""
    ours, theirs = color(ours), color(theirs)
    assert ours.shape == theirs.shape
    ratios = ours.mean((0, 1)) / theirs.mean((0, 1))
    print("ratios of the means", ratios.round(4))
    assert np.abs(ratios - 1).max() < mean, f"ratios of the means {ratios}"
    a, b = blocks(ours), blocks(theirs)
    differences = (np.abs(a - b) / np.maximum(b, 0.5 * b.mean((0, 1)))).max(-1)
    far = np.argwhere(differences >= block)
    print("largest difference of a part", differences.max().round(4), "parts beyond the limit", len(far))
    message = [f"part {part}: {a[tuple(part)]} and in Cycles {b[tuple(part)]}" for part in far]
    assert len(far) <= outliers, "\n".join(message)
