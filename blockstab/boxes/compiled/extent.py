"""Extents of boxes of given axes around the points of one set, in machine code; see `boxes.extent`.

Points are arrays (3, n), metres.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from blockstab.boxes.box import MIN_HALF_EXTENT
from blockstab.boxes.compiled.planes import crossed, spanning
from blockstab.boxes.extent import COARSE, FINE

_COARSE, _FINE = COARSE.numpy(), FINE.numpy()


@njit(error_model="numpy")
def enclose(points, rotation, outlier_share, away, center, half):
    """Write the `center` and the `half` extent (3,) of the box that leaves out a sixth of a share on each face.

    Args:
        rotation: (3, 3), columns are axes; away: (3,) from the camera to the points.
    """
    rank = int(outlier_share / 6 * points.shape[1])
    local, middle = np.empty(points.shape[1]), np.empty(3)
    for k in range(3):
        along(points, rotation[0, k], rotation[1, k], rotation[2, k], local)
        low, high = ends(local, rank)
        thick, ahead = (high - low) / 2, 0.0
        for j in range(3):
            ahead += away[j] * rotation[j, k]
        half[k] = max(thick, MIN_HALF_EXTENT)
        # What was seen is the near face: a box is thickened away from the camera.
        middle[k] = (low + high) / 2 + np.sign(ahead) * (half[k] - thick)
    for j in range(3):
        center[j] = 0.0
        for k in range(3):
            center[j] += rotation[j, k] * middle[k]


@njit(error_model="numpy")
def flat_frame(points, normal, outlier_share, rotation):
    """Write the axes (3, 3) of what is one flat face: its normal, and the sides of the least rectangle around it."""
    u, v = spanning(normal)
    seen = np.empty((2, points.shape[1]))
    along(points, u[0], u[1], u[2], seen[0])
    along(points, v[0], v[1], v[2], seen[1])
    rank = int(outlier_share / 4 * points.shape[1])
    cosine, sine = _smallest(seen, rank, _COARSE, 1.0, 0.0)
    cosine, sine = _smallest(seen, rank, _FINE, cosine, sine)
    side = np.empty(3)
    for k in range(3):
        side[k] = cosine * u[k] + sine * v[k]
        rotation[k, 0], rotation[k, 1] = normal[k], side[k]
    rotation[0, 2], rotation[1, 2], rotation[2, 2] = crossed(normal, side)


@njit(error_model="numpy")
def surface_distances(points, center, rotation, half, distance):
    """Write the distances of the points to the surface of a box, (n,) metres (the paper's D_min)."""
    shift = np.empty(3)
    for k in range(3):
        shift[k] = center[0] * rotation[0, k] + center[1] * rotation[1, k] + center[2] * rotation[2, k]
    for i in range(points.shape[1]):
        nearest, squared = np.inf, 0.0
        for k in range(3):
            local = points[0, i] * rotation[0, k] + points[1, i] * rotation[1, k]
            local = local + points[2, i] * rotation[2, k] - shift[k]
            beyond = abs(local) - half[k]
            nearest = min(nearest, -beyond)
            squared += max(beyond, 0.0) ** 2
        distance[i] = nearest if nearest >= 0 else np.sqrt(squared)


@njit(error_model="numpy")
def along(points, x, y, z, height):
    """Write the coordinates (n,) of points along an axis."""
    for i in range(points.shape[1]):
        height[i] = x * points[0, i] + y * points[1, i] + z * points[2, i]


@njit(error_model="numpy")
def nearest_face(x, y, z, low, high):
    """The face that coordinates along three axes are nearest to, 0 to 5 as in `Boxes`, and how near.

    Args:
        low, high: (3,) where the faces lie along each axis.
    """
    nearest, least = 0, np.inf
    for k, place in enumerate((x, y, z)):
        above, below = abs(high[k] - place), abs(place - low[k])
        if above < least:
            nearest, least = 2 * k, above
        if below < least:
            nearest, least = 2 * k + 1, below
    return nearest, least


@njit(error_model="numpy")
def ends(values, rank):
    """The values that `rank` others are below, and above."""
    low, high = np.full(rank + 1, np.inf), np.full(rank + 1, -np.inf)
    for i in range(len(values)):
        # Few points push others out of so short a list.
        if values[i] < low[rank]:
            k = rank
            while k > 0 and low[k - 1] > values[i]:
                low[k] = low[k - 1]
                k -= 1
            low[k] = values[i]
        if values[i] > high[rank]:
            k = rank
            while k > 0 and high[k - 1] < values[i]:
                high[k] = high[k - 1]
                k -= 1
            high[k] = values[i]
    return low[rank], high[rank]


@njit(error_model="numpy")
def _smallest(seen, rank, directions, cosine, sine):
    """Of directions (K, 2), turned by an angle, that of the least rectangle around the points (2, n)."""
    count, least, best = seen.shape[1], np.inf, (cosine, sine)
    height = np.empty(count)
    for d in range(len(directions)):
        x = cosine * directions[d, 0] - sine * directions[d, 1]
        y = sine * directions[d, 0] + cosine * directions[d, 1]
        for i in range(count):
            height[i] = x * seen[0, i] + y * seen[1, i]
        low, high = ends(height, rank)
        wide = high - low
        for i in range(count):
            height[i] = -y * seen[0, i] + x * seen[1, i]
        low, high = ends(height, rank)
        if wide * (high - low) < least:
            least, best = wide * (high - low), (x, y)
    return best
