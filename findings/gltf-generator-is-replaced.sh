#!/usr/bin/env bash
# gltf-transform 4.5.1 (every command, also `copy`) and gltfpack 1.3.0 put their names in the place of that of the exporter.
#
# Blender writes the lamps of its scenes in candela and lux, at 683 lm for a watt, but the emission of surfaces in its radiometric unit.
# A reader that knows Blender's files by `asset.generator` divides the former by 683. Of a rewritten file, it cannot know: lamps become
# 683 times brighter beside surfaces that emit.
#
# Seen: @gltf-transform/cli 4.5.1: "glTF-Transform v4.5.1"; gltfpack 1.3.0: "gltfpack 1.3"; the intensity is kept by both
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund @gltf-transform/cli@4.5.1 gltfpack@1.3.0
export PATH="$folder/node_modules/.bin:$PATH"
cat >lamp.gltf <<'JSON'
{
    "asset": { "version": "2.0", "generator": "Khronos glTF Blender I/O v5.0.21" },
    "extensionsUsed": ["KHR_lights_punctual"],
    "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point", "intensity": 2174.0565226352905 }] } },
    "scene": 0,
    "scenes": [{ "nodes": [0] }],
    "nodes": [{ "extensions": { "KHR_lights_punctual": { "light": 0 } } }]
}
JSON
gltf-transform copy lamp.gltf transform.gltf >log
gltfpack -i lamp.gltf -o pack.gltf >>log
python3 - <<'PYTHON'
import json

for name in ("transform", "pack"):
    with open(f"{name}.gltf") as file:
        scene = json.load(file)
    lights = scene["extensions"]["KHR_lights_punctual"]["lights"]
    print(f"{name}: {scene['asset']['generator']}, {lights}")
    assert "Blender" not in json.dumps(scene), "the behaviour has changed"
    assert abs(lights[0]["intensity"] / 2174.0565226352905 - 1) < 1e-6, "the behaviour has changed"
PYTHON
