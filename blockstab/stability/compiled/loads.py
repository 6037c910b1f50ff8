"""Loads of boxes: what rests on what, in machine code; see `stability.loads`.

Relations are followed along linked lists: `head[b]` is a relation of box b, `following[e]` the next one of the same
box after e; -1 ends a list.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from blockstab.stability.support import GROUND, SupportType

_GROUND, _SIDE = GROUND, int(SupportType.SIDE)


@njit(error_model="numpy")
def linked(owner, n):
    """Lists of the relations of each of n boxes; relation e is of the box `owner[e]`."""
    head, following = np.full(n, -1), np.empty(len(owner), dtype=np.int64)
    for e in range(len(owner)):
        following[e] = head[owner[e]]
        head[owner[e]] = e
    return head, following


@njit(error_model="numpy")
def rests_on(upper, lower, below, head, following):
    """True if a box rests, through however many others, on another.

    Args:
        below: the lower box of each relation; head, following: lists of the relations by their upper box.
    """
    reached = _reached(upper, below, head, following)
    for b in reached:  # noqa: SIM110  (a generator is compiled to a loop many times as long)
        if b == lower:
            return True
    return False


@njit(error_model="numpy")
def is_resting(relations, e):
    """True if a relation is that of one box on top of another."""
    return relations.supporter[e] != _GROUND and relations.type[e] != _SIDE


@njit(error_model="numpy")
def levels(relations, n):
    """(n,) how many layers of boxes lie on each box."""
    level, raised = np.zeros(n, dtype=np.int64), True
    while raised:
        raised = False
        for e in range(len(relations.type)):
            if is_resting(relations, e):
                below, above = relations.supporter[e], relations.supported[e]
                if level[below] <= level[above]:
                    level[below], raised = level[above] + 1, True
    return level


@njit(error_model="numpy")
def by_supported(relations, n):
    """The relations of each of n boxes in their order, box after box, and where those of each begin (n + 1,)."""
    start = np.zeros(n + 1, dtype=np.int64)
    for b in relations.supported:
        start[b + 1] += 1
    for b in range(n):
        start[b + 1] += start[b]
    own, place = np.empty(len(relations.supported), dtype=np.int64), start.copy()
    for e in range(len(own)):
        b = relations.supported[e]
        own[place[b]] = e
        place[b] += 1
    return own, start


@njit(error_model="numpy")
def mass_center(bodies, box, above, head, following):
    """Eq. 1: the centre of mass (3,) of a box and all that rests on it, added as in `balance.mass_centers`.

    Args:
        above: the upper box of each relation; head, following: lists of the relations by their lower box.
    """
    load = _reached(box, above, head, following)
    center, mass = np.zeros(3), 0.0
    for b in load:
        half = bodies.half_extent[b]
        volume = 8.0 * (half[0] * half[1] * half[2])
        mass += volume
        for k in range(3):
            center[k] += volume * bodies.center[b, k]
    for k in range(3):
        center[k] /= mass
    return center


@njit(error_model="numpy")
def _reached(box, other, head, following):
    """A box and all that relations lead to from it, however many in a row, in the order of the boxes.

    Args:
        other: the box at the far end of each relation; head, following: lists of the relations by their near box.
    """
    n = len(head)
    seen, found, count, done = np.zeros(n, dtype=np.bool_), np.empty(n, dtype=np.int64), 1, 0
    found[0], seen[box] = box, True
    while done < count:
        e = head[found[done]]
        done += 1
        while e >= 0:
            if not seen[other[e]]:
                found[count], seen[other[e]] = other[e], True
                count += 1
            e = following[e]
    return _ascending(found[:count])


@njit(error_model="numpy")
def _ascending(numbers):
    """Sort few numbers in place."""
    for i in range(1, len(numbers)):
        number, j = numbers[i], i
        while j > 0 and numbers[j - 1] > number:
            numbers[j] = numbers[j - 1]
            j -= 1
        numbers[j] = number
    return numbers
