"""Boxes of minimum surface distance in one call of machine code, which is kept on disk; see `boxes.fitting`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from blockstab.boxes.compiled.extent import enclose, flat_frame, nearest_face, surface_distances
from blockstab.boxes.compiled.planes import crossed, first_plane, fixed_plane, perpendicular_plane
from blockstab.boxes.compiled.refining import refine
from blockstab.determinism.machine_code import fingerprint_of


class Constants(NamedTuple):
    """Those of `MinimumSurface` that the fit of one set asks for."""

    judged_points: int
    outlier_share: float
    floor_m: float
    per_square_m: float


class Found(NamedTuple):
    """N fits, as in `fitting.Fits`."""

    center: np.ndarray
    rotation: np.ndarray
    half_extent: np.ndarray
    mean: np.ndarray
    variance: np.ndarray
    visible_share: np.ndarray


@njit(error_model="numpy")
def _fit(points, draws, axis, constants, center, rotation, half):
    """Write the box of one set of points (n, 3); the mean and variance of distances, and the visible share.

    Args:
        draws: (R, S, 5) uniform numbers; axis: (3,) or none; center: (3,), rotation: (3, 3), half: (3,) are written.
    """
    count, origin = len(points), np.zeros(3)
    for i in range(count):
        for k in range(3):
            origin[k] += points[i, k]
    for k in range(3):
        origin[k] /= count
    moved, tolerance = np.empty((3, count)), np.empty(count)
    for i in range(count):
        square = 0.0
        for k in range(3):
            square += points[i, k] * points[i, k]
            moved[k, i] = points[i, k] - origin[k]
        tolerance[i] = constants.floor_m + constants.per_square_m * square
    few = min(count, constants.judged_points)
    _choose(np.ascontiguousarray(moved[:, :few]), tolerance[:few], draws, axis, constants, origin, rotation)
    refine(rotation, moved, tolerance, axis)
    enclose(moved, rotation, constants.outlier_share, origin, center, half)
    distance = np.empty(count)
    surface_distances(moved, center, rotation, half, distance)
    share = _visible_share(moved, center, origin, rotation, half)
    for k in range(3):
        center[k] += origin[k]
    return *_mean_and_variance(distance), share


@njit(error_model="numpy")
def _choose(points, tolerance, draws, axis, constants, away, rotation):
    """Write the axes of the best restart: the least sum of distances to the surface of its box."""
    inside, normal, second = np.empty(points.shape[1], dtype=np.bool_), np.empty(3), np.empty(3)
    tried, center, half = np.empty((3, 3)), np.empty(3), np.empty(3)
    distance, least, flat = np.empty(points.shape[1]), np.inf, False
    for restart in range(len(draws)):
        if axis is None:
            offset = first_plane(points, tolerance, draws[restart, :, :3], inside, normal)
        else:
            normal[:] = axis
            offset = fixed_plane(points, tolerance, draws[restart, :, 0], normal)
        if perpendicular_plane(points, tolerance, normal, offset, draws[restart, :, 3:], inside, second):
            third = crossed(normal, second)
            for k in range(3):
                tried[k, 0], tried[k, 1], tried[k, 2] = normal[k], second[k], third[k]
        elif flat:
            continue  # all restarts that see one flat face have the axes of the first of them
        else:
            flat_frame(points, normal, constants.outlier_share, tried)
            flat = True
        enclose(points, tried, constants.outlier_share, away, center, half)
        surface_distances(points, center, tried, half, distance)
        total = 0.0
        for i in range(points.shape[1]):
            total += distance[i]
        if total < least:
            least = total
            rotation[:] = tried


@njit(error_model="numpy")
def _mean_and_variance(distance):
    mean, variance = 0.0, 0.0
    for i in range(len(distance)):
        mean += distance[i]
    mean /= len(distance)
    for i in range(len(distance)):
        variance += (distance[i] - mean) ** 2
    return mean, variance / len(distance)


@njit(error_model="numpy")
def _visible_share(points, center, origin, rotation, half):
    """As in `visibility.visible_share`; the camera lies at minus the origin of the points (3, n)."""
    seen, shift, local = np.empty(6, dtype=np.bool_), np.zeros(3), np.empty(3)
    for k in range(3):
        ahead = 0.0
        for j in range(3):
            ahead += (center[j] + origin[j]) * rotation[j, k]
            shift[k] += center[j] * rotation[j, k]
        seen[2 * k], seen[2 * k + 1] = ahead + half[k] < 0, -ahead + half[k] < 0
    low, amount = -half, 0
    for i in range(points.shape[1]):
        for k in range(3):
            place = points[0, i] * rotation[0, k] + points[1, i] * rotation[1, k]
            local[k] = place + points[2, i] * rotation[2, k] - shift[k]
        nearest, _ = nearest_face(local[0], local[1], local[2], low, half)
        amount += seen[nearest]
    return amount / points.shape[1]


def _kept_while(fingerprint):
    """The function below; its machine code is made again when the fingerprint is another."""

    @njit(cache=True, error_model="numpy")
    def fitted(points, counts, draws, axes, constants):
        """Fit a box to each of N sets of points (N, P, 3), of which `counts` (N,) count; `axes`: (N, 3) or none."""
        _ = fingerprint
        n = len(points)
        found = Found(
            np.empty((n, 3)), np.empty((n, 3, 3)), np.empty((n, 3)), np.empty(n), np.empty(n), np.empty(n)
        )
        for i in range(n):
            found.mean[i], found.variance[i], found.visible_share[i] = _fit(
                points[i, : counts[i]],
                draws[i],
                None if axes is None else axes[i],
                constants,
                found.center[i],
                found.rotation[i],
                found.half_extent[i],
            )
        return found

    return fitted


fitted = _kept_while(fingerprint_of("boxes"))
