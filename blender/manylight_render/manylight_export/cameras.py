# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's cameras as cameras of a glTF file, with the film and the part of it that is rendered.

glTF knows no shift. A shifted perspective camera is a window of a larger film around the axis: the film grows until the
window fits. Windows begin at whole pixels, so a shift is met to a quarter of a pixel. Orthographic cameras move instead.
"""

import math
from dataclasses import dataclass

import numpy as np

from . import geometry
from .lamps import in_gltf, rigid


@dataclass
class Film:
    """Size of the film in pixels, and the first column and row (from the top) of the rendered window, and its size."""

    size: tuple
    window: tuple


@dataclass
class Camera:
    """What a camera of Blender says."""

    name: str
    is_orthographic: bool
    matrix: np.ndarray  # (4, 4), local to world
    projection: np.ndarray  # (4, 4), OpenGL's convention, of the whole picture
    clip_start: float
    clip_end: float


def film(camera, size, border):
    """The film for a picture of `size` pixels of which the `border` (x, y, width, height; y from the top) is rendered."""
    p = camera.projection
    shifts = (0, 0) if camera.is_orthographic else (p[0, 2] * size[0] / 2, -p[1, 2] * size[1] / 2)
    grown, starts = [], []
    for length, shift, start in zip(size, shifts, border[:2]):
        more = round(2 * abs(shift))
        grown.append(length + more)
        starts.append((more if shift > 0 else 0) + start)
    return Film(tuple(grown), (*starts, *border[2:]))


def place_of(camera):
    """The matrix (4, 4) from the camera to Blender's world. A shift of an orthographic camera moves it."""
    p = camera.projection
    place = rigid(camera.matrix)
    if camera.is_orthographic:
        place[:3, 3] -= place[:3, :2] @ (p[:2, 3] / (p[0, 0], p[1, 1]))
    return place


def of_frames(cameras):
    """Matrices from the cameras of frames to glTF's world, for cameras that look along +z, with +y up and +x to the left."""
    turned = np.diag([-1.0, 1.0, -1.0, 1.0])
    return [(geometry.GLTF_FROM_BLENDER @ place_of(camera) @ turned).tolist() for camera in cameras]


def add_camera(glb, camera, size, film):
    """Adds the camera with the view of the whole film. `size`: the picture in pixels."""
    p = camera.projection
    if camera.is_orthographic:
        lens = {"xmag": 1 / p[0, 0], "ymag": 1 / p[1, 1]}
    else:
        yfov = 2 * math.atan(film.size[1] / size[1] / p[1, 1])
        lens = {"yfov": yfov, "aspectRatio": film.size[0] / film.size[1]}
    lens |= {"znear": camera.clip_start, "zfar": camera.clip_end}
    kind = "orthographic" if camera.is_orthographic else "perspective"
    index = glb.append("cameras", {"type": kind, kind: lens, "name": camera.name})
    glb.add_node(name=camera.name, camera=index, matrix=in_gltf(place_of(camera)))


def pixel_aspect(camera, size):
    """Width of a pixel over its height."""
    return (camera.projection[1, 1] * size[1]) / (camera.projection[0, 0] * size[0])
