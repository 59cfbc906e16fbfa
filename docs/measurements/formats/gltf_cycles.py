"""Renders a glTF file by Cycles, for comparison with `manylight render FILE -m path --filter box`.

Usage: python gltf_cycles.py FILE OUT.exr [--size WxH] [--spp N] [--environment FILE|white]

Needs the Python package bpy (Blender). Without a camera in the file, the camera is that of manylight. Without any emitter, the
environment is white, as in manylight.
"""

import argparse

from gltf_referee.by_cycles import Settings, read, render


def arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file")
    parser.add_argument("output")
    parser.add_argument("--size", default="480x270")
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--environment")
    return parser.parse_args()


def main():
    options = arguments()
    width, height = map(int, options.size.split("x"))
    read(options.file, Settings((width, height), options.spp, options.environment))
    render(options.output)


main()
