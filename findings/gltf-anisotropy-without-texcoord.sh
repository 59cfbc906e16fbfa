#!/usr/bin/env bash
# gltf-transform 4.5.1 (`prune`, and so `optimize`) and gltfpack 1.3.0 drop the texture coordinates by which anisotropic highlights are oriented.
#
# Without TANGENT, the tangents of KHR_materials_anisotropy follow TEXCOORD_0. A material with constant anisotropy has no texture, so
# both tools take TEXCOORD_0 for unused. The extension stays; the direction of the highlight is then anybody's guess.
# `gltf-transform copy` keeps the coordinates, and so does gltfpack with `-kv`.
#
# Seen: @gltf-transform/cli 4.5.1, gltfpack 1.3.0: POSITION, NORMAL remain of POSITION, NORMAL, TEXCOORD_0
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund @gltf-transform/cli@4.5.1 gltfpack@1.3.0
export PATH="$folder/node_modules/.bin:$PATH"
python3 - <<'PYTHON'
import base64
import json
import struct

data = struct.pack("<12f", -1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0) + struct.pack("<12f", *[0, 0, 1] * 4)
data += struct.pack("<8f", 0, 1, 1, 1, 1, 0, 0, 0) + struct.pack("<6H", 0, 1, 2, 0, 2, 3)
views = [(0, 48), (48, 48), (96, 32), (128, 12)]
kinds = [("VEC3", 4, 5126), ("VEC3", 4, 5126), ("VEC2", 4, 5126), ("SCALAR", 6, 5123)]
accessors = [{"bufferView": i, "type": t, "count": n, "componentType": c} for i, (t, n, c) in enumerate(kinds)]
accessors[0] |= {"min": [-1, -1, 0], "max": [1, 1, 0]}
anisotropy = {"KHR_materials_anisotropy": {"anisotropyStrength": 0.9, "anisotropyRotation": 0.5}}
primitive = {"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3, "material": 0}
scene = {
    "asset": {"version": "2.0"},
    "extensionsUsed": ["KHR_materials_anisotropy"],
    "scene": 0,
    "scenes": [{"nodes": [0]}],
    "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [primitive]}],
    "materials": [{"pbrMetallicRoughness": {"metallicFactor": 1, "roughnessFactor": 0.4}, "extensions": anisotropy}],
    "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
    "bufferViews": [{"buffer": 0, "byteOffset": start, "byteLength": size} for start, size in views],
    "accessors": accessors,
}
with open("square.gltf", "w") as file:
    json.dump(scene, file)
PYTHON
gltf-transform copy square.gltf copy.gltf >log
gltf-transform prune square.gltf prune.gltf >>log
gltfpack -i square.gltf -o pack.gltf -noq >>log
gltfpack -i square.gltf -o keep.gltf -noq -kv >>log
python3 - <<'PYTHON'
import json

found = {}
for name in ("square", "copy", "prune", "pack", "keep"):
    with open(f"{name}.gltf") as file:
        scene = json.load(file)
    found[name] = sorted(scene["meshes"][0]["primitives"][0]["attributes"])
    print(f"{name}: {found[name]}, {scene['asset'].get('generator', '')}, {scene['extensionsUsed']}")
    assert "KHR_materials_anisotropy" in scene["extensionsUsed"], "the behaviour has changed"
for name, attributes in found.items():
    dropped = name in ("prune", "pack")
    assert ("TEXCOORD_0" in attributes) != dropped, "the behaviour has changed"
PYTHON
