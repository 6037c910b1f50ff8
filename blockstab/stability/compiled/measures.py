"""Area, centre and distance of one convex polygon, in machine code; see `convex` and `balance.margins`."""

from __future__ import annotations

import numpy as np
from numba import njit

from blockstab.stability.balance import EDGE_REACH


@njit(error_model="numpy")
def area(polygon):
    """Square metres."""
    total = 0.0
    for i in range(len(polygon) - 1):
        total += _weight(polygon, i)
    return 0.5 * total


@njit(error_model="numpy")
def centroid(polygon):
    """The centre of area x, y: of a segment its middle, of a point itself, NaN where empty."""
    count = len(polygon)
    if count == 0:
        return np.nan, np.nan
    x, y = polygon[0, 0], polygon[0, 1]
    if count < 3:
        return x + 0.5 * (polygon[-1, 0] - x), y + 0.5 * (polygon[-1, 1] - y)
    total, total_x, total_y = 0.0, 0.0, 0.0
    for i in range(count - 1):
        weight = _weight(polygon, i)
        total += weight
        total_x += ((polygon[i, 0] - x) + (polygon[i + 1, 0] - x)) * weight
        total_y += ((polygon[i, 1] - y) + (polygon[i + 1, 1] - y)) * weight
    return x + total_x / (3.0 * total), y + total_y / (3.0 * total)


@njit(error_model="numpy")
def margin(polygon, x, y):
    """Distance of a point inside a polygon, metres, negative outside; see `balance.margins`. NaN where empty."""
    count = len(polygon)
    if count == 0:
        return np.nan
    distance = _signed_distance(polygon, x, y)
    return distance + EDGE_REACH if count <= 2 else distance


@njit(error_model="numpy")
def _signed_distance(polygon, x, y):
    count = len(polygon)
    depth, nearest = np.inf, np.inf
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        edge_x, edge_y = polygon[j, 0] - polygon[i, 0], polygon[j, 1] - polygon[i, 1]
        arm_x, arm_y = x - polygon[i, 0], y - polygon[i, 1]
        squared, share = edge_x * edge_x + edge_y * edge_y, 0.0
        if squared > 0:
            depth = min(depth, (edge_x * arm_y - edge_y * arm_x) / np.sqrt(squared))
            share = min(max((arm_x * edge_x + arm_y * edge_y) / squared, 0.0), 1.0)
        off_x, off_y = arm_x - share * edge_x, arm_y - share * edge_y
        nearest = min(nearest, off_x * off_x + off_y * off_y)
    return depth if count > 2 and depth >= 0 else -np.sqrt(nearest)


@njit(error_model="numpy")
def _weight(polygon, i):
    """Twice the area of the triangle of the first vertex, vertex i and the next."""
    a_x, a_y = polygon[i, 0] - polygon[0, 0], polygon[i, 1] - polygon[0, 1]
    b_x, b_y = polygon[i + 1, 0] - polygon[0, 0], polygon[i + 1, 1] - polygon[0, 1]
    return a_x * b_y - a_y * b_x
