"""Reads the part of Mitsuba's scene format that the scenes of docs/measurements/paper use, for translation to other renderers.

Vertices are in world space. Triangles are counterclockwise seen from the side of their normal. Texture coordinates have
v = 0 at the first row of an image, as in Mitsuba.
"""
import math
import re
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

#: Complex indices of refraction (eta, k) of Mitsuba's metals, as linear sRGB.
METALS = {
    "Al": ((1.65750, 0.880405, 0.521244), (9.22381, 6.26950, 4.83700)),
    "Cr": ((4.36967, 2.91651, 1.65490), (5.20655, 4.23131, 3.75470)),
    "Cu": ((0.201005, 0.923750, 1.10222), (3.91326, 2.45305, 2.14209)),
    "Ag": ((0.155276, 0.116728, 0.138388), (4.82835, 3.12222, 2.14690)),
}
#: Subdivisions n of an icosahedron that stands for a sphere: 20 * 4^n triangles. Emitters have fewer, because renderers
#: that sample triangles keep data for each.
SPHERE_SUBDIVISIONS, EMITTER_SUBDIVISIONS = 4, 2


class Unsupported(Exception):
    """A feature of the scene that is not translated."""


@dataclass(frozen=True)
class Texture:
    """A bitmap; `raw` values are linear, others sRGB."""

    path: Path
    raw: bool


@dataclass
class Material:
    """A scattering model: `kind` as Mitsuba calls it. A color is three numbers or a `Texture`."""

    kind: str
    color: object = (0.5, 0.5, 0.5)
    alpha: float = 0.1
    ior: float = 1.5
    eta: tuple = None
    k: tuple = None
    tint: tuple = (1.0, 1.0, 1.0)
    weight: object = 0.5
    parts: list = field(default_factory=list)


@dataclass
class Shape:
    """A triangle mesh. `normals` and `uvs` are per vertex, or None. `radiance` leaves from the side of the normals."""

    name: str
    vertices: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray
    uvs: np.ndarray
    material: str
    radiance: tuple = None


@dataclass
class Spot:
    """A point light; its intensity falls linearly in the angle from `beam` to 0 at `cutoff` (radians)."""

    position: np.ndarray
    direction: np.ndarray
    intensity: tuple
    cutoff: float
    beam: float


@dataclass
class Camera:
    """A pinhole. `fov` in radians is horizontal if `is_horizontal`, else vertical."""

    position: np.ndarray
    direction: np.ndarray
    up: np.ndarray
    fov: float
    is_horizontal: bool


@dataclass
class Scene:
    """A scene; `materials` by their name."""

    camera: Camera
    materials: dict
    shapes: list
    spots: list


def read_scene(path, size):
    """The scene of a file, for images of (width, height) `size`."""
    path = Path(path).resolve()
    root = ElementTree.parse(path).getroot()
    defaults = {e.get("name"): e.get("value") for e in root.iter("default")}
    for element in root.iter():
        for key, value in element.attrib.items():
            element.set(key, re.sub(r"\$(\w+)", lambda m: defaults.get(m[1], m[0]), value))
    scene = Scene(None, {}, [], [])
    for element in root:
        if element.tag == "sensor":
            scene.camera = read_camera(element, size)
        elif element.tag == "bsdf":
            scene.materials[element.get("id")] = read_material(element, path.parent)
        elif element.tag == "emitter":
            scene.spots.append(read_spot(element))
        elif element.tag == "shape":
            scene.shapes.append(read_shape(element, path.parent, scene.materials))
        elif element.tag not in ("default", "integrator"):
            raise Unsupported(f"<{element.tag}>")
    return scene


# Values


def numbers(text):
    values = tuple(float(x) for x in re.split(r"[\s,]+", text.strip()))
    return values * 3 if len(values) == 1 else values


def value_of(element, name, default=None):
    """The value of the child with this name: a float, a string, three numbers or a texture."""
    for child in element:
        if child.get("name") == name:
            return read_value(child)
    return default


def read_value(child):
    if child.tag in ("float", "integer"):
        return float(child.get("value"))
    if child.tag in ("rgb", "spectrum"):
        return numbers(child.get("value"))
    if child.tag in ("point", "vector"):
        return np.array([float(child.get(axis, 0)) for axis in "xyz"])
    return child.get("value")


def transform_of(element):
    """The matrix of `to_world`. Its parts apply in the order of the file."""
    matrix = np.eye(4)
    for transform in element.findall("transform"):
        for part in transform:
            matrix = step_matrix(part) @ matrix
    return matrix


def step_matrix(part):
    if part.tag == "matrix":
        return np.array([float(x) for x in part.get("value").split()]).reshape(4, 4)
    if part.tag == "lookat":
        return look_at(*(np.array(numbers(part.get(key))) for key in ("origin", "target", "up")))
    default = 1.0 if part.tag == "scale" else 0.0
    vector = [float(part.get(axis, part.get("value", default))) for axis in "xyz"]
    matrix = np.eye(4)
    if part.tag == "translate":
        matrix[:3, 3] = vector
    elif part.tag == "scale":
        matrix[:3, :3] = np.diag(vector)
    elif part.tag == "rotate":
        matrix[:3, :3] = rotation(np.array(vector), math.radians(float(part.get("angle"))))
    else:
        raise Unsupported(f"<{part.tag}> in a transform")
    return matrix


def look_at(origin, target, up):
    """Mitsuba's camera looks along +z, with x to the left."""
    z = (target - origin) / np.linalg.norm(target - origin)
    x = np.cross(up, z)
    x /= np.linalg.norm(x)
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2], matrix[:3, 3] = x, np.cross(z, x), z, origin
    return matrix


def rotation(axis, angle):
    """Rodrigues' formula."""
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


# Camera, lights and materials


def read_camera(element, size):
    matrix = transform_of(element)
    axis = value_of(element, "fov_axis", "x")
    wide = size[0] > size[1]
    is_horizontal = axis == "x" or (axis == "smaller" and not wide) or (axis == "larger" and wide)
    fov = math.radians(value_of(element, "fov"))
    return Camera(matrix[:3, 3], matrix[:3, 2], matrix[:3, 1], fov, is_horizontal)


def read_spot(element):
    if element.get("type") != "spot":
        raise Unsupported(f"emitter of type {element.get('type')}")
    matrix = transform_of(element)
    cutoff = value_of(element, "cutoff_angle", 20.0)
    beam = value_of(element, "beam_width", 0.75 * cutoff)
    intensity = value_of(element, "intensity")
    return Spot(matrix[:3, 3], matrix[:3, 2], intensity, math.radians(cutoff), math.radians(beam))


def read_material(element, folder):
    kind = element.get("type")
    parts = [read_material(child, folder) for child in element.findall("bsdf")]
    if kind == "twosided":
        return parts[0]
    material = Material(kind, parts=parts)
    if kind == "blendbsdf":
        material.weight = color_of(element, "weight", folder)
    elif kind == "diffuse":
        material.color = color_of(element, "reflectance", folder)
    elif kind == "roughplastic":
        material.color = color_of(element, "diffuse_reflectance", folder)
        material.ior = value_of(element, "int_ior", 1.49)
    elif kind == "roughconductor":
        named = METALS.get(value_of(element, "material", ""), (None, None))
        material.eta = value_of(element, "eta", named[0])
        material.k = value_of(element, "k", named[1])
        material.tint = value_of(element, "specular_reflectance", (1.0, 1.0, 1.0))
    elif kind == "dielectric":
        material.ior = value_of(element, "int_ior", 1.5046) / value_of(element, "ext_ior", 1.000277)
    else:
        raise Unsupported(f"bsdf of type {kind}")
    material.alpha = value_of(element, "alpha", 0.1)
    return material


def tinted(eta, k, tint):
    """Indices of refraction with the reflectance at normal incidence multiplied by `tint`, by change of k."""
    eta, k = np.array(eta), np.array(k)
    reflectance = np.array(tint) * ((eta - 1) ** 2 + k**2) / ((eta + 1) ** 2 + k**2)
    return eta, np.sqrt(np.maximum(reflectance * (eta + 1) ** 2 - (eta - 1) ** 2, 0) / (1 - reflectance))


def color_of(element, name, folder):
    for texture in element.findall("texture"):
        if texture.get("name") == name:
            raw = value_of(texture, "raw") == "true"
            return Texture(folder / value_of(texture, "filename"), raw)
    return value_of(element, name, (0.5, 0.5, 0.5))


# Shapes


def read_shape(element, folder, materials):
    kind = element.get("type")
    if kind == "ply":
        mesh = read_ply(folder / value_of(element, "filename"))
    elif kind in ("rectangle", "cube"):
        mesh = rectangle() if kind == "rectangle" else cube()
    elif kind == "sphere":
        subdivisions = SPHERE_SUBDIVISIONS if element.find("emitter") is None else EMITTER_SUBDIVISIONS
        mesh = sphere(value_of(element, "center", np.zeros(3)), value_of(element, "radius", 1.0), subdivisions)
    else:
        raise Unsupported(f"shape of type {kind}")
    vertices, triangles, normals, uvs = mesh
    vertices, triangles, normals = placed(vertices, triangles, normals, transform_of(element))
    shape = Shape(element.get("id"), vertices, triangles, normals, uvs, material_of(element, folder, materials))
    for emitter in element.findall("emitter"):
        shape.radiance = value_of(emitter, "radiance")
    return shape


def material_of(element, folder, materials):
    """The name of the material of a shape; one that is written inside gets the name of the shape."""
    for child in element.findall("bsdf"):
        name = f"material of {element.get('id')}"
        materials[name] = read_material(child, folder)
        return name
    return element.find("ref").get("id")


def placed(vertices, triangles, normals, matrix):
    """The mesh in world space."""
    linear = matrix[:3, :3]
    vertices = vertices @ linear.T + matrix[:3, 3]
    if normals is not None:
        normals = normals @ np.linalg.inv(linear)
        normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-20)
    if np.linalg.det(linear) < 0:
        triangles = triangles[:, ::-1]
    return vertices, triangles, normals


def rectangle():
    """The square from -1 to 1 in x and y with normal z."""
    vertices = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
    uvs = 0.5 * vertices[:, :2] + 0.5
    return vertices, np.array([[0, 1, 2], [2, 3, 0]]), None, uvs


def cube():
    """The cube from -1 to 1; the faces do not share vertices."""
    base = rectangle()[0] + [0, 0, 1]
    turns = [rotation(np.array(axis, float), angle) for axis, angle in CUBE_TURNS]
    vertices = np.concatenate([base @ turn.T for turn in turns])
    triangles = np.concatenate([rectangle()[1] + 4 * i for i in range(6)])
    return vertices, triangles, None, np.tile(rectangle()[3], (6, 1))


CUBE_TURNS = [((1, 0, 0), angle * math.pi / 2) for angle in range(4)] + [((0, 1, 0), math.pi / 2), ((0, 1, 0), -math.pi / 2)]


def sphere(center, radius, subdivisions):
    """An icosahedron, subdivided, with the area of the sphere and its normals."""
    vertices, triangles = icosahedron()
    for _ in range(subdivisions):
        vertices, triangles = subdivided(vertices, triangles)
    edges = vertices[triangles[:, 1:]] - vertices[triangles[:, :1]]
    area = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1).sum()
    return vertices * radius * math.sqrt(4 * math.pi / area) + center, triangles, vertices, None


def icosahedron():
    golden = (1 + math.sqrt(5)) / 2
    base = [[-1, golden, 0], [1, golden, 0], [-1, -golden, 0], [1, -golden, 0]]
    vertices = np.array([np.roll(v, shift) for shift in range(3) for v in base])
    vertices = vertices / np.linalg.norm(vertices[0])
    distances = np.linalg.norm(vertices[:, None] - vertices[None], axis=2)
    near = distances < 1.1
    triangles = [
        (i, j, k)
        for i in range(12) for j in range(12) for k in range(12)
        if i < j and i < k and near[i, j] and near[j, k] and near[k, i] and j != k
        and np.linalg.det(vertices[[i, j, k]]) > 0
    ]
    return vertices, np.array(triangles)


def subdivided(vertices, triangles):
    """Each triangle as four, with the new vertices on the unit sphere."""
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    unique, place = np.unique(edges, axis=0, return_inverse=True)
    middles = vertices[unique].sum(axis=1)
    middles /= np.linalg.norm(middles, axis=1, keepdims=True)
    ab, bc, ca = (place.reshape(3, -1) + len(vertices))
    a, b, c = triangles.T
    parts = [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    return np.concatenate([vertices, middles]), np.concatenate([np.stack(p, axis=1) for p in parts])


#: Types of the binary PLY format.
PLY_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "<i2", "int16": "<i2", "ushort": "<u2",
    "uint16": "<u2", "int": "<i4", "int32": "<i4", "uint": "<u4", "uint32": "<u4", "float": "<f4", "float32": "<f4",
}


def read_ply(path):
    """A binary little-endian file of triangles."""
    data = path.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    header = [line.split() for line in data[:end].decode("ascii").splitlines()]
    if ["format", "binary_little_endian", "1.0"] not in header:
        raise Unsupported(f"{path.name}: not a binary little-endian PLY file")
    counts = {words[1]: int(words[2]) for words in header if words[0] == "element"}
    names = [words for words in header if words[0] == "property" and words[1] != "list"]
    vertex_type = np.dtype([(words[2], PLY_TYPES[words[1]]) for words in names])
    listed = next(words for words in header if words[:2] == ["property", "list"])
    face_type = np.dtype([("count", PLY_TYPES[listed[2]]), ("indices", PLY_TYPES[listed[3]], 3)])
    vertices = np.frombuffer(data, vertex_type, counts["vertex"], end)
    faces = np.frombuffer(data, face_type, counts["face"], end + vertices.nbytes)
    if np.any(faces["count"] != 3):
        raise Unsupported(f"{path.name}: faces that are not triangles")
    columns = lambda keys: np.stack([vertices[key] for key in keys], axis=1).astype(float)
    present = set(vertex_type.names)
    normals = columns(["nx", "ny", "nz"]) if "nx" in present else None
    texture = next((pair for pair in (["u", "v"], ["s", "t"]) if pair[0] in present), None)
    return columns("xyz"), faces["indices"].astype(int), normals, columns(texture) if texture else None
