# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading, extending and writing binary glTF 2.0 files: numpy alone, without Blender."""

import json
import struct

import numpy as np

MAGIC = 0x46546C67
JSON_CHUNK = 0x4E4F534A
BINARY_CHUNK = 0x004E4942
ARRAY_BUFFER = 34962
ELEMENT_ARRAY_BUFFER = 34963
FLOAT = 5126
UNSIGNED_INT = 5125
COMPONENTS = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


class Glb:
    """A glTF document with one binary buffer. `json` is the document, as plain dictionaries and lists."""

    def __init__(self, document, data=b""):
        self.json = document
        self.data = bytearray(data)

    @classmethod
    def empty(cls):
        """A document with one scene without nodes."""
        return cls({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": []})

    @classmethod
    def read(cls, path):
        with open(path, "rb") as file:
            content = file.read()
        magic, version, _ = struct.unpack_from("<III", content)
        if magic != MAGIC or version != 2:
            raise ValueError(f"{path} is no binary glTF 2.0 file")
        document, data = None, b""
        at = 12
        while at < len(content):
            length, kind = struct.unpack_from("<II", content, at)
            chunk = content[at + 8 : at + 8 + length]
            if kind == JSON_CHUNK:
                document = json.loads(chunk)
            elif kind == BINARY_CHUNK:
                data = chunk
            at += 8 + length
        return cls(document, data)

    def write(self, path):
        if self.data:
            self.json.setdefault("buffers", [{}])[0] = {"byteLength": len(self.data)}
        text = json.dumps(self.json, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<II", len(text), JSON_CHUNK) + text
        if self.data:
            data = bytes(self.data) + bytes(-len(self.data) % 4)
            chunks += struct.pack("<II", len(data), BINARY_CHUNK) + data
        with open(path, "wb") as file:
            file.write(struct.pack("<III", MAGIC, 2, 12 + len(chunks)) + chunks)

    def items(self, name):
        """The list `name` of the document, which is made if there is none."""
        return self.json.setdefault(name, [])

    def append(self, name, item):
        """Adds an item to the list `name`; its index."""
        self.items(name).append(item)
        return len(self.items(name)) - 1

    def use(self, extension):
        used = self.items("extensionsUsed")
        if extension not in used:
            used.append(extension)

    def array(self, index):
        """The values of an accessor: (count, components), or (count,) for scalars."""
        accessor = self.json["accessors"][index]
        kind = np.dtype(COMPONENTS[accessor["componentType"]])
        width, count = WIDTHS[accessor["type"]], accessor["count"]
        view = self.json["bufferViews"][accessor["bufferView"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride = view.get("byteStride", kind.itemsize * width)
        shape, strides = (count, width), (stride, kind.itemsize)
        values = np.ndarray(shape, kind, buffer=bytes(self.data), offset=start, strides=strides)
        return values[:, 0].copy() if width == 1 else values.copy()

    def add_array(self, values, target):
        """Adds positions (n, 3) or indices (n,); the index of the accessor."""
        self.data += bytes(-len(self.data) % 4)
        is_vector = values.ndim == 2
        values = np.ascontiguousarray(values, np.float32 if is_vector else np.uint32)
        view = self.append(
            "bufferViews",
            {"buffer": 0, "byteOffset": len(self.data), "byteLength": values.nbytes, "target": target},
        )
        self.data += values.tobytes()
        accessor = {
            "bufferView": view,
            "componentType": FLOAT if is_vector else UNSIGNED_INT,
            "count": len(values),
            "type": "VEC3" if is_vector else "SCALAR",
        }
        if is_vector:
            accessor |= {"min": values.min(0).tolist(), "max": values.max(0).tolist()}
        return self.append("accessors", accessor)

    def add_primitive(self, positions, triangles, material):
        """Triangles (m, 3) over positions (n, 3) as a primitive of a mesh. Flat normals follow from the winding."""
        return {
            "attributes": {"POSITION": self.add_array(np.asarray(positions), ARRAY_BUFFER)},
            "indices": self.add_array(np.asarray(triangles).ravel(), ELEMENT_ARRAY_BUFFER),
            "material": material,
        }

    def add_node(self, **properties):
        """Adds a node to the shown scene; its index."""
        index = self.append("nodes", properties)
        self.json["scenes"][self.json.get("scene", 0)].setdefault("nodes", []).append(index)
        return index
