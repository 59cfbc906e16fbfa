"""Transforms of points as 4x4 matrices, for scenes in dictionaries. Matrices are combined by ``@``; the right one is applied first."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

__all__ = ["look_at", "rotate", "scale", "translate"]


def translate(offset: Sequence[float]) -> np.ndarray:
    """Moves points by an offset of three numbers."""
    matrix = np.eye(4)
    matrix[:3, 3] = offset
    return matrix


def scale(factors: float | Sequence[float]) -> np.ndarray:
    """Multiplies coordinates by a number, or by one number each."""
    return np.diag([*np.broadcast_to(np.asarray(factors, dtype=float), 3), 1.0])


def rotate(axis: Sequence[float], angle: float) -> np.ndarray:
    """Rotates points about an axis through the origin, by an angle in degrees, counterclockwise when the axis points at the viewer."""
    x, y, z = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    theta = np.deg2rad(angle)
    matrix = np.eye(4)
    matrix[:3, :3] += np.sin(theta) * cross + (1.0 - np.cos(theta)) * cross @ cross
    return matrix


def look_at(origin: Sequence[float], target: Sequence[float], up: Sequence[float] = (0.0, 1.0, 0.0)) -> np.ndarray:
    """The frame of a camera at ``origin`` that looks at ``target``, as Mitsuba's ``look_at``.

    Raises:
        ValueError: ``up`` is parallel to the view, or both points are equal.
    """
    start = np.asarray(origin, dtype=float)
    view = np.asarray(target, dtype=float) - start
    left = np.cross(np.asarray(up, dtype=float), view)
    if not np.linalg.norm(left) > 0.0:
        raise ValueError(f"look_at: found the view {view.tolist()} and up {list(up)}, expected two directions")
    view /= np.linalg.norm(view)
    left /= np.linalg.norm(left)
    matrix = np.eye(4)
    matrix[:3, :3] = np.column_stack([left, np.cross(view, left), view])
    matrix[:3, 3] = start
    return matrix
