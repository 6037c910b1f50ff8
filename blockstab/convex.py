"""Convex polygons in the plane, in batches: hull, clip, area, centroid, signed distance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn.functional import pad

_SLACK = 1e-13  # of the largest coordinate: rounding moves no point as far, so anything nearer is contact
_ROUNDING = 1e-15  # of the two products: more than rounding changes their difference


@dataclass(frozen=True)
class Polygons:
    """B convex polygons, each with up to V vertices.

    Args:
        vertices: (B, V, 2) metres, counter-clockwise. Rows past `count` repeat the last true vertex
            (zero where there is none).
        count: (B,) int64 true vertices of each: 0 is empty, 1 a point, 2 a segment (both of area zero).
    """

    vertices: Tensor
    count: Tensor

    def __len__(self) -> int:
        return self.count.shape[0]

    def __getitem__(self, index: Tensor) -> Polygons:
        return Polygons(self.vertices[index], self.count[index])


def concatenate(parts: Sequence[Polygons]) -> Polygons:
    """One batch from several, in order."""
    width = max(part.vertices.shape[1] for part in parts)
    # Polygons with fewer places repeat their last vertex, as all padding does.
    vertices = [
        torch.cat([p.vertices, p.vertices[:, -1:].expand(-1, width - p.vertices.shape[1], -1)], dim=1)
        for p in parts
    ]
    return Polygons(torch.cat(vertices), torch.cat([part.count for part in parts]))


def segments(ends: Tensor) -> Polygons:
    """Polygons that are line segments, from their two ends (B, 2, 2); points where the ends coincide."""
    same = (ends[:, 0] == ends[:, 1]).all(dim=1)
    return Polygons(ends, torch.where(same, 1, 2))


def hull(points: Tensor, present: Tensor | None = None) -> Polygons:
    """Convex hulls of B sets of points, all in step; differentiable.

    As in the monotone chain of Andrew (1979), points are walked from left to right and back, and those that
    make no left turn are dropped; a round drops all of them at once. Vertices are points of the input to the
    bit, without repeats and without points between two others. Whatever is nearer than 1e-13 of the set's
    largest coordinate counts as equal.

    Args:
        points: (B, n, 2) metres.
        present: (B, n) bool, which points belong to their set; all where None.

    Raises:
        ValueError: on points or flags of another shape.
    """
    if points.ndim != 3 or points.shape[2] != 2:
        raise ValueError(f"Points must have the shape (sets, points, 2), but got {tuple(points.shape)}.")
    if present is None:
        present = points.new_ones(points.shape[:2], dtype=torch.bool)
    if present.shape != points.shape[:2]:
        raise ValueError(
            f"Points of shape {tuple(points.shape)} need flags of shape {tuple(points.shape[:2])}, "
            f"but `present` has {tuple(present.shape)}."
        )
    if present.numel() == 0:
        return Polygons(points.new_zeros(len(points), 1, 2), present.sum(dim=1))
    # A point that is absent stands in for one that is there: repeating a point changes no hull.
    stand_in = present.long().argmax(dim=1, keepdim=True)
    source = torch.where(present, torch.arange(points.shape[1], device=points.device), stand_in).T
    corner, count = _corners(_pick(_planar(points.detach()), source))
    return _polygons(_pick(_planar(points), source.gather(0, corner)), count * present.any(dim=1))


def clip(subject: Polygons, clipper: Polygons) -> Polygons:
    """Intersections of B pairs of convex polygons (Sutherland and Hodgman 1974); differentiable.

    Convention:
        Polygons contain their border: two that touch along an edge share that segment (count 2, area 0),
        two that touch at a corner share that point (count 1). Whatever is nearer than 1e-13 of the largest
        coordinate touches. Points and segments are clipped, and clip, like any other polygon.

    Raises:
        ValueError: the batches differ in length.
    """
    if len(subject) != len(clipper):
        raise ValueError(
            f"Every subject needs a clipper, but {len(subject)} subjects came with {len(clipper)} clippers."
        )
    reach = torch.cat([subject.vertices, clipper.vertices], dim=1).detach().abs().amax(dim=(1, 2))
    corners, count = _planar(subject.vertices), subject.count * (clipper.count > 0)
    anchors, normals = _half_planes(clipper)
    for anchor, normal in zip(anchors.unbind(1), normals.unbind(1), strict=True):
        corners, count = _cut(corners, count, anchor, normal, _SLACK * reach)
    return _polygons(corners, count)


def area(polygons: Polygons) -> Tensor:
    """Areas, (B,) square metres; differentiable."""
    arms = _arms(polygons)
    return 0.5 * _total(_cross(arms[:, :-1], arms[:, 1:]))


def centroid(polygons: Polygons) -> Tensor:
    """Centres of area, (B, 2) metres: of a segment its middle, of a point itself, NaN where empty."""
    arms = _arms(polygons)
    weight = _cross(arms[:, :-1], arms[:, 1:])
    solid = polygons.count > 2
    total = torch.where(solid, _total(weight), 1.0)
    middle = _total((arms[:, :-1] + arms[:, 1:]) * weight) / (3.0 * total)
    center = polygons.vertices[:, 0] + torch.where(solid, middle, 0.5 * arms[:, -1]).T
    return torch.where(polygons.count[:, None] > 0, center, torch.nan)


def signed_distance(polygons: Polygons, points: Tensor) -> Tensor:
    """Distances from points (B, 2) to the border of their polygon, (B,) metres; differentiable.

    Convention:
        Positive inside, negative outside, zero on the border. Points and segments have no inside:
        minus the distance to them. NaN where the polygon is empty.
    """
    start = _planar(polygons.vertices)
    edge = start.roll(-1, dims=1) - start
    arm = points.T[:, None] - start
    squared = edge.square().sum(dim=0)
    proper = squared > 0
    squared = torch.where(proper, squared, 1.0)
    depth = torch.where(proper, _cross(edge, arm) / squared.sqrt(), torch.inf).amin(dim=0)
    share = ((arm * edge).sum(dim=0) / squared).clamp(0.0, 1.0)
    distance = (arm - share * edge).square().sum(dim=0).amin(dim=0)
    # The root has no finite slope at zero, which is the border itself.
    distance = torch.where(distance > 0, torch.where(distance > 0, distance, 1.0).sqrt(), 0.0)
    inside = (polygons.count > 2) & (depth >= 0)
    return torch.where(polygons.count > 0, torch.where(inside, depth, -distance), torch.nan)


def _corners(points: Tensor) -> tuple[Tensor, Tensor]:
    """Indices (w, B) of the hulls' corners among points (2, n, B), the last repeated; their number (B,)."""
    n, slack = points.shape[1], _SLACK * points.abs().amax(dim=(0, 1))
    by_y = points[1].argsort(dim=0)
    order = by_y.gather(0, points[0].gather(0, by_y).argsort(dim=0, stable=True))
    points = _pick(points, order)
    # From the leftmost point to the rightmost along the points below their line, and back along those above.
    first, last = points[:, :1], points[:, -1:]
    below, above = _left_of(last, first, points), _left_of(first, last, points)
    below[0] = below[-1] = True
    index, count = _packed(torch.cat([below, above.flip(0)]))
    walk = torch.minimum(index, 2 * n - 1 - index)
    points = _pick(points, walk)
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
        walk, points = walk.gather(0, index), _pick(points, index)
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
    far_before, before, here, after, far_after = _pick(points, around % count).unbind(1)
    spare = (count > 1) & _between(before, after, here, slack)
    spare &= ~_left_of(far_before, after, before) & ~_left_of(before, far_after, after)
    index, count = _packed(inner & ~(at & spare))
    return walk.gather(0, index), _pick(points, index), count


def _left_of(start: Tensor, end: Tensor, points: Tensor) -> Tensor:
    """Whether points lie to the left of a directed line, beyond the doubt of rounding (Shewchuk 1997)."""
    line, arm = end - start, points - start
    right, left = line[1] * arm[0], line[0] * arm[1]
    return left - right > _ROUNDING * (left.abs() + right.abs())


def _between(start: Tensor, end: Tensor, points: Tensor, slack: Tensor) -> Tensor:
    """Whether points lie on a segment, give or take the slack."""
    line, arm = end - start, points - start
    room = slack * line.abs().sum(dim=0)
    return (_cross(line, arm).abs() <= room) & ((arm * (end - points)).sum(dim=0) >= -room - slack.square())


def _half_planes(polygons: Polygons) -> tuple[Tensor, Tensor]:
    """A point on the border of every half-plane that bounds a polygon, and its inward unit normal, (2, E, B).

    A segment is bounded by its line from either side and by a line across either end; a point likewise.
    A normal of zero bounds nothing.
    """
    anchor = _planar(polygons.vertices)
    edge = anchor.roll(-1, dims=1) - anchor
    squared = edge.square().sum(dim=0)
    edge = edge / torch.where(squared > 0, squared, 1.0).sqrt()
    start, end = anchor[:, 0], anchor[:, -1]
    ahead = torch.where(polygons.count > 1, edge[:, 0], edge.new_tensor([[1.0], [0.0]]))
    left = torch.stack([-ahead[1], ahead[0]])

    spare = (0, 0, 0, max(0, 4 - anchor.shape[1]))
    edge, anchor = pad(edge, spare), pad(anchor, spare)
    flat = polygons.count < 3
    around = torch.where(flat, torch.stack([ahead, left, -ahead, -left], dim=1), edge[:, :4])
    corner = torch.where(flat, torch.stack([start, end, end, start], dim=1), anchor[:, :4])
    edge = torch.cat([around, edge[:, 4:]], dim=1)
    return torch.cat([corner, anchor[:, 4:]], dim=1), torch.stack([-edge[1], edge[0]])


def _cut(
    corners: Tensor, count: Tensor, anchor: Tensor, normal: Tensor, slack: Tensor
) -> tuple[Tensor, Tensor]:
    """What a half-plane leaves of polygons (2, V, B)."""
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
    return _pick(torch.stack([corners, crossing], dim=2).flatten(1, 2), index), count


def _packed(flags: Tensor) -> tuple[Tensor, Tensor]:
    """Indices of the true flags of (n, B), in order, then one zero or more; and their number (B,)."""
    count = flags.sum(dim=0)
    width = int(torch.cat([count, count.new_ones(1)]).max())
    place = torch.arange(flags.shape[0], device=flags.device)[:, None]
    target = flags.cumsum(dim=0) * flags
    return target.new_zeros(width + 2, flags.shape[1]).scatter(0, target, place.expand_as(target))[1:], count


def _planar(vertices: Tensor) -> Tensor:
    """(B, V, 2) as (2, V, B): with the batch last, every step below is a sweep over contiguous numbers."""
    return vertices.permute(2, 1, 0).contiguous()


def _polygons(corners: Tensor, count: Tensor) -> Polygons:
    return Polygons(torch.where(count > 0, corners, 0.0).permute(2, 1, 0).contiguous(), count)


def _arms(polygons: Polygons) -> Tensor:
    """From the first vertex to every vertex, (2, V, B)."""
    return _planar(polygons.vertices - polygons.vertices[:, :1])


def _total(values: Tensor) -> Tensor:
    """Sums of (..., V, B) over V, term by term: `sum` rounds by the shape, and padding must not change a bit."""
    return pad(values, (0, 0, 1, 0)).cumsum(dim=-2)[..., -1, :]


def _pick(points: Tensor, index: Tensor) -> Tensor:
    return points.gather(1, index.expand(2, -1, -1))


def _cross(a: Tensor, b: Tensor) -> Tensor:
    return a[0] * b[1] - a[1] * b[0]
