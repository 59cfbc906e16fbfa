"""glTF files with embedded buffers, made of balls and walls before a camera, and what lights them."""

import base64
import struct
import zlib
from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np

#: Values of `componentType`.
COMPONENTS = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
WIDTHS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
NEAREST = {"magFilter": 9728, "minFilter": 9728}
REPEAT, CLAMP, MIRROR = 10497, 33071, 33648


@dataclass
class Case:
    """A scene, and how it is rendered."""

    name: str
    gltf: dict
    #: `white` or `black`.
    environment: str = "white"
    spp: int = 128
    size: tuple[int, int] = (32, 32)
    #: What Cycles renders instead: the same scene, written as Blender's importer reads it.
    rewritten: dict | None = None


@dataclass
class Mesh:
    """Attributes of vertices, and triangles."""

    attributes: dict[str, np.ndarray]
    indices: np.ndarray | None


@dataclass
class File:
    """A glTF file that is being written."""

    json: dict = field(default_factory=lambda: {"asset": {"version": "2.0", "generator": "gltf_referee"}, "scene": 0})
    buffer: bytearray = field(default_factory=bytearray)

    def add(self, kind: str, item: dict) -> int:
        """The index of a new item of a list of the file."""
        self.json.setdefault(kind, []).append(item)
        return len(self.json[kind]) - 1

    def view(self, data: bytes, **more: object) -> int:
        self.buffer += bytes(-len(self.buffer) % 4)
        offset = len(self.buffer)
        self.buffer += data
        return self.add("bufferViews", {"buffer": 0, "byteOffset": offset, "byteLength": len(data), **more})

    def accessor(self, values: np.ndarray, **more: object) -> int:
        """Values of vertices, or indices. Rows of a size that is no multiple of 4 get a stride that is one."""
        rows = values.reshape(len(values), -1)
        item = {"componentType": COMPONENTS[values.dtype.str[1:]], "count": len(rows), "type": WIDTHS[rows.shape[1]], **more}
        if rows.shape[1] == 3:
            item |= {"min": rows.min(0).tolist(), "max": rows.max(0).tolist()}
        padding = -rows.strides[0] % 4
        if rows.shape[1] > 1 and padding:
            data = b"".join(row.tobytes() + bytes(padding) for row in rows)
            view = self.view(data, byteStride=rows.strides[0] + padding)
        else:
            view = self.view(np.ascontiguousarray(rows).tobytes())
        return self.add("accessors", item | {"bufferView": view})

    def primitive(self, mesh: Mesh, material: int | None, **more: object) -> dict:
        """Integers that are no floats are normalized."""
        attributes = {
            name: self.accessor(values, **({} if values.dtype == np.float32 else {"normalized": True}))
            for name, values in mesh.attributes.items()
        }
        item = {"attributes": attributes, **more}
        if mesh.indices is not None:
            item["indices"] = self.accessor(mesh.indices)
        if material is not None:
            item["material"] = material
        return item

    def mesh(self, primitive: dict, **more: object) -> int:
        return self.add("meshes", {"primitives": [primitive], **more})

    def texture(self, pixels: np.ndarray, sampler: dict) -> int:
        source = self.add("images", {"mimeType": "image/png", "bufferView": self.view(png(pixels))})
        return self.add("textures", {"source": source, "sampler": self.add("samplers", sampler)})

    def finished(self) -> dict:
        """The content of the file. Nodes without a parent are the scene."""
        nodes = self.json["nodes"]
        children = {child for node in nodes for child in node.get("children", [])}
        self.json["scenes"] = [{"nodes": [index for index in range(len(nodes)) if index not in children]}]
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.buffer).decode()
        self.json["buffers"] = [{"byteLength": len(self.buffer), "uri": uri}]
        used = sorted(extensions_of(self.json))
        return self.json | ({"extensionsUsed": used} if used else {})


def extensions_of(value: object) -> set[str]:
    """The names of the extensions within a part of a file."""
    if isinstance(value, list):
        return set().union(*map(extensions_of, value))
    if not isinstance(value, dict):
        return set()
    return set(value.get("extensions", {})).union(*map(extensions_of, value.values()))


def png(pixels: np.ndarray) -> bytes:
    """An image of 8 bits with 3 or 4 channels."""
    height, width, channels = pixels.shape
    rows = b"".join(b"\0" + row.tobytes() for row in pixels.astype("u1"))

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    header = struct.pack(">IIBBBBB", width, height, 8, {3: 2, 4: 6}[channels], 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def wall(size: float = 1.0) -> Mesh:
    """A square that faces +z, with its texture upright."""
    x = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], "f4")
    uv = np.array([(0, 1), (1, 1), (1, 0), (0, 0)], "f4")
    attributes = {"POSITION": x * np.float32(size), "NORMAL": np.array([(0, 0, 1)] * 4, "f4"), "TEXCOORD_0": uv}
    return Mesh(attributes, np.array([0, 1, 2, 0, 2, 3], "u2"))


def ball(radius: float = 1.0, columns: int = 96, rows: int = 48) -> Mesh:
    """A sphere with its poles on the y axis."""
    v, u = np.meshgrid(np.linspace(0, 1, rows + 1), np.linspace(0, 1, columns + 1), indexing="ij")
    theta, phi = np.pi * v, 2 * np.pi * u
    normal = np.stack([-np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], -1).reshape(-1, 3)
    # The seam and the poles are single points, so that the surface is closed.
    grid = normal.reshape(rows + 1, columns + 1, 3)
    grid[:, -1], grid[0], grid[-1] = grid[:, 0], (0, 1, 0), (0, -1, 0)
    first = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).reshape(-1)
    below = first + columns + 1
    upper = np.stack([first, below, first + 1], -1)[columns:]
    lower = np.stack([first + 1, below, below + 1], -1)[:-columns]
    uv = np.stack([u, v], -1).reshape(-1, 2)
    attributes = {"POSITION": (normal * radius).astype("f4"), "NORMAL": normal.astype("f4"), "TEXCOORD_0": uv.astype("f4")}
    return Mesh(attributes, np.concatenate([upper, lower]).reshape(-1).astype("u2"))


def facing(position: Iterable[float]) -> list[float]:
    """The matrix of a node at a position whose +z is towards the origin."""
    place = np.array(list(position), float)
    z = -place / np.linalg.norm(place)
    x = np.cross((0.0, 1.0, 0.0), z)
    x /= np.linalg.norm(x)
    columns = [x, np.cross(z, x), z, place]
    return [float(v) for column, last in zip(columns, (0, 0, 0, 1), strict=True) for v in (*column, last)]


def matte(color: Iterable[float] = (0.8, 0.5, 0.2, 1.0), texture: dict | None = None, **more: object) -> dict:
    """A Lambertian material."""
    base = {"baseColorFactor": list(color), "metallicFactor": 0, "roughnessFactor": 1}
    if texture is not None:
        base["baseColorTexture"] = texture
    extensions = {"KHR_materials_specular": {"specularFactor": 0}} | more.pop("extensions", {})
    return {"pbrMetallicRoughness": base, "extensions": extensions, **more}


def shiny(roughness: float, metallic: float = 0, color: Iterable[float] = (0.8, 0.5, 0.2, 1.0), **more: object) -> dict:
    base = {"baseColorFactor": list(color), "metallicFactor": metallic, "roughnessFactor": roughness}
    return {"pbrMetallicRoughness": base | more.pop("base", {}), **more}


def add_camera(file: File, lens: dict | None = None, **node: object) -> None:
    """A camera at z = 4 that sees a square with sides of 2.4 around the origin, or with another lens."""
    lens = lens or {"type": "perspective", "perspective": {"yfov": 0.583, "aspectRatio": 1, "znear": 0.01}}
    file.add("nodes", {"camera": file.add("cameras", lens), **({"translation": [0, 0, 4]} | node)})


def add_panels(file: File) -> None:
    """A warm and a cool square that emit towards the origin. The camera does not see them."""
    for place, radiance in (((-2.5, 1.5, 2.5), (1.0, 0.75, 0.4)), ((2.5, -0.6, 2.0), (0.25, 0.5, 1.0))):
        strength = {"KHR_materials_emissive_strength": {"emissiveStrength": 8}}
        black = {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0, "roughnessFactor": 1}
        extensions = strength | {"KHR_materials_specular": {"specularFactor": 0}}
        material = {"pbrMetallicRoughness": black, "emissiveFactor": list(radiance), "extensions": extensions}
        mesh = file.mesh(file.primitive(wall(0.8), file.add("materials", material)))
        file.add("nodes", {"mesh": mesh, "matrix": facing(place)})


def add_backdrop(file: File) -> None:
    """A wall of gray stripes behind the origin, for glass to show."""
    pixels = np.repeat(np.linspace(20, 235, 7)[[0, 4, 2, 6, 1, 5, 3]][None, :, None], 3, 2).round().astype("u1")
    texture = {"index": file.texture(pixels, NEAREST)}
    mesh = file.mesh(file.primitive(wall(2.0), file.add("materials", matte((1.0, 1.0, 1.0, 1.0), texture))))
    file.add("nodes", {"mesh": mesh, "translation": [0, 0, -1.5]})


def shown(name: str, material: dict, mesh: Mesh, light: str = "panels", file: File | None = None, **more: object) -> Case:
    """One mesh before the camera. `light`: `white`, `panels` or `none`."""
    file = file or File()
    node = more.pop("node", {"rotation": TILT} if len(mesh.attributes["POSITION"]) <= 8 else {})
    primitive = file.primitive(mesh, file.add("materials", material), **more.pop("primitive", {}))
    file.add("nodes", {"mesh": file.mesh(primitive), **node})
    if more.pop("backdrop", False):
        add_backdrop(file)
    return finished(name, file, light, **more)


def finished(name: str, file: File, light: str = "panels", **more: object) -> Case:
    """The case of a file with the camera and light."""
    add_camera(file)
    if light == "panels":
        add_panels(file)
    return Case(name, file.finished(), environment="white" if light == "white" else "black", **more)


def rewritten(case: Case, other: Case) -> Case:
    """A case whose other file Cycles renders. If both agree, a difference in the first file alone is Blender's."""
    return replace(case, name=f"{case.name}, rewritten for Blender", rewritten=other.gltf)


def about(axis: Iterable[float], degrees: float) -> list[float]:
    """The quaternion of a rotation."""
    half = np.radians(degrees) / 2
    unit = np.array(list(axis), float)
    return [*(np.sin(half) * unit / np.linalg.norm(unit)).tolist(), float(np.cos(half))]


#: The rotation of walls, which so are seen and lit at an angle.
TILT = about((1.0, 0.6, 0.2), 25)
