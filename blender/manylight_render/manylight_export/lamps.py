# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's lamps as lights and emitting meshes of a glTF file.

Units are those of Cycles, which a test compares: a point or spot of P watts has the radiant intensity P / 4π, an area lamp
of area A the radiance P / πA on its front, a sun the irradiance of its strength. Lights of the file are in W/sr and W/m².
"""

import math
from dataclasses import dataclass, field

import numpy as np

from . import geometry
from .glb import Glb

# Sun lamps of a smaller angular diameter in radians are parallel light; larger ones become discs of the environment.
SMALLEST_SUN = math.radians(0.2)
# Light group of what has none.
NO_GROUP = "rest"
# Points by which a spot lamp with a radius is replaced.
SPOT_POINTS = 32
# Opacity of surfaces that emit: in glTF, it scales the emission as well, so that it cannot be 0.
LAMP_OPACITY = 1e-4
EMISSIVE_STRENGTH = "KHR_materials_emissive_strength"
PUNCTUAL = "KHR_lights_punctual"


@dataclass
class Sun:
    """A disc in the sky."""

    direction: tuple  # unit, towards the sun, in Blender's world
    irradiance: tuple  # (r, g, b) of a surface that faces it, W/m²
    angle: float  # angular diameter, radians
    is_seen: bool = False  # by the camera


@dataclass
class Lamp:
    """What a lamp of Blender says, as plain data."""

    name: str
    kind: str  # POINT, SUN, SPOT, AREA
    matrix: np.ndarray  # (4, 4), local to world
    energy: float  # W, of a sun W/m², with exposure
    color: tuple  # (r, g, b), with the color temperature and the factor of its shader
    normalize: bool = True  # whether energy is divided by the lamp's area
    radius: float = 0.0
    spot_size: float = 0.0  # full angle of the cone, radians
    spot_blend: float = 0.0
    angle: float = 0.0  # angular diameter of a sun, radians
    shape: str = "SQUARE"
    size: float = 0.0
    size_y: float = 0.0
    is_seen: bool = False  # by the camera
    group: str = ""  # light group


def colored(strength, color):
    """A light's `color` and `intensity` in glTF: the greatest component is the intensity."""
    values = [max(0.0, strength * c) for c in color]
    peak = max(values)
    return {"color": [v / peak for v in values] if peak > 0 else [0.0, 0.0, 0.0], "intensity": peak}


def in_gltf(matrix):
    """`matrix` of a node: from its local axes to glTF's world, in columns."""
    return (geometry.GLTF_FROM_BLENDER @ matrix).T.ravel().tolist()


def rigid(matrix):
    """The matrix without its scale."""
    result = np.identity(4)
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    axes = matrix[:3, :3] / np.where(lengths > 0, lengths, 1.0)
    if np.linalg.det(axes) < 0:
        axes[:, 0] *= -1
    result[:3, :3], result[:3, 3] = axes, matrix[:3, 3]
    return result


@dataclass
class LampWriter:
    """Adds lamps to a document."""

    glb: Glb
    suns: list = field(default_factory=list)  # discs, which the environment has to show
    seen: set = field(default_factory=set)  # indices of materials of surfaces that the camera sees
    hidden: int = 0  # surfaces that the camera must not see

    def add(self, lamp):
        if lamp.energy <= 0 or max(lamp.color) <= 0:
            return
        {"POINT": self.point, "SPOT": self.spot, "SUN": self.sun, "AREA": self.area}[lamp.kind](lamp)

    def point(self, lamp):
        if lamp.radius <= 0:
            self.punctual(lamp, "point", lamp.matrix, self.intensity(lamp))
            return
        positions, triangles = geometry.sphere()
        place = np.identity(4)
        place[:3, 3] = lamp.matrix[:3, 3]
        place[:3, :3] *= lamp.radius
        self.surface(lamp, positions, triangles, place, self.intensity(lamp) / (math.pi * lamp.radius**2))

    def intensity(self, lamp):
        """Radiant intensity of points and spots, W/sr."""
        if lamp.normalize:
            return lamp.energy / (4 * math.pi)
        return lamp.energy * lamp.radius**2 if lamp.radius > 0 else lamp.energy / math.pi

    def spot(self, lamp):
        outer = 0.5 * lamp.spot_size
        # The loader takes cones of Blender's files as the exporter writes them: the inner one is (1 - blend) of the outer.
        cone = {"outerConeAngle": outer, "innerConeAngle": (1 - lamp.spot_blend) * outer}
        strength = self.intensity(lamp)
        matrix = rigid(lamp.matrix)
        for offset in spiral(SPOT_POINTS if lamp.radius > 0 else 1):
            place = matrix.copy()
            place[:3, 3] += matrix[:3, :2] @ (lamp.radius * offset)
            self.punctual(lamp, "spot", place, strength / (SPOT_POINTS if lamp.radius > 0 else 1), spot=cone)

    def sun(self, lamp):
        strength = lamp.energy
        if not lamp.normalize and lamp.angle > 0:
            strength *= math.pi * math.sin(0.5 * lamp.angle) ** 2
        if lamp.angle < SMALLEST_SUN:
            self.punctual(lamp, "directional", lamp.matrix, strength)
            return
        direction = rigid(lamp.matrix)[:3, 2]
        self.suns.append(Sun(tuple(direction), tuple(strength * c for c in lamp.color), lamp.angle, lamp.is_seen))

    def area(self, lamp):
        is_round = lamp.shape in ("DISK", "ELLIPSE")
        size_y = lamp.size_y if lamp.shape in ("RECTANGLE", "ELLIPSE") else lamp.size
        positions, triangles = geometry.disc() if is_round else geometry.rectangle()
        scale = np.diag([lamp.size, size_y, 1.0, 1.0])
        place = lamp.matrix @ scale
        x, y = place[:3, 0], place[:3, 1]
        area = np.linalg.norm(np.cross(x, y)) * (math.pi / 4 if is_round else 1.0)
        if area <= 0:
            return
        front = -place[:3, 2]
        if np.dot(np.cross(y, x), front) < 0:
            triangles = triangles[:, ::-1]
        self.surface(lamp, positions, triangles, place, lamp.energy / (math.pi * (area if lamp.normalize else 1.0)))

    def punctual(self, lamp, kind, matrix, strength, **more):
        glb = self.glb
        glb.use(PUNCTUAL)
        lights = glb.json.setdefault("extensions", {}).setdefault(PUNCTUAL, {}).setdefault("lights", [])
        lights.append({"type": kind, "name": lamp.name, **colored(strength, lamp.color), **more})
        extension = {PUNCTUAL: {"light": len(lights) - 1}}
        glb.add_node(name=lamp.name, matrix=in_gltf(rigid(matrix)), extensions=extension, extras=group_extras(lamp.group))

    def surface(self, lamp, positions, triangles, matrix, radiance):
        """A surface that emits to its front and neither reflects nor blocks light, as lamps of Cycles."""
        glb = self.glb
        world = positions @ matrix[:3, :3].T + matrix[:3, 3]
        world = world @ geometry.GLTF_FROM_BLENDER[:3, :3].T
        emission = colored(radiance / LAMP_OPACITY, lamp.color)
        glb.use(EMISSIVE_STRENGTH)
        material = invisible(lamp.name, LAMP_OPACITY) | {
            "emissiveFactor": emission["color"],
            "extensions": {EMISSIVE_STRENGTH: {"emissiveStrength": emission["intensity"]}},
        }
        index = glb.append("materials", material)
        primitive = glb.add_primitive(world, triangles, index)
        if lamp.is_seen:
            self.seen.add(index)
        else:
            self.hidden += 1
        mesh = glb.append("meshes", {"name": lamp.name, "primitives": [primitive]})
        glb.add_node(name=lamp.name, mesh=mesh, extras=group_extras(lamp.group))


def group_extras(group):
    """The extras of a node with emitters of a light group; without them, the loader takes the name of the node for the group."""
    return {"lightgroup": group or NO_GROUP}


def spiral(count):
    """Points (count, 2) that cover the unit disc evenly; the center for one point."""
    if count == 1:
        return np.zeros((1, 2))
    i = np.arange(count)
    radius, angle = np.sqrt((i + 0.5) / count), i * math.pi * (3 - math.sqrt(5))
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], 1)


def invisible(name, opacity=0):
    """A material that light passes without change but for its opacity."""
    return {
        "name": name,
        "alphaMode": "BLEND",
        "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, opacity], "metallicFactor": 0, "roughnessFactor": 1},
    }
