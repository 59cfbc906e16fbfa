#!/usr/bin/env bash
# SimpleImageIO 1.13.0 reads the integers of an OpenEXR file as the bits of floats.
#
# OpenEXR has three types of channels: HALF, FLOAT and UINT. SimpleImageIO takes the 32 bits of a UINT as a float, without a message: the
# value 7 becomes 9.81e-45, which looks like 0. Channels of the other types in the same file are right.
#
# Seen: SimpleImageIO 1.13.0, OpenEXR 3.4.4: R = 7 (UINT), G = 0.25 (FLOAT), B = 0.125 (HALF) are read as 9.81e-45 0.25 0.125
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q simpleimageio==1.13.0 OpenEXR==3.4.4 numpy
cd "$folder"
venv/bin/python - <<'PYTHON'
from importlib.metadata import version

import numpy as np
import OpenEXR
import simpleimageio

channels = {"R": np.full((4, 4), 7, np.uint32), "G": np.full((4, 4), 0.25, np.float32), "B": np.full((4, 4), 0.125, np.float16)}
OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, channels).write("ids.exr")
with OpenEXR.File("ids.exr", separate_channels=True) as file:
    print("OpenEXR", OpenEXR.__version__, {name: (channel.pixels.dtype.name, channel.pixels[0, 0].item()) for name, channel in file.channels().items()})
found = simpleimageio.read("ids.exr")[0, 0]
print("SimpleImageIO", version("simpleimageio"), found)
assert found[1] == 0.25 and found[2] == 0.125, "the behaviour has changed"
assert found[0] == np.uint32(7).view(np.float32), "the behaviour has changed"
PYTHON
