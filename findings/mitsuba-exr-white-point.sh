#!/usr/bin/env bash
# Mitsuba 3.9.1 converts the primaries of an OpenEXR file without adapting its white point, so grey becomes coloured.
#
# An OpenEXR file may name the primaries and the white of its colors (attribute `chromaticities`). Color tools convert such a file with
# a chromatic adaptation: equal R, G and B stay equal. Mitsuba converts by XYZ alone. A grey of 0.5 in ACEScg (white D60) becomes warm,
# both in `mi.Bitmap` and as a texture. Without the attribute, and with the chromaticities of Rec. 709, it stays grey.
#
# Seen: Mitsuba 3.9.1, OpenEXR 3.4.4: ACEScg 0.5 -> 0.5236 0.4973 0.4577; Rec. 709 0.5 -> 0.5 0.5 0.5
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q mitsuba==3.9.1 OpenEXR==3.4.4 numpy
cd "$folder"
venv/bin/python - <<'PYTHON'
import mitsuba as mi
import numpy as np
import OpenEXR

mi.set_variant("scalar_rgb")
SPACES = {
    "none": None,
    "Rec. 709": (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290),
    "ACEScg": (0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767),
}
print("Mitsuba", mi.__version__, "OpenEXR", OpenEXR.__version__)
found = {}
for name, chromaticities in SPACES.items():
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    if chromaticities:
        header["chromaticities"] = chromaticities
    OpenEXR.File(header, {"RGB": np.full((4, 4, 3), 0.5, np.float32)}).write("grey.exr")
    found[name] = np.array(mi.Bitmap("grey.exr"))[0, 0]
    print(f"chromaticities {name}: grey 0.5 is read as", found[name].round(4))
assert np.allclose(found["none"], 0.5) and np.allclose(found["Rec. 709"], 0.5, atol=1e-3)
assert np.allclose(found["ACEScg"], (0.5236, 0.4973, 0.4577), atol=1e-3), "the behaviour has changed"
PYTHON
