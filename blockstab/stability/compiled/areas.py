"""Support areas of one box on another, projected on the ground, in machine code; see `stability.area`."""

from __future__ import annotations

import numpy as np
from numba import njit

from blockstab.stability.area import TIE
from blockstab.stability.compiled.polygons import hull

_EDGES = np.array([[a, b] for a in range(8) for b in range(a + 1, 8) if a ^ b in (1, 2, 4)])


@njit(error_model="numpy")
def footprint(corners):
    """The shadow (k, 2) of a box with corners (8, 3)."""
    points = np.empty((8, 2))
    for c in range(8):
        points[c, 0], points[c, 1] = corners[c, 0], corners[c, 2]
    return hull(points)


@njit(error_model="numpy")
def lowest_corners(corners, reach):
    """The hull (k, 2) of those of the corners (8, 3) that are at most `reach` above the lowest."""
    lowest = bottom(corners)
    points, count = np.empty((8, 2)), 0
    for c in range(8):
        if corners[c, 1] <= lowest + reach:
            points[count, 0], points[count, 1] = corners[c, 0], corners[c, 2]
            count += 1
    return hull(points[:count])


@njit(error_model="numpy")
def bottom(corners):
    """The height of the lowest of the corners (8, 3)."""
    lowest = np.inf
    for c in range(8):
        lowest = min(lowest, corners[c, 1])
    return lowest


@njit(error_model="numpy")
def touching_edge(corners, center, rotation, half_extent):
    """The edge of a box with corners (8, 3) nearest to another box, (2, 2), or a point where it is upright."""
    distance = np.empty(8)
    for c in range(8):
        distance[c] = _distance(corners[c], center, rotation, half_extent)
    least = np.inf
    for e in range(len(_EDGES)):
        least = min(least, (distance[_EDGES[e, 0]] + distance[_EDGES[e, 1]]) / 2)
    best = 0
    while (distance[_EDGES[best, 0]] + distance[_EDGES[best, 1]]) / 2 > least + TIE:
        best += 1
    ends = np.empty((2, 2))
    for k in range(2):
        ends[k, 0], ends[k, 1] = corners[_EDGES[best, k], 0], corners[_EDGES[best, k], 2]
    return ends[:1] if ends[0, 0] == ends[1, 0] and ends[0, 1] == ends[1, 1] else ends


@njit(error_model="numpy")
def _distance(point, center, rotation, half_extent):
    """From a point to a box, metres; within it, minus the distance to the nearest face."""
    squared, deepest = 0.0, -np.inf
    for axis in range(3):
        local = 0.0
        for k in range(3):
            local += (point[k] - center[k]) * rotation[k, axis]
        beyond = abs(local) - half_extent[axis]
        deepest = max(deepest, beyond)
        squared += max(beyond, 0.0) ** 2
    return np.sqrt(squared) if deepest > 0 else deepest
