"""Weighs the light groups of a picture by Blender's compositor and by `manylight relight`, and compares the results.

Usage: python relight.py MANYLIGHT IMAGE.exr NAME=R,G,B...

Prints the largest difference, and what both take. Needs `pip install bpy==5.0.1 OpenEXR numpy`.
"""

import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import bpy
import numpy as np
import OpenEXR

GROUP = "Combined_"


def channels(path):
    """Name -> (height, width)."""
    parts = OpenEXR.File(str(path), separate_channels=True).parts
    return {name: channel.pixels for part in parts for name, channel in part.channels.items()}


def composite(image, size, factors, target):
    """The weighed sum of the groups of `image` by nodes, written to `target`."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    tree = bpy.data.node_groups.new("relight", "CompositorNodeTree")
    scene.compositing_node_group = tree
    picture = tree.nodes.new("CompositorNodeImage")
    picture.image = bpy.data.images.load(str(image))

    def mix(kind, first, second):
        node = tree.nodes.new("ShaderNodeMix")
        node.data_type, node.blend_type, node.inputs["Factor"].default_value = "RGBA", kind, 1
        for socket, value in zip((s for s in node.inputs if s.type == "RGBA"), (first, second), strict=True):
            if isinstance(value, tuple):
                socket.default_value = (*value, 1)
            else:
                tree.links.new(value, socket)
        return next(s for s in node.outputs if s.type == "RGBA")

    total = None
    for output in [o for o in picture.outputs if o.name.startswith(GROUP)]:
        factor = factors.get(output.name.removeprefix(GROUP))
        weighed = output if factor is None else mix("MULTIPLY", output, factor)
        total = weighed if total is None else mix("ADD", total, weighed)
    tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    tree.links.new(total, tree.nodes.new("NodeGroupOutput").inputs[0])
    # A render needs a camera, although it shows nothing of the scene.
    scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(scene.camera)
    scene.render.engine = "BLENDER_WORKBENCH"
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = str(target)
    bpy.ops.render.render(write_still=True)


def main():
    program, image, *words = sys.argv[1:]
    pairs = (word.split("=") for word in words)
    factors = {name: tuple(map(float, numbers.split(","))) for name, numbers in pairs}
    height, width = channels(image)["R"].shape
    with tempfile.TemporaryDirectory() as folder:
        theirs, ours = (Path(folder) / f"{name}.exr" for name in ("theirs", "ours"))
        groups = [argument for word in words for argument in ("--group", word)]
        for target in (ours, ours.with_suffix(".png")):
            start = time.monotonic()
            subprocess.run([program, "relight", image, *groups, "-q", "-o", str(target)], check=True)
            print(f"manylight relight to {target.suffix}: {time.monotonic() - start:.2f} s")
        peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
        start = time.monotonic()
        composite(image, (width, height), factors, theirs)
        print(f"compositor to .exr: {time.monotonic() - start:.2f} s")
        print(f"peak memory: {peak:.0f} MB, of Blender {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB")
        a, b = channels(ours), channels(theirs)
        for name in "RGB":
            print(f"{name}: mean {b[name].mean():.6f}, largest difference {np.abs(a[name] - b[name]).max():.3g}")


if __name__ == "__main__":
    main()
