#!/usr/bin/env bash
# In Mitsuba 3.9.1, a specular part of a `blendbsdf` is too dark under emitters.
#
# A blend of a Lambertian surface of albedo 0.5 and of a perfect mirror, with the weight w of the mirror, reflects 0.5 (1 - w) + w of a uniform
# sky of radiance 1. The path tracer shows less. What the mirror gives is multiplied by about w / (w + 1/(4π)): the light that a specular
# sample finds gets the weight of multiple importance sampling against the density of the sky, 1/(4π), which no other sample makes up for.
# A blend with a rough conductor is right.
#
# Seen: Mitsuba 3.9.1: w = 0.2: 0.544 instead of 0.6; w = 0.5: 0.690 instead of 0.75; rough: 0.600 and 0.750
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
SCENE = """<scene version="3.0.0"><integrator type="path"/><sensor type="orthographic">
<transform name="to_world"><lookat origin="0, 0, 2" target="0, 0, 0" up="0, 1, 0"/></transform>
<film type="hdrfilm"><integer name="width" value="2"/><integer name="height" value="2"/><string name="pixel_format" value="rgb"/><rfilter type="box"/></film></sensor>
<shape type="rectangle"><bsdf type="blendbsdf"><float name="weight" value="{}"/>
<bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf>{}</bsdf></shape><emitter type="constant"/></scene>"""
MIRROR = '<bsdf type="conductor"/>'
ROUGH = '<bsdf type="roughconductor"><float name="alpha" value="0.3"/></bsdf>'
print("Mitsuba", mi.__version__)
for weight, seen in ((0.2, 0.544), (0.5, 0.690)):
    expected = 0.5 * (1 - weight) + weight
    mirror, rough = (float(np.array(mi.render(mi.load_string(SCENE.format(weight, bsdf)), spp=20000)).mean()) for bsdf in (MIRROR, ROUGH))
    print(f"w = {weight}: mirror {mirror:.3f}, rough conductor {rough:.3f}, expected {expected}")
    assert abs(mirror - seen) < 0.01 and abs(rough - expected) < 0.01, "the behaviour has changed"
PYTHON
