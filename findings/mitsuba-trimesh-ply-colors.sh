#!/usr/bin/env bash
# Vertex colors of a PLY file that trimesh 5.2.0 writes become reflectances of 255 in Mitsuba 3.9.1.
#
# PLY has no standard for colors; nearly all programs write `uchar red`, `green`, `blue`. Mitsuba recognizes the names as `vertex_color`,
# and scales no integers: 255 is 255. With `alpha`, which trimesh adds, a vertex has four values. A warning says that
# colors "are expected to be in the [0, 1] range"; the values stay.
#
# Seen: Mitsuba 3.9.1, trimesh 5.2.0: the color 255 128 0 255 is read as 255 128 0 255, four values for each of 8 vertices
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q mitsuba==3.9.1 trimesh==5.2.0 numpy
cd "$folder"
venv/bin/python - <<'PYTHON'
import mitsuba as mi
import numpy as np
import trimesh

mi.set_variant("scalar_rgb")
print("Mitsuba", mi.__version__, "trimesh", trimesh.__version__)
box = trimesh.creation.box()
box.visual.vertex_colors = [255, 128, 0, 255]
box.export("box.ply")
with open("box.ply", "rb") as file:
    print(*[line for line in file.read().split(b"end_header")[0].decode().splitlines() if "uchar" in line], sep="\n")
colors = np.array(mi.traverse(mi.load_dict({"type": "ply", "filename": "box.ply"}))["vertex_color"])
print(len(colors), "values; the first vertex has", colors[:4])
assert colors.tolist() == [255, 128, 0, 255] * 8, "the behaviour has changed"
PYTHON
