"""Scenes in which one number at a time is replaced by NaN, infinities, 0, negative and huge values: plain data for scene_faults.py."""

import json
import re
from collections.abc import Iterator

from hard_scenes import Space, bsdf, diffuse, glossy, number, rgb, room, steps, things, walls

WORDS = ("nan", "inf", "-inf", "0", "-1", "1e30", "-1e30", "1e-30", "1e39")


def mitsuba_scene() -> str:
    """A scene with most kinds of emitters and materials, small."""
    here = Space()
    board = f'<texture type="checkerboard">{rgb("color0", 0.1)}{rgb("color1", 0.6)}<transform name="to_uv"><scale x="3" y="4"/></transform></texture>'
    lit = lambda kind, *content: f'<emitter type="{kind}">{"".join(content)}</emitter>'  # noqa: E731
    at = '<point name="position" value="0.1, 1.6, 0.2"/>'
    look = '<transform name="to_world"><lookat origin="0.5, 1.8, 0" target="0, 0, 0.1" up="0, 0, 1"/></transform>'
    lights = (
        lit("point", at, rgb("intensity", 0.5)),
        lit("spot", look, rgb("intensity", 2), number("cutoff_angle", 40), number("beam_width", 20)),
        lit("directional", '<vector name="direction" value="0.1, -1, -0.2"/>', rgb("irradiance", 0.3)),
        lit("constant", rgb("radiance", 0.2)),
    )
    uber = bsdf("principled", rgb("base_color", "0.8, 0.5, 0.3"), number("roughness", 0.4), number("metallic", 0.5), number("clearcoat", 0.5))
    glass = bsdf("roughdielectric", number("alpha", 0.2), number("int_ior", 1.5), number("ext_ior", 1.0))
    more = (
        here.shape("sphere", steps(move="0.5, 0.2, 0.4"), glass, number("radius", 0.2), '<point name="center" value="0, 0.1, 0"/>'),
        here.shape("disk", steps(scale="0.2, 0.2, 0.2", move="-0.6, 0.5, 0.3"), bsdf("plastic", number("int_ior", 1.4))),
        here.shape("cylinder", "", diffuse(), number("radius", 0.1), '<point name="p0" value="0.8, 0, 0"/><point name="p1" value="0.8, 1, 0.1"/>'),
    )
    view = here.camera((0.1, 1.0, 0.95), (0, 0.8, -1), kind="thinlens", more=number("aperture_radius", 0.01) + number("focus_distance", 1.5))
    view = view.replace('<rfilter type="box"/>', f'<rfilter type="gaussian">{number("stddev", 0.5)}</rfilter>')
    floor = {"floor": bsdf("diffuse", board.replace('type="checkerboard"', 'type="checkerboard" name="reflectance"')), "ceiling": glossy(0.3)}
    return room(camera=view, walls=walls(here, floor, left_out=("front",)), things=things(here, ball=uber), more="\n".join((*lights, *more)))


PBRT = """Film "rgb" "integer xresolution" [64] "integer yresolution" [64] "string filename" "x.exr"
LookAt 0.1 1 3  0 0.8 -1  0 1 0
Camera "perspective" "float fov" [60] "float lensradius" [0.01] "float focaldistance" [3]
WorldBegin
LightSource "infinite" "rgb L" [0.2 0.3 0.4] "float scale" [1]
LightSource "point" "point3 from" [0 1.5 0] "rgb I" [2 2 2] "float power" [30]
LightSource "spot" "point3 from" [0 1.8 0] "point3 to" [0 0 0] "float coneangle" [30] "float conedeltaangle" [5] "rgb I" [2 2 2]
LightSource "distant" "rgb L" [0.3 0.3 0.3] "point3 from" [0 1 0] "point3 to" [0 0 0.1]
AttributeBegin
Material "coateddiffuse" "rgb reflectance" [0.4 0.2 0.1] "float roughness" [0.2] "float eta" [1.5]
Translate 0 0.5 0 Rotate 30 0 1 0 Scale 0.5 0.5 0.5
Shape "sphere" "float radius" [0.9] "float zmin" [-0.8] "float zmax" [0.8] "float phimax" [300]
AttributeEnd
Material "conductor" "rgb eta" [0.2 0.9 1.1] "rgb k" [3.9 2.4 2.1] "float uroughness" [0.1] "float vroughness" [0.3]
Shape "cylinder" "float radius" [0.1] "float zmin" [0] "float zmax" [0.8]
Shape "disk" "float height" [0.1] "float radius" [0.6] "float innerradius" [0.2]
Texture "board" "spectrum" "checkerboard" "float uscale" [4] "float vscale" [3] "rgb tex1" [0.1 0.1 0.1] "rgb tex2" [0.8 0.8 0.8]
Material "diffuse" "texture reflectance" "board"
Shape "trianglemesh" "point3 P" [-2 0 -2  2 0 -2  2 0 2  -2 0 2] "integer indices" [0 2 1 0 3 2] "point2 uv" [0 0 1 0 1 1 0 1]
"""

GLTF = {
    "asset": {"version": "2.0"},
    "scene": 0,
    "scenes": [{"nodes": [0, 1, 2]}],
    "nodes": [
        {"mesh": 0, "translation": [0.1, 0.2, -3.0], "rotation": [0, 0.1, 0, 0.995], "scale": [1, 1.5, 1]},
        {"camera": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0.5, 1, 1]},
        {"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [0, 2, 0]},
    ],
    "cameras": [{"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.1, "zfar": 100, "aspectRatio": 1.0}}],
    "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_ior", "KHR_materials_emissive_strength"],
    "extensions": {"KHR_lights_punctual": {"lights": [{"type": "spot", "intensity": 300, "color": [1, 0.9, 0.8], "range": 50,
                   "spot": {"innerConeAngle": 0.3, "outerConeAngle": 0.7}}]}},
    "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.5, 0.3, 1], "metallicFactor": 0.3, "roughnessFactor": 0.4},
                   "emissiveFactor": [0.1, 0.1, 0.1], "alphaCutoff": 0.5, "extensions": {"KHR_materials_ior": {"ior": 1.4},
                   "KHR_materials_emissive_strength": {"emissiveStrength": 2}}}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]},
                  {"bufferView": 1, "componentType": 5125, "count": 3, "type": "SCALAR"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 12}],
    "buffers": [{"byteLength": 48, "uri": "data:application/octet-stream;base64,"
                 "AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAAAAAAAAEAAAACAAAA"}],
}  # fmt: skip

NUMBER = re.compile(r"(?<![\w.#-])-?\d+\.?\d*(?:e[+-]?\d+)?(?![\w.]|nd)")


def of_text(text: str) -> Iterator[tuple[str, str]]:
    """The text with one number replaced, and what that is; numbers of like places once."""
    seen = set()
    for found in NUMBER.finditer(text):
        before = text[: found.start()]
        if text.startswith("<"):
            place = re.sub(r"[-\d.e]+", "0", before[before.rfind("<") :])
        else:
            place = " ".join([before[before.rfind("\n") :].split(None, 1)[0] if before[-1] != "\n" else "", *re.findall(r'"[^"]*"', before)[-1:]])
        if place in seen:
            continue
        seen.add(place)
        for word in WORDS:
            yield f"{' '.join(place.split())[-60:]} {word}", before + word + text[found.end() :]


def of_json(document: dict) -> Iterator[tuple[str, str]]:
    """The document with one number replaced by words that JSON may have."""

    def places(value: object, path: tuple) -> Iterator[tuple]:
        members = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
        for key, member in members:
            yield from places(member, (*path, key))
        if isinstance(value, int | float):
            yield path

    for path in places(document, ()):
        for word in (*WORDS[3:], "0.5", "4294967296", "null", '"1"', "[]"):
            copy = json.loads(json.dumps(document))
            parent = copy
            for key in path[:-1]:
                parent = parent[key]
            parent[path[-1]] = "@@"
            yield f"/{'/'.join(map(str, path))} {word}", json.dumps(copy).replace('"@@"', word)


def all_fields() -> Iterator[tuple[str, str, str]]:
    """Name of the file, the place with the replaced number, and the text."""
    for name, texts in (("scene.xml", of_text(mitsuba_scene())), ("scene.pbrt", of_text(PBRT)), ("scene.gltf", of_json(GLTF))):
        for place, text in texts:
            yield name, place, text
