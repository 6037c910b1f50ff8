"""Gap between two boxes, and its direction (paper, section 5.1)."""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes

_CHUNK = 4096  # pairs at a time: the working set stays in the cache, and a million pairs in little memory
_MIN_CROSS = 1e-3  # edges closer to parallel than this (radians) span no axis of their own
_TIE = 1e-9  # metres; axes whose gaps differ by less tie, and face normals win ties
_EDGE_TIE = 2e-7  # of the summed half extents: more than a turn of 1e-7 rad moves any gap of touching boxes

# Candidate axes in order of preference: 3 normals of the first box, 3 of the second, 9 edge cross products.
_FIRST_AXIS = torch.tensor([0, 1, 2, 0, 0, 0, 0, 0, 0, 1, 1, 1, 2, 2, 2])
_SECOND_AXIS = torch.tensor([0, 0, 0, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2])


class Separation(NamedTuple):
    """Gaps between the boxes of P pairs, and their directions."""

    gap: Tensor  # (P,) metres; negative where the boxes overlap
    direction: Tensor  # (P, 3) unit vectors pointing from the first box to the second


def separation(boxes: Boxes, first: Tensor, second: Tensor) -> Separation:
    """Find, for each pair, the axis that separates the two boxes best and the gap along it.

    Fifteen axes decide: the face normals of each box, and the cross product of every edge of
    one with every edge of the other (Gottschalk et al. 1996). They are the axes the paper reaches
    by projecting both boxes onto planes parallel to each face. Both results are differentiable
    with respect to the boxes, wherever the best axis is unique.

    Args:
        boxes: N boxes in one frame, metres.
        first, second: (P,) int64 indices into `boxes`; pair p is `first[p]`, `second[p]`.

    Convention:
        Contact is a gap of zero: a box resting on another does not overlap it. Where boxes
        overlap, `-gap` (the paper's D) is the shortest move that frees them, and moving the second
        box by it along `direction` does. Where they are apart, the gap is the widest empty
        slab between them: never more than the Euclidean distance, and less where the nearest points
        are two corners, or a corner and an edge.
        Face normals win ties, those of the first box before those of the second. An axis of two edges
        is reported only where its gap exceeds that of every face by 2e-7 of the summed half extents, so
        that noise in the rotation of boxes with parallel edges does not change the answer. Where the
        centres do not differ along the axis, the direction is the axis itself.

    Raises:
        ValueError: an index is not that of a box, or the two lists differ in length.
    """
    if first.shape != second.shape:
        raise ValueError(
            f"A pair is an index in each list, but first has shape {tuple(first.shape)} "
            f"and second {tuple(second.shape)}; give both one index for every pair."
        )
    for name, index in (("first", first), ("second", second)):
        wrong = (index < 0) | (index >= len(boxes))
        if bool(wrong.any()):
            pair = int(wrong.nonzero()[0])
            raise ValueError(
                f"Pairs must name two of the {len(boxes)} boxes, but {name}[{pair}] is {int(index[pair])}; "
                "leave out pairs with the ground."
            )
    parts = [
        _separation(boxes, i, j)
        for i, j in zip(*(torch.split(index, _CHUNK) for index in (first, second)), strict=True)
    ]
    return Separation(torch.cat([part.gap for part in parts]), torch.cat([part.direction for part in parts]))


def _separation(boxes: Boxes, first: Tensor, second: Tensor) -> Separation:
    offset = boxes.center[second] - boxes.center[first]
    gaps, eligible = _axis_gaps(boxes, first, second, offset)
    axis = _preferred_axis(gaps.detach(), eligible, boxes.half_extent.detach(), first, second)
    direction = _direction(boxes, first, second, axis)
    along = (direction * offset).sum(dim=1)
    direction = torch.where((along < -_TIE)[:, None], -direction, direction)
    return Separation(gaps.gather(0, axis[None])[0], direction)


def _axis_gaps(boxes: Boxes, first: Tensor, second: Tensor, offset: Tensor) -> tuple[Tensor, Tensor]:
    """Gaps along the candidate axes, (15, P) metres, and which of the last nine are axes at all, (3, 3, P).

    Pairs run along the last dimension, so that every step below is one sweep over contiguous numbers.
    """
    by_axis = boxes.rotation.permute(2, 1, 0)  # (axis, xyz, N)
    axes_a, axes_b = by_axis[..., first], by_axis[..., second]
    half_a, half_b = boxes.half_extent.T[:, first], boxes.half_extent.T[:, second]
    offset_a, offset_b = (axes_a * offset.T).sum(dim=1), (axes_b * offset.T).sum(dim=1)

    cosine = (axes_a[:, None] * axes_b[None]).sum(dim=2)  # axis of the first, axis of the second, pair
    reach = cosine.abs()
    faces_a = offset_a.abs() - half_a - (reach * half_b[None]).sum(dim=1)
    faces_b = offset_b.abs() - half_b - (reach * half_a[:, None]).sum(dim=0)

    # Axis i of the first box x axis j of the second has no part along i, and its parts along i+1 and i+2
    # are those of axis j, swapped: no cross product has to be formed.
    after_a, last_a = _cyclic(cosine)
    after_reach_a, last_reach_a = _cyclic(reach)
    after_reach_b, last_reach_b = _cyclic(reach.transpose(0, 1))
    after_half_a, last_half_a = _cyclic(half_a[:, None])
    after_half_b, last_half_b = _cyclic(half_b[:, None])
    after_offset, last_offset = _cyclic(offset_a[:, None])
    length = after_a.square() + last_a.square()
    eligible = length > _MIN_CROSS**2
    width_a = after_half_a * last_reach_a + last_half_a * after_reach_a
    width_b = (after_half_b * last_reach_b + last_half_b * after_reach_b).transpose(0, 1)
    edges = (last_offset * after_a - after_offset * last_a).abs() - width_a - width_b
    edges = edges * torch.where(eligible, length, 1.0).rsqrt()
    return torch.cat([faces_a, faces_b, edges.flatten(0, 1)]), eligible


def _cyclic(values: Tensor) -> tuple[Tensor, Tensor]:
    """The two other rows of every row of (3, ...) values, in cyclic order."""
    twice = torch.cat([values, values[:2]])
    return twice[1:4], twice[2:5]


def _preferred_axis(gaps: Tensor, eligible: Tensor, half: Tensor, first: Tensor, second: Tensor) -> Tensor:
    """Index of the axis of greatest gap, ties settled by the order of the axes, (P,)."""
    handicap = torch.arange(6, dtype=gaps.dtype, device=gaps.device) * (_TIE / 6)
    face, best_face = (gaps[:6] - handicap[:, None]).max(dim=0)
    size = half.sum(dim=1)
    edge, best_edge = torch.where(eligible.flatten(0, 1), gaps[6:], -torch.inf).max(dim=0)
    beaten = edge > face + _TIE + _EDGE_TIE * (size[first] + size[second])
    return torch.where(beaten, best_edge + 6, best_face)


def _direction(boxes: Boxes, first: Tensor, second: Tensor, axis: Tensor) -> Tensor:
    """The chosen axes as unit vectors, (P, 3)."""
    by_axis = boxes.rotation.transpose(1, 2)
    axis_a = by_axis[first, _FIRST_AXIS.to(axis.device)[axis]]
    axis_b = by_axis[second, _SECOND_AXIS.to(axis.device)[axis]]
    edges = (axis >= 6).nonzero()[:, 0]
    crossed = torch.linalg.cross(axis_a[edges], axis_b[edges])
    crossed = crossed / torch.linalg.vector_norm(crossed, dim=1, keepdim=True)
    return torch.where((axis < 3)[:, None], axis_a, axis_b).index_copy(0, edges, crossed)
