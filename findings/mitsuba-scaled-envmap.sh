#!/usr/bin/env bash
# In Mitsuba 3.9.1, a scale in `to_world` of an `envmap` distorts the map.
#
# Directions are brought into the frame of the map without normalization. The polar angle is the arc cosine of a component of that
# vector, so that a uniform scale of 2 shows the part of the map around its equator in all directions, and never its poles.
# `perspective` and `thinlens` refuse scales; `directional` becomes brighter by them.
#
# Seen: Mitsuba 3.9.1: the pole of a map whose rows are 0, 1, ..., 8 is 0; with a scale of 2 it is 2.667, the row at 60 degrees
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q mitsuba==3.9.1 numpy
cd "$folder"
venv/bin/python - <<'PYTHON'
import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
print("Mitsuba", mi.__version__)
rows = np.broadcast_to(np.arange(9, dtype=np.float32)[:, None, None], (9, 16, 3))
bitmap = mi.Bitmap(np.ascontiguousarray(rows))
for scale in (1, 2):
    transform = mi.ScalarTransform4f().scale(scale)
    scene = mi.load_dict({"type": "scene", "sky": {"type": "envmap", "bitmap": bitmap, "to_world": transform}})
    interaction = mi.SurfaceInteraction3f()
    interaction.wi = [0, -1, 0]
    pole = float(scene.environment().eval(interaction)[0])
    print(f"scale {scale}: the pole is {pole:.3f}")
    assert abs(pole - (0 if scale == 1 else 8 / 3)) < 1e-3, "the behaviour has changed"
PYTHON
