"""The supports that stability needs, in machine code; see `stability.trimming`."""

from __future__ import annotations

import numpy as np
from numba import njit

from blockstab.stability.compiled.balance import held_by
from blockstab.stability.compiled.loads import by_supported, is_resting, levels, mass_center
from blockstab.stability.compiled.measures import area, centroid, margin
from blockstab.stability.support import SupportType
from blockstab.stability.trimming import MAX_SIDES, SIDE_SLOTS, TOP_SLOTS, combinations_of

_SURFACE, _SIDE = int(SupportType.SURFACE), int(SupportType.SIDE)
_TOP_SLOTS, _PLACES = TOP_SLOTS, TOP_SLOTS + SIDE_SLOTS
# Every combination of places, the smallest first, filled up with -1.
_COMBINATIONS = np.array(
    [
        row + [-1] * (TOP_SLOTS + MAX_SIDES - len(row))
        for size in range(1, TOP_SLOTS + MAX_SIDES + 1)
        for row in combinations_of(size).tolist()
    ]
)
_SIZES = (_COMBINATIONS >= 0).sum(axis=1)


@njit(error_model="numpy")
def needed(bodies, relations):
    """(E,) which relations stability needs, judged from the top down."""
    n, total = len(bodies.center), len(relations.type)
    kept, level = np.zeros(total, dtype=np.bool_), levels(relations, n)
    own, start = by_supported(relations, n)
    head, following = np.full(n, -1), np.empty(total, dtype=np.int64)
    height, judged = 0, 0
    while judged < n:
        for b in range(n):
            if level[b] == height:
                judged += 1
                center = mass_center(bodies, b, relations.supported, head, following)
                mine = own[start[b] : start[b + 1]]
                for e in _needed_by_one(relations, mine, center[0], center[2], -bodies.slack[b]):
                    kept[e] = True
                    if is_resting(relations, e):
                        below = relations.supporter[e]
                        following[e], head[below] = head[below], e
        height += 1
    return kept


@njit(error_model="numpy")
def _needed_by_one(relations, own, x, z, least_margin):
    """Those of the relations `own` of one box that it needs, its mass at x, z."""
    surface, count = np.empty_like(own), 0
    for e in own:
        if relations.type[e] == _SURFACE:
            surface[count] = e
            count += 1
    surface = surface[:count]
    if margin(held_by(relations, surface), x, z) >= least_margin:
        return surface
    # What all together cannot hold shall not stand on one edge alone, which reaches further than a hull with area.
    if margin(held_by(relations, own), x, z) >= least_margin:
        return _smallest_combination(relations, own, x, z, least_margin)
    return own


@njit(error_model="numpy")
def _smallest_combination(relations, own, x, z, least_margin):
    """The smallest stable combination; of several the most central, then the largest. All where none is stable."""
    place = _by_importance(relations, own)
    best, size, least, largest = own, _PLACES, np.inf, 0.0
    for row in range(len(_SIZES)):
        if _SIZES[row] > size:
            break
        chosen = _at(place, row)
        if len(chosen) < _SIZES[row]:
            continue
        held = held_by(relations, chosen)
        if not margin(held, x, z) >= least_margin:
            continue
        middle_x, middle_z = centroid(held)
        off_center = np.rint(np.sqrt((middle_x - x) ** 2 + (middle_z - z) ** 2) * 1e9) / 1e9
        if off_center < least or (off_center == least and area(held) > largest):
            best, size, least, largest = chosen, _SIZES[row], off_center, area(held)
    return best


@njit(error_model="numpy")
def _by_importance(relations, own):
    """(8,) the first on-top relations of one box, then its first side relations; -1 for none."""
    place, top, side = np.full(_PLACES, -1), 0, _TOP_SLOTS
    for e in own:
        if relations.type[e] == _SIDE:
            if side < _PLACES:
                place[side] = e
                side += 1
        elif top < _TOP_SLOTS:
            place[top] = e
            top += 1
    return place


@njit(error_model="numpy")
def _at(place, row):
    """The relations at the places of one combination, fewer where a place is empty."""
    chosen, count = np.empty(_SIZES[row], dtype=np.int64), 0
    for k in range(_SIZES[row]):
        e = place[_COMBINATIONS[row, k]]
        if e >= 0:
            chosen[count] = e
            count += 1
    return chosen[:count]
