# SPDX-License-Identifier: GPL-3.0-or-later
"""Equirectangular images of the sky: their directions, and sun discs in them. Arrays of numpy, without Blender.

Images of Blender have their first row half a pixel from the pole; the renderer, as Mitsuba, takes the first and the last row
as the poles themselves. `with_poles` leads from one to the other, and suns are drawn into the result.
"""

import math

import numpy as np

# Pixels across a sun disc, and the largest width in pixels for the sake of one.
SUN_PIXELS = 5
LARGEST_SUN_WIDTH = 2048
SUBPIXELS = 8


def directions(u, v):
    """Unit vectors in Blender's world at (u, v) in [0, 1]², v from the top down: the center of the image is +x, the quarter
    to its right -y."""
    azimuth, elevation = 2 * math.pi * (0.5 - u), math.pi * (0.5 - v)
    across = np.cos(elevation)
    return np.stack([across * np.cos(azimuth), across * np.sin(azimuth), np.sin(elevation)], -1)


def width_for_suns(suns):
    """Width in pixels of an image that shows the discs."""
    smallest = min(sun.angle for sun in suns)
    wanted = SUN_PIXELS * 2 * math.pi / smallest
    return min(LARGEST_SUN_WIDTH, 2 ** max(6, math.ceil(math.log2(wanted))))


def enlarged(image, width):
    """The image with at least `width` pixels across, each pixel repeated."""
    if image.shape[0] == 1:
        return np.broadcast_to(image, (width // 2, width, 3)).copy()
    factor = math.ceil(width / image.shape[1])
    return image.repeat(factor, 0).repeat(factor, 1) if factor > 1 else image.copy()


def with_poles(image):
    """The image with rows at the poles and halfway between the rows: interpolated linearly, (2 height + 1, width, 3)."""
    height, width, _ = image.shape
    result = np.empty((2 * height + 1, width, 3), np.float32)
    result[1::2] = image
    result[2:-1:2] = 0.5 * (image[:-1] + image[1:])
    result[0], result[-1] = image[0].mean(0), image[-1].mean(0)
    return result


def add_sun(image, sun):
    """Adds the disc of a sun to an image with rows at the poles, so that its irradiance is exact on the pixels."""
    height, width, _ = image.shape
    radius, toward = 0.5 * sun.angle, np.array(sun.direction)
    rows, columns = np.mgrid[0:height, 0:width]
    centers = directions((columns + 0.5) / width, rows / (height - 1))
    near = np.arccos(np.clip(centers @ toward, -1, 1)) < radius + 2 * math.pi / width
    rows, columns, centers = rows[near], columns[near], centers[near]
    coverage = np.zeros(len(rows))
    steps = (np.arange(SUBPIXELS) + 0.5) / SUBPIXELS
    for dy in steps - 0.5:
        for dx in steps:
            inside = directions((columns + dx) / width, (rows + dy) / (height - 1)) @ toward >= math.cos(radius)
            coverage += inside / SUBPIXELS**2
    elevations = math.pi * (0.5 - rows / (height - 1))
    solid_angles = 2 * math.pi**2 / (width * (height - 1)) * np.cos(elevations)
    total = (coverage * solid_angles * np.maximum(centers @ toward, 0)).sum()
    image[rows, columns] += coverage[:, None] / total * np.array(sun.irradiance)
