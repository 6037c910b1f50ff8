"""Balance of boxes on what holds them, in machine code; see `stability.balance`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from blockstab.stability.compiled.loads import by_supported, is_resting, mass_center
from blockstab.stability.compiled.measures import centroid, margin
from blockstab.stability.compiled.polygons import hull


class Verdicts(NamedTuple):
    """Stability verdicts of N boxes, as in `balance.Balance`."""

    stable: np.ndarray  # (N,) bool
    stable_alone: np.ndarray  # (N,) bool
    margin: np.ndarray  # (N,) metres
    mass_center: np.ndarray  # (N, 3) metres
    support_center: np.ndarray  # (N, 2) metres


@njit(error_model="numpy")
def balanced(bodies, relations, kept):
    """Judge each box, with all that rests on it, over the hull of its supporting areas that are kept (E,)."""
    n, center, slack = len(bodies.center), bodies.center, bodies.slack
    found = Verdicts(
        np.ones(n, dtype=np.bool_),
        np.ones(n, dtype=np.bool_),
        np.full(n, np.inf),
        np.empty((n, 3)),
        np.empty((n, 2)),
    )
    own, start = by_supported(relations, n)
    head, following = np.full(n, -1), np.empty(len(kept), dtype=np.int64)
    for e in range(len(kept)):
        if kept[e] and is_resting(relations, e):
            below = relations.supporter[e]
            following[e], head[below] = head[below], e
    for b in range(n):
        held = held_by(relations, _those(own[start[b] : start[b + 1]], kept))
        mass = mass_center(bodies, b, relations.supported, head, following)
        for k in range(3):
            found.mass_center[b, k] = mass[k]
        found.support_center[b, 0], found.support_center[b, 1] = centroid(held)
        if bodies.movable[b]:
            found.margin[b] = margin(held, mass[0], mass[2])
            found.stable[b] = found.margin[b] >= -slack[b]
            found.stable_alone[b] = margin(held, center[b, 0], center[b, 2]) >= -slack[b]
    return found


@njit(error_model="numpy")
def held_by(relations, chosen):
    """The hull (k, 2) of the areas of some relations (see `balance.combined`)."""
    total = 0
    for e in chosen:
        total += relations.amount[e]
    points, place = np.empty((total, 2)), 0
    for e in chosen:
        for i in range(relations.amount[e]):
            points[place, 0], points[place, 1] = relations.vertices[e, i, 0], relations.vertices[e, i, 1]
            place += 1
    return hull(points)


@njit(error_model="numpy")
def _those(own, kept):
    """The relations among `own` that are kept."""
    chosen, count = np.empty_like(own), 0
    for e in own:
        if kept[e]:
            chosen[count] = e
            count += 1
    return chosen[:count]
