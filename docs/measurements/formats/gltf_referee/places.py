"""Cases of what is not a material: textures' coordinates and samplers, accessors, nodes, lights, cameras."""

import copy
from collections.abc import Iterator

import numpy as np

from materials import WHITE, bumps, chart
from scenes import (
    CLAMP,
    MIRROR,
    NEAREST,
    REPEAT,
    TILT,
    Case,
    File,
    Mesh,
    about,
    add_camera,
    add_panels,
    ball,
    finished,
    matte,
    rewritten,
    shown,
    wall,
)


def charted(name: str, mesh: Mesh, info: dict | None = None, sampler: dict = NEAREST, primitive: dict | None = None) -> Case:
    """A mesh with the chart of colors."""
    file = File()
    texture = {"index": file.texture(chart()[..., :3], sampler)} | (info or {})
    return shown(name, matte(WHITE, texture), mesh, file=file, primitive=primitive or {})


def coordinates() -> Iterator[Case]:
    """Transforms of textures, sets of coordinates, samplers."""

    def transformed(**values: object) -> dict:
        return {"extensions": {"KHR_texture_transform": values}}

    yield charted("texture offset", wall(), transformed(offset=[0.3, 0.15]))
    yield charted("texture scale", wall(), transformed(scale=[1.7, 0.6]))
    yield charted("texture rotation", wall(), transformed(rotation=0.4))
    yield charted("texture transform", wall(), transformed(offset=[0.3, 0.15], scale=[1.7, 0.6], rotation=0.4))
    second = wall()
    second.attributes["TEXCOORD_1"] = np.array([(0.2, 0.1), (0.2, 0.8), (0.9, 0.8), (0.9, 0.1)], "f4")
    yield charted("texture coordinates 1", second, {"texCoord": 1})
    yield charted("texture transform with texCoord", second, transformed(texCoord=1, scale=[0.8, 1.0]))
    beyond = wall()
    beyond.attributes["TEXCOORD_0"] = beyond.attributes["TEXCOORD_0"] * np.float32(2.7) - np.float32(0.8)
    names = {REPEAT: "repeat", CLAMP: "clamp", MIRROR: "mirror"}
    for s, t in ((REPEAT, REPEAT), (CLAMP, CLAMP), (MIRROR, MIRROR), (REPEAT, CLAMP), (CLAMP, MIRROR), (MIRROR, REPEAT)):
        yield charted(f"wrap {names[s]}, {names[t]}", beyond, sampler=NEAREST | {"wrapS": s, "wrapT": t})


def accessors() -> Iterator[Case]:
    """Ways to store attributes and triangles."""
    for kind in ("u1", "u2"):
        mesh = wall()
        uv = mesh.attributes["TEXCOORD_0"] * 0.8 + 0.1
        mesh.attributes["TEXCOORD_0"] = np.round(uv * np.iinfo(kind).max).astype(kind)
        yield charted(f"texture coordinates {kind}", mesh)
    small = wall(0.9)
    small.attributes["POSITION"] = np.round(small.attributes["POSITION"] * 32767).astype("i2")
    small.attributes["NORMAL"] = np.round(small.attributes["NORMAL"] * 127).astype("i1")
    case = charted("KHR_mesh_quantization", small)
    for key in ("extensionsUsed", "extensionsRequired"):
        case.gltf.setdefault(key, []).append("KHR_mesh_quantization")
    yield case
    for kind in ("u1", "u4"):
        yield charted(f"indices {kind}", Mesh(wall().attributes, wall().indices.astype(kind)))
    flat = {name: values[wall().indices] for name, values in wall().attributes.items()}
    yield charted("no indices", Mesh(flat, None))
    yield charted("triangle strip", Mesh(wall().attributes, np.array([0, 1, 3, 2], "u2")), primitive={"mode": 5})
    yield charted("triangle fan", Mesh(wall().attributes, np.array([0, 1, 2, 3], "u2")), primitive={"mode": 6})
    coarse = ball(1, 12, 6)
    del coarse.attributes["NORMAL"]
    yield charted("no normals", coarse)
    yield interleaved()
    yield sparse("sparse positions", based=True)
    yield sparse("sparse positions without a view", based=False)


def interleaved() -> Case:
    file = File()
    mesh = wall()
    names = ["POSITION", "NORMAL", "TEXCOORD_0"]
    rows = np.concatenate([mesh.attributes[name] for name in names], 1)
    view = file.view(rows.tobytes(), byteStride=rows.strides[0])
    attributes, offset = {}, 0
    for name in names:
        width = mesh.attributes[name].shape[1]
        item = {"bufferView": view, "byteOffset": offset, "componentType": 5126, "count": 4, "type": f"VEC{width}"}
        if name == "POSITION":
            item |= {"min": [-1, -1, 0], "max": [1, 1, 0]}
        attributes[name] = file.add("accessors", item)
        offset += 4 * width
    material = file.add("materials", matte(WHITE, {"index": file.texture(chart()[..., :3], NEAREST)}))
    primitive = {"attributes": attributes, "indices": file.accessor(mesh.indices), "material": material}
    file.add("nodes", {"mesh": file.mesh(primitive), "rotation": TILT})
    return finished("interleaved buffer view", file)


def sparse(name: str, based: bool) -> Case:
    """Three corners of a wall, or all, are replaced."""
    file = File()
    mesh = wall()
    kept = 1 if based else 0
    item = {"componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]}
    if based:
        item["bufferView"] = file.view((mesh.attributes["POSITION"] * 3).tobytes())
        mesh.attributes["POSITION"][0] *= 3
        item |= {"min": [-3, -3, 0]}
    places = np.arange(kept, 4, dtype="u2")
    item["sparse"] = {
        "count": 4 - kept,
        "indices": {"bufferView": file.view(places.tobytes()), "componentType": 5123},
        "values": {"bufferView": file.view(mesh.attributes["POSITION"][kept:].tobytes())},
    }
    material = file.add("materials", matte(WHITE, {"index": file.texture(chart()[..., :3], NEAREST)}))
    primitive = file.primitive(Mesh({key: v for key, v in mesh.attributes.items() if key != "POSITION"}, mesh.indices), material)
    primitive["attributes"]["POSITION"] = file.add("accessors", item)
    file.add("nodes", {"mesh": file.mesh(primitive), "rotation": TILT})
    return finished(name, file)


def morphs() -> Iterator[Case]:
    for where in ("mesh", "node"):
        file = File()
        texture = {"index": file.texture(chart()[..., :3], NEAREST)}
        primitive = file.primitive(wall(), file.add("materials", matte(WHITE, texture)))
        moves = np.array([[(0.5, 0.3, 0), (0, 0, 0), (-0.6, -0.4, 0), (0, 0.1, 0)], [(0, 0, 0)] * 2 + [(0.4, 0, 0)] * 2], "f4")
        primitive["targets"] = [{"POSITION": file.accessor(move)} for move in moves]
        weights = {"weights": [0.7, 0.4]}
        mesh = file.mesh(primitive, **(weights if where == "mesh" else {"weights": [0, 0]}))
        file.add("nodes", {"mesh": mesh, "rotation": TILT} | (weights if where == "node" else {}))
        yield finished(f"morph targets by weights of the {where}", file)


def copies() -> Case:
    """Instances by an extension."""
    file = File()
    texture = {"index": file.texture(chart()[..., :3], NEAREST)}
    mesh = file.mesh(file.primitive(ball(0.5), file.add("materials", matte(WHITE, texture))))
    moves = np.array([(-0.5, 0.3, 0), (0.6, 0.2, 0.3), (0, -0.5, 0)], "f4")
    turns = np.array([about((0, 1, 0), 40), about((1, 0, 0), 90), (0, 0, 0, 1)], "f4")
    scales = np.array([(1, 1, 1), (0.8, 1, 0.6), (1.1, 0.9, 1)], "f4")
    values = {"TRANSLATION": moves, "ROTATION": turns, "SCALE": scales}
    instances = {"attributes": {name: file.accessor(value) for name, value in values.items()}}
    file.add("nodes", {"mesh": mesh, "rotation": TILT, "extensions": {"EXT_mesh_gpu_instancing": instances}})
    return finished("EXT_mesh_gpu_instancing", file)


def skinned(name: str, forward: float) -> Case:
    """A wall whose upper edge follows a joint that is turned within the plane, and moved, also forward."""
    file = File()
    texture = {"index": file.texture(chart()[..., :3], NEAREST)}
    mesh = wall()
    mesh.attributes["WEIGHTS_0"] = np.array([(1, 0, 0, 0)] * 2 + [(0.2, 0.8, 0, 0)] * 2, "f4")
    primitive = file.primitive(mesh, file.add("materials", matte(WHITE, texture)))
    joints = np.array([(0, 1, 0, 0)] * 4, "u1")
    primitive["attributes"]["JOINTS_0"] = file.accessor(joints)
    inverses = np.tile(np.eye(4, dtype="f4"), (2, 1, 1))
    inverses[1, 3, 1] = -1
    skin = {"joints": [1, 2], "inverseBindMatrices": file.accessor(inverses)}
    file.add("nodes", {"mesh": file.mesh(primitive), "skin": file.add("skins", skin)})
    file.add("nodes", {"children": [2], "rotation": TILT})
    file.add("nodes", {"translation": [0.2, 0.8, forward], "rotation": about((0, 0, 1), 25)})
    return finished(name, file)


def by_rotations(matrix: np.ndarray) -> list[dict]:
    """Nested nodes without shear that are a matrix together: its singular value decomposition."""
    left, scale, right = np.linalg.svd(matrix[:3, :3])
    if np.linalg.det(left) < 0:
        left, right = -left, -right

    def turned(axes: np.ndarray) -> dict:
        square = np.eye(4)
        square[:3, :3] = axes
        return {"matrix": square.T.reshape(-1).tolist()}

    return [{"translation": matrix[:3, 3].tolist()}, turned(left), {"scale": scale.tolist()}, turned(right)]


def nodes() -> Iterator[Case]:
    """Transforms. The children of a stretched node are sheared."""

    def placed(name: str, chain: list[dict], texture: str = "baseColorTexture") -> Case:
        file = File()
        pixels, shape = (bumps(), wall()) if texture == "normalTexture" else (chart()[..., :3], ball(0.8))
        info = {"index": file.texture(pixels, NEAREST)}
        material = matte(WHITE, normalTexture=info) if texture == "normalTexture" else matte(WHITE, info)
        mesh = file.mesh(file.primitive(shape, file.add("materials", material)))
        links = copy.deepcopy(chain)
        links[-1]["mesh"] = mesh
        for index, link in enumerate(links):
            file.add("nodes", link | ({"children": [index + 1]} if index + 1 < len(links) else {}))
        return finished(name, file)

    turn = about((1, 2, 0.5), 50)
    yield placed("node rotation", [{"rotation": turn}])
    yield placed("node scale", [{"scale": [1.2, 0.7, 0.9], "rotation": turn, "translation": [0.1, -0.1, 0.2]}])
    yield placed("node negative scale", [{"scale": [-1.1, 0.8, 0.9], "rotation": turn}])
    yield placed("node negative scale on three axes", [{"scale": [-1, -0.8, -0.9], "rotation": turn}])
    yield placed("node negative scale, normal texture", [{"scale": [-1, 1, 1], "rotation": TILT}], "normalTexture")
    yield placed("node uneven scale, normal texture", [{"scale": [1.1, 0.7, 1], "rotation": TILT}], "normalTexture")
    matrix = np.array([(0.9, -0.1, 0, 0.1), (0.2, 0.8, -0.2, 0.1), (0, 0.3, 1, 0), (0, 0, 0, 1)])
    sheared = placed("node matrix that shears", [{"matrix": matrix.T.reshape(-1).tolist()}])
    yield sheared
    yield rewritten(sheared, placed("", by_rotations(matrix)))
    matrix[:3, :3] = np.array([(0, -1.1, 0), (0.8, 0, 0), (0, 0, 0.9)])
    yield placed("node matrix", [{"matrix": matrix.T.reshape(-1).tolist()}])
    yield placed("nested nodes", [{"translation": [0.2, 0, 0]}, {"scale": [1.2, 1.2, 1.2]}, {"rotation": turn, "scale": [1, 0.6, 0.8]}])
    yield copies()
    yield skinned("skin", 0)
    yield skinned("skin that tilts triangles", 0.2)
    yield placed("nested nodes that shear", [{"scale": [1.2, 0.6, 1]}, {"rotation": turn}])


def lights() -> Iterator[Case]:
    """Lamps over a tilted wall. Intensities are lumens by the specification, which Blender's importer divides by 683."""

    def lit(name: str, lamp: dict, node: dict, generator: str = "gltf_referee") -> Case:
        file = File()
        file.json["asset"]["generator"] = generator
        mesh = file.mesh(file.primitive(wall(1.5), file.add("materials", matte())))
        file.add("nodes", {"mesh": mesh, "rotation": TILT})
        file.add("nodes", {"extensions": {"KHR_lights_punctual": {"light": 0}}} | node)
        file.json["extensions"] = {"KHR_lights_punctual": {"lights": [lamp]}}
        return finished(name, file, "none")

    place = {"translation": [0.5, 0.4, 1.6]}
    colored = {"intensity": 3000, "color": [1, 0.6, 0.2]}
    yield lit("point lamp", {"type": "point", **colored}, place)
    yield lit("point lamp at a scaled node", {"type": "point", **colored}, place | {"scale": [2, 2, 2]})
    plain = {"type": "point", "color": [1, 0.6, 0.2]}
    dim = lit("point lamp without intensity", plain, place)
    yield dim
    yield rewritten(dim, lit("", plain | {"intensity": 1}, place))
    yield lit("directional lamp", {"type": "directional", **colored}, {"rotation": about((1, 0.5, 0), -40)})
    blender = "Khronos glTF Blender I/O v5.0.21"
    cones = {"default cones": {}, "inner 0": {"innerConeAngle": 0, "outerConeAngle": 0.6}}
    cones |= {"inner 0.4": {"innerConeAngle": 0.4, "outerConeAngle": 0.6}}
    cases = {}
    for name, cone in cones.items():
        for generator in ("gltf_referee", blender):
            maker = "" if generator != blender else ", of Blender"
            cases[name + maker] = lit(f"spot lamp, {name}{maker}", {"type": "spot", "spot": cone, **colored}, place, generator)
    yield from cases.values()
    # Blender takes the part of the angle for a part of the cosine.
    blend = (np.cos(0.4) - np.cos(0.6)) / (1 - np.cos(0.6))
    spot = {"type": "spot", "spot": {"innerConeAngle": float(0.6 * (1 - blend)), "outerConeAngle": 0.6}, **colored}
    yield rewritten(cases["inner 0.4"], lit("", spot, place))


def cameras() -> Iterator[Case]:
    def seen(name: str, lens: dict, size: tuple[int, int] = (32, 32), shape: Mesh | None = None, **node: object) -> Case:
        file = File()
        material = matte(WHITE, {"index": file.texture(chart()[..., :3], NEAREST)})
        file.add("nodes", {"mesh": file.mesh(file.primitive(shape or ball(), file.add("materials", material)))})
        add_camera(file, lens, **node)
        add_panels(file)
        return Case(name, file.finished(), "black", size=size)

    def perspective(**values: object) -> dict:
        return {"type": "perspective", "perspective": {"yfov": 0.6, "znear": 0.01} | values}

    def orthographic(**values: object) -> dict:
        return {"type": "orthographic", "orthographic": {"xmag": 1.1, "ymag": 1.1, "znear": 0.01, "zfar": 100} | values}

    yield seen("perspective wide", perspective(aspectRatio=2), (48, 24))
    yield seen("perspective high", perspective(aspectRatio=0.5), (24, 48))
    yield seen("perspective znear", perspective(aspectRatio=1, znear=3.4))
    flat = ball()
    del flat.attributes["NORMAL"]
    yield seen("perspective znear, flat normals", perspective(aspectRatio=1, znear=3.4), shape=flat)
    yield seen("perspective zfar", perspective(aspectRatio=1, zfar=3.3))
    yield seen("perspective rolled", perspective(aspectRatio=1), rotation=about((0, 0, 1), 30))
    yield seen("perspective at a scaled node", perspective(aspectRatio=1), scale=[2, 3, 0.5])
    yield seen("orthographic", orthographic())
    yield seen("orthographic wide", orthographic(xmag=1.4, ymag=0.7), (48, 24))
    yield seen("orthographic high", orthographic(xmag=0.7, ymag=1.4), (24, 48))
    yield seen("orthographic znear", orthographic(znear=3.4))
    yield seen("orthographic at a scaled node", orthographic(), scale=[2, 2, 2])


def all_cases() -> Iterator[Case]:
    for family in (coordinates, accessors, morphs, nodes, lights, cameras):
        yield from family()
