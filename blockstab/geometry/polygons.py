"""Steps on the vertices of many polygons at once: the inside of hulls and clips.

Points are kept as (2, n, B), coordinate, place, polygon: what is done to every polygon runs along memory.
"""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn.functional import pad

SLACK = 1e-13  # of the largest coordinate: rounding moves no point as far, so anything nearer is contact
ROUNDING = 1e-15  # of the two products: more than rounding changes their difference


def corners_of_hulls(points: Tensor) -> tuple[Tensor, Tensor]:
    """Indices (w, B) of the hulls' corners among points (2, n, B), the last repeated; their number (B,)."""
    n, slack = points.shape[1], SLACK * points.abs().amax(dim=(0, 1))
    by_y = points[1].argsort(dim=0)
    order = by_y.gather(0, points[0].gather(0, by_y).argsort(dim=0, stable=True))
    points = pick(points, order)
    # From the leftmost point to the rightmost along the points below their line, and back along those above.
    first, last = points[:, :1], points[:, -1:]
    # A repeated point counts once, or what is nearly equal would be kept or dropped by how often another is repeated.
    fresh = pad((points[:, 1:] != points[:, :-1]).any(dim=0), (0, 0, 1, 0), value=True)
    below, above = fresh & _left_of(last, first, points), fresh & _left_of(first, last, points)
    below[0] = below[-1] = True
    index, count = _packed(torch.cat([below, above.flip(0)]))
    walk = torch.minimum(index, 2 * n - 1 - index)
    points = pick(points, walk)
    while True:
        place = torch.arange(1, len(walk) - 1, device=walk.device)[:, None]
        before, here, after = points[:, :-2], points[:, 1:-1], points[:, 2:]
        drop = (place < count) & _left_of(before, after, here)
        if not bool(drop.any()):
            # Points that nearly coincide are between others because of each other: drop no two neighbours,
            # nor the two ends, without which the walk may turn over.
            between = (place < count) & (walk[1:-1] < n - 1) & _between(before, after, here, slack)
            odd = between & (place % 2 == 1)
            drop = torch.where(odd.any(dim=0), odd, between)
        if not bool(drop.any()):
            break
        index, count = _packed(pad((place < count) & ~drop, (0, 0, 1, 0), value=True))
        walk, points = walk.gather(0, index), pick(points, index)
    for end in (n - 1, 0):
        walk, points, count = _without_end(end, walk, points, count, slack)
    place = torch.arange(len(walk) - 1, device=walk.device)[:, None]
    return order.gather(0, walk.gather(0, place.minimum(count - 1))), count


def _without_end(
    end: int, walk: Tensor, points: Tensor, count: Tensor, slack: Tensor
) -> tuple[Tensor, Tensor, Tensor]:
    """Drop an end that lies between others, on an upright edge, if what is left is still convex."""
    inner = torch.arange(len(walk), device=walk.device)[:, None] < count
    at = (walk == end) & inner
    around = at.long().argmax(dim=0) + torch.arange(-2, 3, device=walk.device)[:, None]
    far_before, before, here, after, far_after = pick(points, around % count).unbind(1)
    spare = (count > 1) & _between(before, after, here, slack)
    spare &= ~_left_of(far_before, after, before) & ~_left_of(before, far_after, after)
    index, count = _packed(inner & ~(at & spare))
    return walk.gather(0, index), pick(points, index), count


def _left_of(start: Tensor, end: Tensor, points: Tensor) -> Tensor:
    """Mask of points to the left of a directed line, beyond the doubt of rounding (Shewchuk 1997)."""
    line, arm = end - start, points - start
    right, left = line[1] * arm[0], line[0] * arm[1]
    return left - right > ROUNDING * (left.abs() + right.abs())


def _between(start: Tensor, end: Tensor, points: Tensor, slack: Tensor) -> Tensor:
    """Mask of points on a segment, give or take the slack."""
    line, arm = end - start, points - start
    room = slack * line.abs().sum(dim=0)
    return (cross(line, arm).abs() <= room) & ((arm * (end - points)).sum(dim=0) >= -room - slack.square())


def cut(
    corners: Tensor, count: Tensor, anchor: Tensor, normal: Tensor, slack: Tensor
) -> tuple[Tensor, Tensor]:
    """Clip polygons (2, V, B) to a half-plane."""
    place = torch.arange(corners.shape[1], device=corners.device)[:, None]
    depth = ((corners - anchor[:, None]) * normal[:, None]).sum(dim=0)
    depth = depth * (depth.abs() > slack)
    after = depth.roll(-1, dims=0)
    # A walk around the two ends of a segment meets its only edge twice.
    crossed = (depth * after < 0) & ((count > 2) | (place < count - 1))
    share = depth / torch.where(crossed, depth - after, 1.0)
    crossing = corners + share * (corners.roll(-1, dims=1) - corners)
    kept = (depth >= 0) & (place < count)
    index, count = _packed(torch.stack([kept, crossed], dim=1).flatten(0, 1))
    place = torch.arange(len(index) - 1, device=index.device)[:, None]
    index = index.gather(0, place.minimum((count - 1).clamp(min=0)))
    return pick(torch.stack([corners, crossing], dim=2).flatten(1, 2), index), count


def _packed(flags: Tensor) -> tuple[Tensor, Tensor]:
    """Indices of the true flags of (n, B), in order, then one zero or more; and their number (B,)."""
    count = flags.sum(dim=0)
    width = int(torch.cat([count, count.new_ones(1)]).max())
    place = torch.arange(flags.shape[0], device=flags.device)[:, None]
    target = flags.cumsum(dim=0) * flags
    return target.new_zeros(width + 2, flags.shape[1]).scatter(0, target, place.expand_as(target))[1:], count


def planar(vertices: Tensor) -> Tensor:
    """(B, V, 2) as (2, V, B): with the batch last, every step below is a sweep over contiguous numbers."""
    return vertices.permute(2, 1, 0).contiguous()


def summed(values: Tensor) -> Tensor:
    """Sums of (..., V, B) over V, term by term: `sum` rounds by the shape, and padding must not settle ties."""
    return pad(values, (0, 0, 1, 0)).cumsum(dim=-2)[..., -1, :]


def pick(points: Tensor, index: Tensor) -> Tensor:
    """Points (2, n, B) at places (w, B): (2, w, B)."""
    return points.gather(1, index.expand(2, -1, -1))


def cross(a: Tensor, b: Tensor) -> Tensor:
    """The cross products of (2, ...) and (2, ...), (...)."""
    return a[0] * b[1] - a[1] * b[0]
