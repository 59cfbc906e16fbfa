# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes of lamps, and shells around emitting meshes. Arrays of numpy, without Blender."""

import numpy as np

DISC_CORNERS = 64
SPHERE_SUBDIVISIONS = 3
# Blender has z up, glTF y up: glTF's (x, y, z) is Blender's (x, z, -y).
GLTF_FROM_BLENDER = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]], np.float64)


def rectangle():
    """A square of edge 1 in the plane z = 0, which faces -z: positions (4, 3), triangles (2, 3)."""
    positions = np.array([[-0.5, -0.5, 0], [0.5, -0.5, 0], [0.5, 0.5, 0], [-0.5, 0.5, 0]])
    return positions, np.array([[0, 2, 1], [0, 3, 2]])


def disc():
    """A regular polygon around a circle of diameter 1, with the circle's area, in the plane z = 0; it faces -z."""
    angles = 2 * np.pi * np.arange(DISC_CORNERS) / DISC_CORNERS
    radius = 0.5 * np.sqrt(np.pi / (0.5 * DISC_CORNERS * np.sin(2 * np.pi / DISC_CORNERS)))
    ring = radius * np.stack([np.cos(angles), np.sin(angles), np.zeros(DISC_CORNERS)], 1)
    corners = 1 + np.arange(DISC_CORNERS)
    triangles = np.stack([np.zeros(DISC_CORNERS, int), np.roll(corners, -1), corners], 1)
    return np.concatenate([[[0, 0, 0]], ring]), triangles


def sphere():
    """An icosphere around the origin with the area of the unit sphere; it faces outwards."""
    golden = (1 + 5**0.5) / 2
    signs = [(a, b) for a in (-1, 1) for b in (-golden, golden)]
    points = [p for a, b in signs for p in ((0, a, b), (a, b, 0), (b, 0, a))]
    positions = np.array(points, np.float64)
    positions /= np.linalg.norm(positions, axis=1, keepdims=True)
    triangles = icosahedron_faces(positions)
    for _ in range(SPHERE_SUBDIVISIONS):
        positions, triangles = subdivided(positions, triangles)
    area = triangle_areas(positions, triangles).sum()
    return positions * np.sqrt(4 * np.pi / area), triangles


def icosahedron_faces(positions):
    """The triples of vertices at the smallest distance, wound so that normals point outwards."""
    distances = np.linalg.norm(positions[:, None] - positions[None], axis=2)
    near = (distances > 0) & (distances < 1.01 * distances[distances > 0].min())
    faces = []
    count = len(positions)
    for i in range(count):
        for j in range(i + 1, count):
            for k in range(j + 1, count):
                if near[i, j] and near[j, k] and near[i, k]:
                    a, b, c = positions[[i, j, k]]
                    outwards = np.dot(np.cross(b - a, c - a), a) > 0
                    faces.append((i, j, k) if outwards else (i, k, j))
    return np.array(faces)


def subdivided(positions, triangles):
    """Every triangle as four; new vertices lie on the unit sphere."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    unique, inverse = np.unique(np.sort(edges, 1), axis=0, return_inverse=True)
    middles = positions[unique].mean(1)
    middles /= np.linalg.norm(middles, axis=1, keepdims=True)
    ab, bc, ca = (len(positions) + inverse.reshape(-1)).reshape(3, -1)
    a, b, c = triangles.T
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([positions, middles]), np.concatenate([np.stack(part, 1) for part in parts])


def triangle_areas(positions, triangles):
    a, b, c = positions[triangles].transpose(1, 0, 2)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def moved_along_normals(positions, triangles, distance):
    """The surface moved by `distance` along its normals. Vertices at one place move together, so that it does not tear."""
    places, place_of = np.unique(positions, axis=0, return_inverse=True)
    place_of = place_of.reshape(-1)
    a, b, c = positions[triangles].transpose(1, 0, 2)
    area_normals = np.cross(b - a, c - a)
    sums = np.zeros_like(places, dtype=np.float64)
    for corner in range(3):
        np.add.at(sums, place_of[triangles[:, corner]], area_normals)
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    normals = np.divide(sums, lengths, out=np.zeros_like(sums), where=lengths > 0)
    return positions + distance * normals[place_of]
