"""Opens an EXR file of manylight in Blender: as an image with layers, and its Cryptomatte in the compositor.

Usage: python blender.py FILE.exr NAME

Needs the Python packages bpy (Blender 5), OpenEXR, numpy and mmh3. The file must have been rendered with `--aov-names blender` and
the matte of objects. The compositor's Cryptomatte node selects the object NAME; its matte must be the decoded coverage.
"""

import glob
import sys
import tempfile

import bpy
import mmh3
import numpy as np
import OpenEXR


def composited(path, name, shape, folder):
    """Runs Blender's compositor: the matte of `name` and the image, as files in `folder`."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    image = bpy.data.images.load(path)
    scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    bpy.context.collection.objects.link(scene.camera)
    tree = bpy.data.node_groups.new("compositor", "CompositorNodeTree")
    scene.compositing_node_group = tree
    source = tree.nodes.new("CompositorNodeImage")
    source.image = image
    print("passes:", [output.name for output in source.outputs if output.enabled])
    print(f"image: {image.type}")
    crypto = tree.nodes.new("CompositorNodeCryptomatteV2")
    crypto.source = "IMAGE"
    crypto.image = image
    print("mattes:", [item.identifier for item in crypto.bl_rna.properties["layer_name"].enum_items])
    crypto.matte_id = name
    scene.render.resolution_y, scene.render.resolution_x = shape
    scene.render.resolution_percentage = 100
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 1
    output = tree.nodes.new("CompositorNodeOutputFile")
    output.directory, output.file_name = folder, "out"
    output.format.media_type = "MULTI_LAYER_IMAGE"
    output.format.color_depth = "32"
    output.file_output_items.new("FLOAT", "matte")
    output.file_output_items.new("RGBA", "combined")
    tree.links.new(crypto.outputs["Matte"], output.inputs["matte"])
    tree.links.new(source.outputs["Combined"], output.inputs["combined"])
    bpy.ops.render.render()
    channels = {}
    for part in OpenEXR.File(glob.glob(folder + "/out*.exr")[0], separate_channels=True).parts:
        channels |= {key: np.asarray(channel.pixels) for key, channel in part.channels.items()}
    return channels


def main(path, name):
    channels = {}
    for part in OpenEXR.File(path, separate_channels=True).parts:
        channels |= {key: np.asarray(channel.pixels) for key, channel in part.channels.items()}
    bits = mmh3.hash(name.encode(), signed=False)
    bits ^= 1 << 23 if bits >> 23 & 255 in (0, 255) else 0
    expected = np.zeros_like(channels["ViewLayer.Combined.R"])
    for level in range(3):
        for rank, coverage in (("r", "g"), ("b", "a")):
            ids = channels[f"ViewLayer.CryptoObject{level:02}.{rank}"].view(np.uint32)
            expected += np.where(ids == bits, channels[f"ViewLayer.CryptoObject{level:02}.{coverage}"], 0)
    assert expected.any(), f"no pixel shows {name}"
    with tempfile.TemporaryDirectory() as folder:
        found = composited(path, name, expected.shape, folder)
    print("composited:", sorted(found))
    (matte,) = (values for key, values in found.items() if key.startswith("matte"))
    print(f"matte of {name}: {expected.sum():.2f} pixels, in Blender {matte.sum():.2f},"
          f" largest difference {np.abs(matte - expected).max():.2g}")
    red = next(values for key, values in found.items() if key.startswith("combined") and key.endswith("R"))
    print(f"red channel: largest difference {np.abs(red - channels['ViewLayer.Combined.R']).max():.2g}")


main(*sys.argv[1:])
