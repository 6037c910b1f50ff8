"""The three axes of one set turned together by least squares, in machine code; see `plane_fits.refine`."""

from __future__ import annotations

import numpy as np
from numba import njit

from blockstab.boxes.compiled.extent import along, ends, nearest_face
from blockstab.boxes.compiled.planes import crossed
from blockstab.boxes.compiled.symmetric import solved
from blockstab.boxes.plane_fits import BORDER_SHARE, ON_FACE, REFINE_STEPS, RIDGE


@njit(error_model="numpy")
def refine(rotation, points, tolerance, axis):
    """Turn the axes, the columns of `rotation` (3, 3), so that the points (3, n) lie on their faces.

    Args:
        tolerance: (n,) metres; axis: (3,) about which alone they may turn, or none.
    """
    local, face = np.empty(points.shape), np.empty(points.shape[1], dtype=np.int64)
    for _ in range(REFINE_STEPS):
        for k in range(3):
            along(points, rotation[0, k], rotation[1, k], rotation[2, k], local[k])
        _nearest_faces(local, tolerance, face)
        turn = _turn(points, face, rotation, axis)
        _turned(rotation, turn)


@njit(error_model="numpy")
def _nearest_faces(local, tolerance, face):
    """Write the face that each point lies on, 0 to 5 as in `Boxes`, or -1."""
    rank = int(BORDER_SHARE * local.shape[1])
    low, high = np.empty(3), np.empty(3)
    for k in range(3):
        low[k], high[k] = ends(local[k], rank)
    for i in range(local.shape[1]):
        nearest, least = nearest_face(local[0, i], local[1, i], local[2, i], low, high)
        face[i] = nearest if least < ON_FACE * tolerance[i] else -1


@njit(error_model="numpy")
def _turn(points, face, rotation, axis):
    """The rotation vector (3,) of least squares."""
    mass, mean = np.zeros(6), np.zeros((6, 3))
    for i in range(points.shape[1]):
        if face[i] >= 0:
            mass[face[i]] += 1.0
            for k in range(3):
                mean[face[i], k] += points[k, i]
    for f in range(6):
        for k in range(3):
            mean[f, k] /= max(mass[f], 1.0)
    matrix, right = np.zeros((3, 3)), np.zeros(3)
    normal, centred, lever = np.empty(3), np.empty(3), np.empty(3)
    for i in range(points.shape[1]):
        if face[i] < 0:
            continue
        residual = 0.0
        for k in range(3):
            normal[k], centred[k] = rotation[k, face[i] // 2], points[k, i] - mean[face[i], k]
            residual += normal[k] * centred[k]
        lever[0], lever[1], lever[2] = crossed(normal, centred)
        if axis is not None:
            size = lever[0] * axis[0] + lever[1] * axis[1] + lever[2] * axis[2]
            for k in range(3):
                lever[k] = size * axis[k]
        for j in range(3):
            right[j] -= lever[j] * residual
            for k in range(j + 1):
                matrix[j, k] += lever[j] * lever[k]
    ridge = RIDGE * max(matrix[0, 0] + matrix[1, 1] + matrix[2, 2], 1e-12)
    for k in range(3):
        matrix[k, k] += ridge
    return solved(matrix, right)


@njit(error_model="numpy")
def _turned(rotation, turn):
    """Rotate the axes by the rotation vector (3,), radians (Rodrigues 1840)."""
    angle = max(np.sqrt(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2]), 1e-12)
    pole, sine, cosine = turn / angle, np.sin(angle), np.cos(angle)
    column = np.empty(3)
    for k in range(3):
        for j in range(3):
            column[j] = rotation[j, k]
        ahead = pole[0] * column[0] + pole[1] * column[1] + pole[2] * column[2]
        across = crossed(pole, column)
        for j in range(3):
            rotation[j, k] = cosine * column[j] + sine * across[j] + (1 - cosine) * ahead * pole[j]
