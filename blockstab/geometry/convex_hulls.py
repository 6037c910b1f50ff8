"""Convex polygons in the plane, in batches: hull, clip, area, centroid, signed distance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn.functional import pad

from blockstab.geometry.polygons import SLACK, corners_of_hulls, cross, cut, pick, planar, summed


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
    corner, count = corners_of_hulls(pick(planar(points.detach()), source))
    return _polygons(pick(planar(points), source.gather(0, corner)), count * present.any(dim=1))


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
    corners, count = planar(subject.vertices), subject.count * (clipper.count > 0)
    anchors, normals = _half_planes(clipper)
    for anchor, normal in zip(anchors.unbind(1), normals.unbind(1), strict=True):
        corners, count = cut(corners, count, anchor, normal, SLACK * reach)
    return _polygons(corners, count)


def area(polygons: Polygons) -> Tensor:
    """Areas, (B,) square metres; differentiable."""
    arms = _arms(polygons)
    return 0.5 * summed(cross(arms[:, :-1], arms[:, 1:]))


def centroid(polygons: Polygons) -> Tensor:
    """Centres of area, (B, 2) metres: of a segment its middle, of a point itself, NaN where empty."""
    arms = _arms(polygons)
    weight = cross(arms[:, :-1], arms[:, 1:])
    solid = polygons.count > 2
    total = torch.where(solid, summed(weight), 1.0)
    middle = summed((arms[:, :-1] + arms[:, 1:]) * weight) / (3.0 * total)
    center = polygons.vertices[:, 0] + torch.where(solid, middle, 0.5 * arms[:, -1]).T
    return torch.where(polygons.count[:, None] > 0, center, torch.nan)


def signed_distance(polygons: Polygons, points: Tensor) -> Tensor:
    """Distances from points (B, 2) to the border of their polygon, (B,) metres; differentiable.

    Convention:
        Positive inside, negative outside, zero on the border. Points and segments have no inside:
        minus the distance to them. NaN where the polygon is empty.
    """
    start = planar(polygons.vertices)
    edge = start.roll(-1, dims=1) - start
    arm = points.T[:, None] - start
    squared = edge.square().sum(dim=0)
    proper = squared > 0
    squared = torch.where(proper, squared, 1.0)
    depth = torch.where(proper, cross(edge, arm) / squared.sqrt(), torch.inf).amin(dim=0)
    share = ((arm * edge).sum(dim=0) / squared).clamp(0.0, 1.0)
    distance = (arm - share * edge).square().sum(dim=0).amin(dim=0)
    # The root has no finite slope at zero, which is the border itself.
    distance = torch.where(distance > 0, torch.where(distance > 0, distance, 1.0).sqrt(), 0.0)
    inside = (polygons.count > 2) & (depth >= 0)
    return torch.where(polygons.count > 0, torch.where(inside, depth, -distance), torch.nan)


def _half_planes(polygons: Polygons) -> tuple[Tensor, Tensor]:
    """A point on the border of every half-plane that bounds a polygon, and its inward unit normal, (2, E, B).

    A segment is bounded by its line from either side and by a line across either end; a point likewise.
    A normal of zero bounds nothing.
    """
    anchor = planar(polygons.vertices)
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


def _polygons(corners: Tensor, count: Tensor) -> Polygons:
    return Polygons(torch.where(count > 0, corners, 0.0).permute(2, 1, 0).contiguous(), count)


def _arms(polygons: Polygons) -> Tensor:
    """From the first vertex to every vertex, (2, V, B)."""
    return planar(polygons.vertices - polygons.vertices[:, :1])
