"""Convex polygons in the plane, in batches: hull, clip, area, centroid, signed distance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn.functional import pad

_SLACK = 1e-13  # of the largest coordinate: more than rounding moves a point, so anything closer is contact


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


def hull(points: Tensor, present: Tensor | None = None) -> Polygons:
    """Convex hulls of B sets of points: a lower and an upper chain each (Andrew 1979), all sets in step.

    Vertices are points of the input to the bit, and differentiable. Repeated points and points on the line
    between two others are no vertices; whatever is nearer than 1e-13 of the largest coordinate counts as on it.

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
    source = torch.where(present, torch.arange(points.shape[1], device=points.device), stand_in)
    corner, count = _corners(_pick(points.detach(), source))
    count = count * present.any(dim=1)
    vertices = _pick(points, source.gather(1, corner))
    return Polygons(torch.where(count[:, None, None] > 0, vertices, 0.0), count)


def clip(subject: Polygons, clipper: Polygons) -> Polygons:
    """Intersections of B pairs of convex polygons (Sutherland and Hodgman 1974), differentiable.

    Convention:
        Polygons contain their border: two that touch along an edge share that segment (count 2, area 0),
        two that touch at a corner share that point (count 1). Anything nearer than 1e-13 of the largest
        coordinate touches. Points and segments are clipped and clip like any other polygon.

    Raises:
        ValueError: the batches differ in length.
    """
    if len(subject) != len(clipper):
        raise ValueError(
            f"Polygons are clipped in pairs, but there are {len(subject)} subjects and {len(clipper)} clippers."
        )
    reach = torch.cat([subject.vertices, clipper.vertices], dim=1).detach().abs().amax(dim=(1, 2))
    normal, anchor = _half_planes(clipper)
    count = subject.count * (clipper.count > 0)
    vertices = subject.vertices
    for side in range(normal.shape[1]):
        vertices, count = _cut(vertices, count, normal[:, side], anchor[:, side], _SLACK * reach[:, None])
    return Polygons(torch.where(count[:, None, None] > 0, vertices, 0.0), count)


def area(polygons: Polygons) -> Tensor:
    """Areas, (B,) square metres; differentiable."""
    return 0.5 * _fan(polygons.vertices).sum(dim=1)


def centroid(polygons: Polygons) -> Tensor:
    """Centres of area, (B, 2) metres: the middle of a segment, the point itself, NaN where empty."""
    vertices, count = polygons.vertices, polygons.count[:, None]
    weight = _fan(vertices)
    total = torch.where(count > 2, weight.sum(dim=1, keepdim=True), 1.0)
    arms = vertices - vertices[:, :1]
    middle = arms[:, 0] + ((arms[:, :-1] + arms[:, 1:]) * weight[..., None]).sum(dim=1) / (3.0 * total)
    center = vertices[:, 0] + torch.where(count > 2, middle, 0.5 * arms[:, -1])
    return torch.where(count > 0, center, torch.nan)


def signed_distance(polygons: Polygons, points: Tensor) -> Tensor:
    """Distances from points (B, 2) to the border of their polygon, (B,) metres; differentiable.

    Convention:
        Positive inside, negative outside, zero on the border. Points and segments have no inside:
        minus the distance to them. NaN where the polygon is empty.
    """
    start = polygons.vertices
    edge = start.roll(-1, dims=1) - start
    arm = points[:, None] - start
    squared = edge.square().sum(dim=2)
    proper = squared > 0
    squared = torch.where(proper, squared, 1.0)
    depth = torch.where(proper, _cross(edge, arm) / squared.sqrt(), torch.inf).amin(dim=1)
    share = ((arm * edge).sum(dim=2) / squared).clamp(0.0, 1.0)
    distance = (arm - share[..., None] * edge).square().sum(dim=2).amin(dim=1)
    # The root of zero has no finite slope; zero itself is the border.
    distance = torch.where(distance > 0, torch.where(distance > 0, distance, 1.0).sqrt(), 0.0)
    inside = (polygons.count > 2) & (depth >= 0)
    return torch.where(polygons.count > 0, torch.where(inside, depth, -distance), torch.nan)


def _corners(points: Tensor) -> tuple[Tensor, Tensor]:
    """Indices of the hull's corners among (B, n, 2) points, counter-clockwise, the last repeated; their number."""
    slack = _SLACK * points.abs().amax(dim=(1, 2))[:, None]
    x, order = points[..., 0].sort(dim=1)
    y = points[..., 1].gather(1, order)
    # Points one above the other to within rounding form a column: only its lowest and its highest matter.
    column = pad((x.diff(dim=1) > slack).cumsum(dim=1), (1, 0))
    chain, size = _lower_chains(x.repeat(2, 1), torch.cat([y, -y]), column.repeat(2, 1), slack.repeat(2, 1))
    (lower, upper), (lower_size, upper_size) = chain.chunk(2), size.chunk(2)
    # The leftmost and the rightmost corner are on both chains, except where the hull has an upright edge.
    height = y.gather(1, upper[:, [0, -1]]) - y.gather(1, lower[:, [0, -1]])
    left, right = (height <= slack).split(1, dim=1)
    place = torch.arange(chain.shape[1], device=x.device)
    above = (place < upper_size) & ~(left & (place == 0)) & ~(right & (place == upper_size - 1))
    corner, count = _packed(torch.cat([place < lower_size, above.flip(1)], dim=1))
    return order.gather(1, torch.cat([lower, upper.flip(1)], dim=1).gather(1, corner)), count


def _lower_chains(x: Tensor, y: Tensor, column: Tensor, slack: Tensor) -> tuple[Tensor, Tensor]:
    """Lower hulls, left to right, of points sorted by column: their indices, the last repeated; number (B, 1)."""
    place = torch.arange(x.shape[1], device=x.device)
    lowest = torch.full_like(y, torch.inf).scatter_reduce(1, column, y, "amin").gather(1, column)
    index = torch.where(y == lowest, place, len(place))
    chain = torch.full_like(column, len(place)).scatter_reduce(1, column, index, "amin")
    size = column[:, -1:] + 1
    chain = chain.gather(1, place.minimum(size - 1))
    while True:
        place = torch.arange(chain.shape[1], device=x.device)
        corner = torch.stack([x.gather(1, chain), y.gather(1, chain)], dim=2)
        chord = corner[:, 2:] - corner[:, :-2]
        rise = _cross(chord, corner[:, 1:-1] - corner[:, :-2])
        room = slack * chord.abs().sum(dim=2)
        inner = place[1:-1] < size - 1
        level = inner & (rise.abs() <= room)
        # Of two neighbours, each level with the other's neighbours, one may be a corner: never drop both at once.
        odd = level & (place[1:-1] % 2 == 1)
        drop = (inner & (rise > room)) | torch.where(odd.any(dim=1, keepdim=True), odd, level)
        if not bool(drop.any()):
            return chain, size
        kept, count = _packed(~pad(drop, (1, 1)) & (place < size))
        chain, size = chain.gather(1, kept), count[:, None]


def _half_planes(polygons: Polygons) -> tuple[Tensor, Tensor]:
    """Inward unit normals of the half-planes that bound each polygon, and a point on each border, (B, E, 2).

    A segment is bounded by its line from either side and by a line across either end, and so is a point.
    A normal of zero bounds nothing.
    """
    vertices = polygons.vertices
    edge = vertices.roll(-1, dims=1) - vertices
    squared = edge.square().sum(dim=2, keepdim=True)
    along = edge / torch.where(squared > 0, squared, 1.0).sqrt()
    ahead = torch.where(polygons.count[:, None] > 1, along[:, 0], along.new_tensor([1.0, 0.0]))
    left = torch.stack([-ahead[:, 1], ahead[:, 0]], dim=1)
    start, end = vertices[:, 0], vertices[:, -1]

    spare = (0, 0, 0, max(0, 4 - vertices.shape[1]))
    along, anchor = pad(along, spare), pad(vertices, spare)
    flat = (polygons.count < 3)[:, None, None]
    around = torch.where(flat, torch.stack([ahead, left, -ahead, -left], dim=1), along[:, :4])
    at = torch.where(flat, torch.stack([start, end, end, start], dim=1), anchor[:, :4])
    along, anchor = torch.cat([around, along[:, 4:]], dim=1), torch.cat([at, anchor[:, 4:]], dim=1)
    return torch.stack([-along[..., 1], along[..., 0]], dim=2), anchor


def _cut(vertices: Tensor, count: Tensor, normal: Tensor, anchor: Tensor, slack: Tensor) -> tuple[Tensor, Tensor]:
    """What a half-plane leaves of each polygon."""
    place = torch.arange(vertices.shape[1], device=vertices.device)
    depth = ((vertices - anchor[:, None]) * normal[:, None]).sum(dim=2)
    depth = torch.where(depth.abs() > slack, depth, 0.0)
    following = depth.roll(-1, dims=1)
    # A segment has one edge, which a loop over vertices meets twice.
    crossed = (depth * following < 0) & ((count[:, None] > 2) | (place == 0))
    share = depth / torch.where(crossed, depth - following, 1.0)
    crossing = vertices + share[..., None] * (vertices.roll(-1, dims=1) - vertices)
    kept = (depth >= 0) & (place < count[:, None])
    index, count = _packed(torch.stack([kept, crossed], dim=2).flatten(1))
    return _pick(torch.stack([vertices, crossing], dim=2).flatten(1, 2), index), count


def _packed(flags: Tensor) -> tuple[Tensor, Tensor]:
    """Columns of the true flags of each row of (B, n), in order, then the last repeated; and their number."""
    count = flags.sum(dim=1)
    width = int(torch.cat([count, count.new_ones(1)]).max())
    place = torch.arange(flags.shape[1], device=flags.device)
    target = torch.where(flags, flags.cumsum(dim=1) - 1, width)
    column = target.new_zeros(len(flags), width + 1).scatter(1, target, place.expand_as(target))
    last = (count - 1).clamp(min=0)[:, None]
    return column.gather(1, place.minimum(last)[:, :width]), count


def _fan(vertices: Tensor) -> Tensor:
    """Twice the areas of the triangles between the first vertex and every edge, (B, V - 1)."""
    arms = vertices - vertices[:, :1]
    return _cross(arms[:, :-1], arms[:, 1:])


def _cross(a: Tensor, b: Tensor) -> Tensor:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _pick(points: Tensor, index: Tensor) -> Tensor:
    return points.gather(1, index[..., None].expand(-1, -1, 2))
