# SPDX-License-Identifier: GPL-3.0-or-later
"""Shells that keep emitting meshes visible.

Cameras see emitting meshes but not lamps, if a lamp does not say otherwise. The renderer can hide emitters that a camera ray
meets before any other surface, all of them. So lamps are hidden, and each emitting mesh of the scene gets a shell that light
passes without change: the mesh then lies behind another surface and is seen.
"""

import numpy as np

from . import geometry
from .lamps import invisible

# Distance of the shell as a fraction of the mesh's diagonal. The loader adds the back of a two-sided emitter 1e-4 behind its
# front, and the shells have to enclose both.
DISTANCE = 2e-4


def add_shells(glb, emitting):
    """Adds shells to all primitives with one of the materials `emitting`, by index."""
    shell_material = None
    for mesh in glb.json.get("meshes", []):
        added = []
        for primitive in mesh["primitives"]:
            if primitive.get("material") not in emitting or primitive.get("mode", 4) != 4:
                continue
            if shell_material is None:
                shell_material = glb.append("materials", invisible("shell of an emitter"))
            added += shell(glb, primitive, shell_material)
        mesh["primitives"] += added


def emits(material):
    """Whether a material emits, textured or not."""
    is_unlit = "KHR_materials_unlit" in material.get("extensions", {})
    return is_unlit or any(material.get("emissiveFactor", ()))


def shell(glb, primitive, material):
    """Primitives in front of and behind the surface."""
    positions = glb.array(primitive["attributes"]["POSITION"]).astype(np.float64)
    if "indices" in primitive:
        triangles = glb.array(primitive["indices"]).astype(int).reshape(-1, 3)
    else:
        triangles = np.arange(len(positions)).reshape(-1, 3)
    if not len(triangles):
        return []
    distance = DISTANCE * np.linalg.norm(positions.max(0) - positions.min(0))
    moved = (geometry.moved_along_normals(positions, triangles, d) for d in (distance, -distance))
    return [glb.add_primitive(surface, triangles, material) for surface in moved]
