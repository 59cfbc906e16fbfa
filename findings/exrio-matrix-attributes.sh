#!/usr/bin/env bash
# exrio 0.2.0 refuses every OpenEXR file with a matrix or a vector of three numbers among its attributes.
#
# `worldToCamera` and `worldToNDC` are standard attributes of OpenEXR, of the type m44f; renderers write them. exrio reads numbers, texts
# and pairs, and gives up the whole file for an attribute of another type, though the pixels need none of them.
#
# Seen: exrio 0.2.0, OpenEXR 3.4.4: "No matching attribute value serializer for world_to_camera"; without the attribute the file loads
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q exrio==0.2.0 OpenEXR==3.4.4 numpy
cd "$folder"
venv/bin/python - <<'PYTHON'
from importlib.metadata import version

import exrio
import numpy as np
import OpenEXR

print("exrio", version("exrio"), "OpenEXR", OpenEXR.__version__)
ATTRIBUTES = {"none": {}, "worldToCamera": {"worldToCamera": np.eye(4, dtype=np.float32)}, "a vector": {"place": np.array([1, 2, 3], np.float32)}}
found = {}
for words, attributes in ATTRIBUTES.items():
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage} | attributes
    OpenEXR.File(header, {"RGB": np.full((4, 4, 3), 0.5, np.float32)}).write("picture.exr")
    try:
        found[words] = f"{len(exrio.load('picture.exr').layers)} layer"
    except OSError as error:
        found[words] = str(error).split(". ")[0]
    print(f"attribute {words}: {found[words]}")
assert found["none"] == "1 layer", "the behaviour has changed"
assert all("No matching attribute value serializer" in found[words] for words in ("worldToCamera", "a vector")), "the behaviour has changed"
PYTHON
