#!/usr/bin/env bash
# A rotation of Mitsuba 3.9.1 about an axis that is no unit vector is no rotation.
#
# Version 0.6 normalized the axis of `<rotate>`. Version 3 puts it into Rodrigues' formula as it is, without a message: about (1, 1, 0) by 30
# degrees, the matrix has the determinant 1.417 and shears. Old scenes that are loaded by version 3 change their shapes.
#
# Seen: Mitsuba 3.9.1: determinant 1 for the axis (0.7071, 0.7071, 0), 1.4175 for (1, 1, 0), both in Python and in XML of version 0.6.0
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


def determinant(x: float, y: float) -> float:
    return float(np.linalg.det(np.array(mi.ScalarTransform4f().rotate([x, y, 0], 30).matrix)))


XML = """<scene version="0.6.0"><shape type="rectangle"><transform name="toWorld"><rotate x="1" y="1" angle="30"/></transform></shape></scene>"""
corners = np.array(mi.traverse(mi.load_string(XML).shapes()[0])["to_world"].matrix)[:3, :3]
unit, sheared, loaded = determinant(0.5**0.5, 0.5**0.5), determinant(1, 1), float(np.linalg.det(corners))
print(f"unit axis {unit:.4f}, axis (1, 1, 0) {sheared:.4f}, the same from XML of 0.6.0 {loaded:.4f}")
assert abs(unit - 1) < 1e-4 and abs(sheared - 1.4175) < 1e-3 and abs(loaded - sheared) < 1e-3, "the behaviour has changed"
PYTHON
