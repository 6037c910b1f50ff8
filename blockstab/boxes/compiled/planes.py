"""Planes among the points of one set, in machine code; see `boxes.plane_fits`.

Points are arrays (3, n), metres: what is done to every point runs along memory.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from blockstab.boxes.compiled.symmetric import least_axis
from blockstab.boxes.plane_fits import DEGENERATE, FLAT_POINTS, FLAT_SHARE


@njit(error_model="numpy")
def first_plane(points, tolerance, draws, inside, normal):
    """Write the `normal` (3,) of the plane of most points among samples, refined by least squares; its offset.

    Args:
        tolerance: (n,); draws: (S, 3); inside: (n,) bool, overwritten.
    """
    count, most, best = points.shape[1], -1, 0.0
    along, across = np.empty(3), np.empty(3)
    for sample in range(len(draws)):
        a = int(draws[sample, 0] * count)
        b, c = int(draws[sample, 1] * count), int(draws[sample, 2] * count)
        for k in range(3):
            along[k], across[k] = points[k, b] - points[k, a], points[k, c] - points[k, a]
        x, y, z = crossed(along, across)
        length = np.sqrt(x * x + y * y + z * z)
        if length < DEGENERATE:
            continue
        x, y, z = x / length, y / length, z / length
        offset = x * points[0, a] + y * points[1, a] + z * points[2, a]
        votes = 0
        for i in range(count):
            votes += abs(x * points[0, i] + y * points[1, i] + z * points[2, i] - offset) < tolerance[i]
        if votes > most:
            most = votes
            normal[0], normal[1], normal[2], best = x, y, z, offset
    if most < 0:
        # Where every sample was degenerate, all points vote: the plane of least squares.
        inside[:] = True
    else:
        within(points, tolerance, normal, best, inside)
    return _least_squares(points, inside, normal)


@njit(error_model="numpy")
def fixed_plane(points, tolerance, draws, normal):
    """The offset of the plane of most points, of a given normal (3,); draws: (S,)."""
    count, most, best = points.shape[1], -1, 0.0
    height = np.empty(count)
    for i in range(count):
        height[i] = normal[0] * points[0, i] + normal[1] * points[1, i] + normal[2] * points[2, i]
    for sample in range(len(draws)):
        offset, votes = height[int(draws[sample] * count)], 0
        for i in range(count):
            votes += abs(height[i] - offset) < tolerance[i]
        if votes > most:
            most, best = votes, offset
    return best


@njit(error_model="numpy")
def perpendicular_plane(points, tolerance, normal, offset, draws, inside, second):
    """Write the normal (3,) of a plane across the first, among points that it leaves over; whether there are enough.

    Args:
        normal: (3,) and offset, of the first; draws: (S, 2); inside: (n,) bool, overwritten.
    """
    count = points.shape[1]
    within(points, tolerance, normal, offset, inside)
    left = 0
    for i in range(count):
        left += not inside[i]
    if left < max(FLAT_SHARE * count, FLAT_POINTS):
        return False
    u, v = spanning(normal)
    # Seen along the first plane, the second is a line.
    seen, reach, chosen = np.empty((2, left)), np.empty(left), 0
    for i in range(count):
        if not inside[i]:
            seen[0, chosen] = u[0] * points[0, i] + u[1] * points[1, i] + u[2] * points[2, i]
            seen[1, chosen] = v[0] * points[0, i] + v[1] * points[1, i] + v[2] * points[2, i]
            reach[chosen] = tolerance[i]
            chosen += 1
    most, across_x, across_y, best = -1, 0.0, 0.0, 0.0
    for sample in range(len(draws)):
        a, b = int(draws[sample, 0] * left), int(draws[sample, 1] * left)
        x, y = -(seen[1, b] - seen[1, a]), seen[0, b] - seen[0, a]
        length = np.sqrt(x * x + y * y)
        if length < DEGENERATE:
            continue
        x, y = x / length, y / length
        away, votes = x * seen[0, a] + y * seen[1, a], 0
        for i in range(left):
            votes += abs(x * seen[0, i] + y * seen[1, i] - away) < reach[i]
        if votes > most:
            most, across_x, across_y, best = votes, x, y, away
    x, y = _line_normal(seen, reach, across_x, across_y, best)
    for k in range(3):
        second[k] = x * u[k] + y * v[k]
    return True


@njit(error_model="numpy")
def within(points, tolerance, normal, offset, inside):
    """Write which points lie on a plane, (n,) bool."""
    for i in range(points.shape[1]):
        height = normal[0] * points[0, i] + normal[1] * points[1, i] + normal[2] * points[2, i]
        inside[i] = abs(height - offset) < tolerance[i]


@njit(error_model="numpy")
def spanning(normal):
    """Two unit vectors that span the plane of a normal, as `plane_basis` has them."""
    least = 0
    for k in range(1, 3):
        if abs(normal[k]) < abs(normal[least]):
            least = k
    helper, u, v = np.zeros(3), np.empty(3), np.empty(3)
    helper[least] = 1.0
    u[0], u[1], u[2] = crossed(normal, helper)
    length = np.sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2])
    for k in range(3):
        u[k] /= length
    v[0], v[1], v[2] = crossed(normal, u)
    return u, v


@njit(error_model="numpy")
def crossed(a, b):
    """The cross product of two vectors."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(error_model="numpy")
def _least_squares(points, inside, normal):
    """Write the normal of the plane of least squares of those inside; its offset."""
    mass, mean, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for i in range(points.shape[1]):
        if inside[i]:
            mass += 1.0
            for j in range(3):
                mean[j] += points[j, i]
                for k in range(j, 3):
                    second[j, k] += points[j, i] * points[k, i]
    mass = max(mass, 1.0)
    for j in range(3):
        mean[j] /= mass
    for j in range(3):
        for k in range(j, 3):
            second[j, k] = second[j, k] / mass - mean[j] * mean[k]
            second[k, j] = second[j, k]
    least_axis(second, normal)
    return normal[0] * mean[0] + normal[1] * mean[1] + normal[2] * mean[2]


@njit(error_model="numpy")
def _line_normal(seen, reach, across_x, across_y, away):
    """Unit normal of the line of least squares through those of the points (2, n) that lie on a first one."""
    mass, mean_x, mean_y = 0.0, 0.0, 0.0
    on_line = np.empty(seen.shape[1], dtype=np.bool_)
    for i in range(seen.shape[1]):
        on_line[i] = abs(across_x * seen[0, i] + across_y * seen[1, i] - away) < reach[i]
        if on_line[i]:
            mass, mean_x, mean_y = mass + 1.0, mean_x + seen[0, i], mean_y + seen[1, i]
    mean_x, mean_y = mean_x / max(mass, 1.0), mean_y / max(mass, 1.0)
    wider, twice = 0.0, 0.0
    for i in range(seen.shape[1]):
        if on_line[i]:
            x, y = seen[0, i] - mean_x, seen[1, i] - mean_y
            wider += x * x - y * y
            twice += 2 * x * y
    slope = twice / max(np.sqrt(wider * wider + twice * twice) + abs(wider), np.finfo(np.float64).tiny)
    length = np.sqrt(1 + slope * slope)
    return (-1 / length, slope / length) if wider < 0 else (-slope / length, 1 / length)
