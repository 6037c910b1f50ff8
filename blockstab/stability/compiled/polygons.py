"""Hull and intersection of convex polygons, one at a time, in machine code.

They are `convex_hulls.hull` and `convex_hulls.clip` step by step, and round as those do: what touches exactly must
touch here too. Polygons are arrays (k, 2) of vertices, counter-clockwise, metres; none is empty, one a point, two a
segment.

Here and beside, loops over numbers are spelt out: whole arrays take ten times as long to compile.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from blockstab.geometry.polygons import ROUNDING, SLACK


@njit(error_model="numpy")
def hull(points):
    """Corners (k, 2) of the convex hull of points (n, 2) (Andrew 1979, as in `polygons.corners_of_hulls`)."""
    if len(points) == 0:
        return points
    points, slack = _from_left_to_right(points), SLACK * _reach(points)
    walk, count = _around(points)
    while True:
        amount = _without_left_turns(points, walk, count)
        if amount == count:
            amount = _without_points_between(points, walk, count, slack)
        if amount == count:
            break
        count = amount
    for end in (len(points) - 1, 0):
        count = _without_end(points, walk, count, end, slack)
    corners = np.empty((count, 2))
    for i in range(count):
        corners[i, 0], corners[i, 1] = points[walk[i], 0], points[walk[i], 1]
    return corners


@njit(error_model="numpy")
def clip(subject, clipper):
    """Intersection of two polygons with area (k, 2) (Sutherland and Hodgman 1974, as in `convex_hulls.clip`)."""
    slack = SLACK * max(_reach(subject), _reach(clipper))
    for i in range(len(clipper)):
        j = i + 1 if i + 1 < len(clipper) else 0
        x, y = clipper[j, 0] - clipper[i, 0], clipper[j, 1] - clipper[i, 1]
        squared = x * x + y * y
        length = np.sqrt(squared) if squared > 0 else 1.0
        subject = _cut(subject, clipper[i, 0], clipper[i, 1], -(y / length), x / length, slack)
    return subject


@njit(error_model="numpy")
def _cut(corners, anchor_x, anchor_y, normal_x, normal_y, slack):
    """Clip a polygon to a half-plane."""
    count = len(corners)
    depth = np.empty(count)
    for i in range(count):
        depth[i] = (corners[i, 0] - anchor_x) * normal_x + (corners[i, 1] - anchor_y) * normal_y
        if not abs(depth[i]) > slack:
            depth[i] = 0.0
    left, amount = np.empty((2 * count, 2)), 0
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        if depth[i] >= 0:
            left[amount, 0], left[amount, 1] = corners[i, 0], corners[i, 1]
            amount += 1
        # A walk around the two ends of a segment meets its only edge twice.
        if depth[i] * depth[j] < 0 and (count > 2 or i < count - 1):
            share = depth[i] / (depth[i] - depth[j])
            for k in range(2):
                left[amount, k] = corners[i, k] + share * (corners[j, k] - corners[i, k])
            amount += 1
    return left[:amount]


@njit(error_model="numpy")
def _reach(points):
    """The largest coordinate."""
    reach = 0.0
    for i in range(len(points)):
        reach = max(reach, abs(points[i, 0]), abs(points[i, 1]))
    return reach


@njit(error_model="numpy")
def _from_left_to_right(points):
    """The points in the order of x, then y, each once; there are too few of them for more than an insertion sort."""
    ordered, count = np.empty_like(points), 0
    for i in range(len(points)):
        x, y = points[i, 0], points[i, 1]
        j = count
        while j > 0 and (ordered[j - 1, 0] > x or (ordered[j - 1, 0] == x and ordered[j - 1, 1] > y)):
            j -= 1
        if j > 0 and ordered[j - 1, 0] == x and ordered[j - 1, 1] == y:
            continue
        for k in range(count, j, -1):
            ordered[k, 0], ordered[k, 1] = ordered[k - 1, 0], ordered[k - 1, 1]
        ordered[j, 0], ordered[j, 1] = x, y
        count += 1
    return ordered[:count]


@njit(error_model="numpy")
def _around(points):
    """A walk along the points below the line from the first to the last, and back along those above; its length."""
    n = len(points)
    walk, count = np.empty(2 * n, dtype=np.int64), 0
    for i in range(n):
        if i == 0 or i == n - 1 or _left_of(points, n - 1, 0, i):
            walk[count] = i
            count += 1
    for i in range(n - 1, -1, -1):
        if _left_of(points, 0, n - 1, i):
            walk[count] = i
            count += 1
    return walk, count


@njit(error_model="numpy")
def _without_left_turns(points, walk, count):
    """Drop, all at once, what lies left of the line between its neighbours; the new length."""
    drop = np.zeros(count, dtype=np.bool_)
    for place in range(1, count):
        drop[place] = _left_of(points, walk[place - 1], walk[(place + 1) % count], walk[place])
    return _packed(walk, drop)


@njit(error_model="numpy")
def _without_points_between(points, walk, count, slack):
    """Drop what lies between its neighbours, but no two in a row, nor the last point; the new length."""
    drop, any_odd = np.zeros(count, dtype=np.bool_), False
    for place in range(1, count):
        drop[place] = walk[place] < len(points) - 1 and _between(
            points, walk[place - 1], walk[(place + 1) % count], walk[place], slack
        )
        any_odd = any_odd or (drop[place] and place % 2 == 1)
    if any_odd:
        for place in range(0, count, 2):
            drop[place] = False
    return _packed(walk, drop)


@njit(error_model="numpy")
def _without_end(points, walk, count, end, slack):
    """Drop an end that lies between others, on an upright edge, if what is left is still convex."""
    if count < 2:
        return count
    for at in range(count):
        if walk[at] == end:
            far_before, before = walk[(at - 2) % count], walk[(at - 1) % count]
            after, far_after = walk[(at + 1) % count], walk[(at + 2) % count]
            if (
                _between(points, before, after, end, slack)
                and not _left_of(points, far_before, after, before)
                and not _left_of(points, before, far_after, after)
            ):
                for place in range(at, count - 1):
                    walk[place] = walk[place + 1]
                return count - 1
    return count


@njit(error_model="numpy")
def _packed(walk, drop):
    """Close the gaps that dropped places leave in a walk; its new length."""
    count = 0
    for place in range(len(drop)):
        if not drop[place]:
            walk[count] = walk[place]
            count += 1
    return count


@njit(error_model="numpy")
def _left_of(points, start, end, here):
    """True if a point lies to the left of a directed line, beyond the doubt of rounding (Shewchuk 1997)."""
    right = (points[end, 1] - points[start, 1]) * (points[here, 0] - points[start, 0])
    left = (points[end, 0] - points[start, 0]) * (points[here, 1] - points[start, 1])
    return left - right > ROUNDING * (abs(left) + abs(right))


@njit(error_model="numpy")
def _between(points, start, end, here, slack):
    """True if a point lies on a segment, give or take the slack."""
    line_x, line_y = points[end, 0] - points[start, 0], points[end, 1] - points[start, 1]
    arm_x, arm_y = points[here, 0] - points[start, 0], points[here, 1] - points[start, 1]
    room = slack * (abs(line_x) + abs(line_y))
    ahead = arm_x * (points[end, 0] - points[here, 0]) + arm_y * (points[end, 1] - points[here, 1])
    return abs(line_x * arm_y - line_y * arm_x) <= room and ahead >= -room - slack * slack
