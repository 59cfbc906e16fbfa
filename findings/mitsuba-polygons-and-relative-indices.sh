#!/usr/bin/env bash
# Mitsuba 3.9.1 reads polygons from OBJ files, but not from PLY files; and of OBJ's two kinds of indices it reads one.
#
# The same square as one face of four corners loads as OBJ (two triangles), and is refused as PLY, where faces are lists of any length.
# Indices below zero, by which the OBJ format counts back from the last vertex, are taken as unsigned numbers and refused.
#
# Seen: Mitsuba 3.9.1: OBJ 2 faces; PLY "incompatible contents -- is this a triangle mesh?"; "reference to invalid vertex 4294967292"
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q mitsuba==3.9.1 numpy
cd "$folder"
venv/bin/python - <<'PYTHON'
import struct

import mitsuba as mi

CORNERS = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
VERTICES = "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS)
HEADER = """ply
format binary_little_endian 1.0
element vertex 4
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
"""
with open("square.obj", "w") as file:
    file.write(VERTICES + "f 1 2 3 4\n")
with open("relative.obj", "w") as file:
    file.write(VERTICES + "f -4 -3 -2\n")
with open("square.ply", "wb") as file:
    file.write(HEADER.encode() + b"".join(struct.pack("<3f", *corner) for corner in CORNERS) + struct.pack("<B4i", 4, 0, 1, 2, 3))
mi.set_variant("scalar_rgb")
print("Mitsuba", mi.__version__)


def load(file: str) -> str:
    try:
        mesh = mi.load_dict({"type": file.split(".")[1], "filename": file})
        return f"{mesh.face_count()} faces"
    except RuntimeError as error:
        return str(error).strip().split("\n")[-1]


found = {file: load(file) for file in ("square.obj", "square.ply", "relative.obj")}
print(*(f"{file}: {result}" for file, result in found.items()), sep="\n")
assert found["square.obj"] == "2 faces", "the behaviour has changed"
assert "is this a triangle mesh" in found["square.ply"], "the behaviour has changed"
assert "invalid vertex 4294967292" in found["relative.obj"], "the behaviour has changed"
PYTHON
