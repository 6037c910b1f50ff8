"""Boxes and pairs of them as arrays, and what the rules need to know of each box, in machine code."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from torch import Tensor


class Given(NamedTuple):
    """N boxes, as they come."""

    center: np.ndarray  # (N, 3) metres
    rotation: np.ndarray  # (N, 3, 3), columns are axes
    half_extent: np.ndarray  # (N, 3) metres
    ground_height: np.ndarray  # (N,) metres
    movable: np.ndarray  # (N,) bool
    is_ground: np.ndarray  # (N,) bool


class Bodies(NamedTuple):
    """N boxes, as a verdict needs to know them."""

    center: np.ndarray  # (N, 3) metres
    half_extent: np.ndarray  # (N, 3) metres
    slack: np.ndarray  # (N,) metres
    movable: np.ndarray  # (N,) bool


class Relations(NamedTuple):
    """E support relations, as in `support.Supports`; unused places of an area repeat its last vertex."""

    supporter: np.ndarray  # (E,)
    supported: np.ndarray  # (E,)
    type: np.ndarray  # (E,)
    vertices: np.ndarray  # (E, V, 2) metres
    amount: np.ndarray  # (E,) vertices of each area


class Things(NamedTuple):
    """N boxes and their measures."""

    given: Given
    corners: np.ndarray  # (N, 8, 3) metres
    top: np.ndarray  # (N, 3) the axis nearest to the vertical, pointing up
    tilt: np.ndarray  # (N,) its angle to the vertical, radians
    touch: np.ndarray  # (N,) metres within which other things touch it


class Pairs(NamedTuple):
    """P pairs of boxes, and how far apart they are."""

    first: np.ndarray  # (P,) indices
    second: np.ndarray  # (P,)
    gap: np.ndarray  # (P,) metres
    direction: np.ndarray  # (P, 3) unit vectors


class Limits(NamedTuple):
    """`SupportRules`, the angle in radians."""

    angle: float
    touch_m: float
    touch_per_square_m: float


def arrays(*tensors: Tensor) -> list[np.ndarray]:
    """Tensors as machine code takes them: it is made for one layout in memory."""
    return [tensor.detach().contiguous().numpy() for tensor in tensors]


@njit(error_model="numpy")
def measured(given, limits):
    """Measure boxes as `Boxes.corners`, `top_normal`, `tilt` and `SupportRules.touch` do."""
    n = len(given.center)
    things = Things(given, np.empty((n, 8, 3)), np.empty((n, 3)), np.empty(n), np.empty(n))
    for b in range(n):
        center, half = given.center[b], given.half_extent[b]
        for c in range(8):
            _corner(c, center, given.rotation[b], half, things.corners[b, c])
        axis = 0
        for k in range(1, 3):
            if abs(given.rotation[b, 1, k]) > abs(given.rotation[b, 1, axis]):
                axis = k
        sign = -1.0 if given.rotation[b, 1, axis] < 0 else 1.0
        for k in range(3):
            things.top[b, k] = given.rotation[b, k, axis] * sign
        things.tilt[b] = np.arccos(min(abs(things.top[b, 1]), 1.0))
        away = center[0] * center[0] + center[1] * center[1] + center[2] * center[2]
        things.touch[b] = max(limits.touch_per_square_m * away, limits.touch_m)
    return things


@njit(error_model="numpy")
def _corner(c, center, rotation, half_extent, corner):
    """Write corner c, whose bits are its signs, the first axis first."""
    for k in range(3):
        reach = 0.0
        for axis in range(3):
            sign = 1.0 if (c >> (2 - axis)) & 1 else -1.0
            reach += sign * half_extent[axis] * rotation[k, axis]
        corner[k] = center[k] + reach
