#!/usr/bin/env bash
# Mitsuba 3.9.1: `path` drops the radiance of a visible area light with the BSDF `null` where nothing is behind the light.
#
# Exporters give lamps the BSDF `null`, so that rays pass through them. `path` sees the radiance of such a lamp, goes on behind it, and, if the
# ray leaves the scene, counts the whole path as one that has met nothing: the pixel is black. With `max_depth` 1, by `direct`, and with a
# black wall behind the lamp, the lamp is seen. An empty background thus blackens lamps in front of it, and references of such scenes are too dark.
#
# Seen: radiance 5: path, max_depth 1: 5; path, max_depth 2: 0; path, no limit: 0; direct: 5; path, no limit, black wall behind: 5
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q mitsuba==3.9.1 numpy
"$folder/venv/bin/python" - <<'PYTHON'
import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
place = mi.ScalarTransform4f
lamp = {"type": "rectangle", "bsdf": {"type": "null"}, "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 5.0}}}
wall = {
    "type": "rectangle",
    "to_world": place().translate([0, 0, -3]).scale(50),
    "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}},
}
camera = {
    "type": "perspective",
    "to_world": place().look_at(origin=[0, 0, 4], target=[0, 0, 0], up=[0, 1, 0]),
    "fov": 10,
    "film": {"type": "hdrfilm", "width": 4, "height": 4, "rfilter": {"type": "box"}},
}


def pixel(integrator, **shapes):
    scene = mi.load_dict({"type": "scene", "camera": camera, "lamp": lamp, **shapes})
    return float(np.array(mi.render(scene, integrator=mi.load_dict(integrator), spp=16))[:, :, :3].mean())


print("Mitsuba", mi.__version__)
found = {
    "path, max_depth 1": pixel({"type": "path", "max_depth": 1}),
    "path, max_depth 2": pixel({"type": "path", "max_depth": 2}),
    "path, no limit": pixel({"type": "path"}),
    "direct": pixel({"type": "direct"}),
    "path, no limit, black wall behind": pixel({"type": "path"}, wall=wall),
}
for name, value in found.items():
    print(f"{name}: {value:.4g}")
assert [round(value, 3) for value in found.values()] == [5, 0, 0, 5, 5], "the behaviour has changed"
PYTHON
