"""Candidate support relations, in machine code: `support.candidate_supports` box by box, pair by pair."""

from __future__ import annotations

import numpy as np
from numba import njit

from blockstab.stability.compiled.areas import bottom, footprint, lowest_corners, touching_edge
from blockstab.stability.compiled.loads import linked, rests_on
from blockstab.stability.compiled.polygons import clip
from blockstab.stability.compiled.things import Relations
from blockstab.stability.support import GROUND, SupportType

# Corners of a footprint, and two more for each edge that a clip cuts it with: rounding makes no more.
_WIDTH = 24
_SURFACE, _PARTIAL, _SIDE = (int(kind) for kind in SupportType)
_GROUND = GROUND


@njit(error_model="numpy")
def candidate_relations(things, pairs, limits):
    """All relations that nearness allows: those with the ground, then on-top, then side relations."""
    lower, upper, first, second = _near(things, pairs, limits)
    n, room = len(things.touch), len(things.touch) + len(lower) + 2 * len(first)
    found = Relations(
        np.empty(room, dtype=np.int64),
        np.empty(room, dtype=np.int64),
        np.empty(room, dtype=np.int64),
        np.empty((room, _WIDTH, 2)),
        np.empty(room, dtype=np.int64),
    )
    shadows, corners = np.empty((n, 8, 2)), np.empty(n, dtype=np.int64)
    for b in range(n):
        shadow = footprint(things.corners[b])
        corners[b] = len(shadow)
        for i in range(corners[b]):
            shadows[b, i, 0], shadows[b, i, 1] = shadow[i, 0], shadow[i, 1]
    on_floor = _add_on_floor(found, things, shadows, corners, limits)
    on_top = _add_on_top(found, on_floor, things, lower, upper, shadows, corners, limits)
    total = _add_aside(found, on_floor, on_top, things, first, second)
    width = 1
    for e in range(total):
        width = max(width, found.amount[e])
    vertices = np.empty((total, width, 2))
    for e in range(total):
        for i in range(width):
            vertices[e, i, 0], vertices[e, i, 1] = found.vertices[e, i, 0], found.vertices[e, i, 1]
    return Relations(
        found.supporter[:total], found.supported[:total], found.type[:total], vertices, found.amount[:total]
    )


@njit(error_model="numpy")
def _near(things, pairs, limits):
    """Pairs that touch: the lower and the upper box of those above each other, both boxes of the others."""
    steep, total = np.cos(limits.angle), len(pairs.first)
    lower, upper, above = np.empty(total, dtype=np.int64), np.empty(total, dtype=np.int64), 0
    first, second, aside = np.empty(total, dtype=np.int64), np.empty(total, dtype=np.int64), 0
    for p in range(total):
        a, b = pairs.first[p], pairs.second[p]
        if (
            not pairs.gap[p] < max(things.touch[a], things.touch[b])
            or things.given.is_ground[a]
            or things.given.is_ground[b]
        ):
            continue
        if abs(pairs.direction[p, 1]) > steep:
            higher = things.given.center[b, 1] >= things.given.center[a, 1]
            lower[above], upper[above] = (a, b) if higher else (b, a)
            above += 1
        else:
            first[aside], second[aside] = a, b
            aside += 1
    return lower[:above], upper[:above], first[:aside], second[:aside]


@njit(error_model="numpy")
def _add_on_floor(found, things, shadows, corners, limits):
    """Write the relations with the ground, boxes that stand flat first; how many there are."""
    total = 0
    for flat in (True, False):
        for b in range(len(things.touch)):
            near = bottom(things.corners[b]) < things.given.ground_height[b] + things.touch[b]
            if near and things.given.movable[b] and (things.tilt[b] < limits.angle) == flat:
                if flat:
                    total = _add(found, total, _GROUND, b, _SURFACE, shadows[b][: corners[b]])
                else:
                    area = lowest_corners(things.corners[b], things.touch[b])
                    total = _add(found, total, _GROUND, b, _PARTIAL, area)
    return total


@njit(error_model="numpy")
def _add_on_top(found, total, things, lower, upper, shadows, corners, limits):
    """Write the on-top relations between boxes, surface before partial; how many relations there are now."""
    for tilted in (False, True):
        for p in range(len(lower)):
            below, above = lower[p], upper[p]
            if things.given.movable[above] and _is_partial(things, below, above, limits) == tilted:
                if tilted:
                    area = _touching(things, below, above)
                    total = _add(found, total, below, above, _PARTIAL, area)
                else:
                    area = clip(shadows[below][: corners[below]], shadows[above][: corners[above]])
                    total = _add(found, total, below, above, _SURFACE, area)
    return total


@njit(error_model="numpy")
def _add_aside(found, on_floor, on_top, things, first, second):
    """Write the side relations, except from a box to what it rests on; how many relations there are now."""
    upper, lower = found.supported[on_floor:on_top], found.supporter[on_floor:on_top]
    head, following = linked(upper, len(things.touch))
    total = on_top
    for turned in (False, True):
        for p in range(len(first)):
            aside, beside = (second[p], first[p]) if turned else (first[p], second[p])
            if things.given.movable[beside] and not rests_on(aside, beside, lower, head, following):
                total = _add(found, total, aside, beside, _SIDE, _touching(things, aside, beside))
    return total


@njit(error_model="numpy")
def _is_partial(things, below, above, limits):
    """True if a box meets another with an edge rather than with a face."""
    cosine = 0.0
    for k in range(3):
        cosine += things.top[below, k] * things.top[above, k]
    turned = np.arccos(min(max(cosine, -1.0), 1.0)) > limits.angle
    return turned and abs(things.tilt[below] - things.tilt[above]) > limits.angle


@njit(error_model="numpy")
def _touching(things, supporter, supported):
    return touching_edge(
        things.corners[supported],
        things.given.center[supporter],
        things.given.rotation[supporter],
        things.given.half_extent[supporter],
    )


@njit(error_model="numpy")
def _add(found, total, supporter, supported, kind, area):
    """Write one relation in place `total`, if it has an area; how many there are then."""
    count = min(len(area), _WIDTH)
    if count == 0:
        return total
    found.supporter[total], found.supported[total], found.type[total] = supporter, supported, kind
    found.amount[total] = count
    for i in range(found.vertices.shape[1]):
        last = min(i, count - 1)
        found.vertices[total, i, 0], found.vertices[total, i, 1] = area[last, 0], area[last, 1]
    return total + 1
