#!/usr/bin/env bash
# In Mitsuba 3.9.1's RGB variants, four ways to write an emission of 1 give two colors.
#
# A spectrum that is 1 at all wavelengths is not white in Rec. 709 (white is D65): it is (1.205, 0.948, 0.909). `<spectrum value="1"/>` on an
# emitter is converted so, which makes the light reddish. The plugin `uniform`, which is the same spectrum, and `<float>` and `<rgb>`
# give (1, 1, 1). On a reflectance, all of them are the same grey.
#
# Seen: Mitsuba 3.9.1: <spectrum value="1"/> 1.2048 0.9483 0.9089; uniform, <float>, <rgb> 1 1 1; as reflectance 1 1 1
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
<shape type="rectangle">{}</shape>{}</scene>"""
WAYS = {
    '<spectrum value="1"/>': '<spectrum name="{}" value="1"/>',
    "plugin uniform": '<spectrum name="{}" type="uniform"><float name="value" value="1"/></spectrum>',
    "<float>": '<float name="{}" value="1"/>',
    "<rgb>": '<rgb name="{}" value="1"/>',
}
print("Mitsuba", mi.__version__)


def color(shape: str, light: str = "") -> np.ndarray:
    return np.array(mi.render(mi.load_string(SCENE.format(shape, light)), spp=64)).mean((0, 1))


for words, way in WAYS.items():
    emitted = color(f'<emitter type="area">{way.format("radiance")}</emitter>')
    sky = '<emitter type="constant"><rgb name="radiance" value="1"/></emitter>'
    reflected = color(f'<bsdf type="diffuse">{way.format("reflectance")}</bsdf>', sky)
    print(f"{words}: emission {emitted.round(4)}, reflectance {reflected.round(2)}")
    expected = (1.2048, 0.9483, 0.9089) if words.startswith("<spectrum") else (1, 1, 1)
    assert np.allclose(emitted, expected, atol=1e-3), "the behaviour has changed"
    assert np.allclose(reflected, 1, atol=0.02), "the behaviour has changed"
PYTHON
