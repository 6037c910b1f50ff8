"""Contact points between boxes, and between boxes and the ground: where forces can act, and along which normal."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import torch
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.boxes.separation import separation
from blockstab.geometry.polygons import SLACK, cut
from blockstab.stability.support import GROUND, Supports

FRICTION = 0.7  # coefficient, as of wood on wood, and as simulated scenes have it
EDGE_M = 1e-6  # half the width of an edge or corner, on which another one would else never come to lie
# Of the corners of a face, walked around: the sign along its one edge, and along its other.
_WALK = torch.tensor([[-1.0, 1.0, 1.0, -1.0], [-1.0, -1.0, 1.0, 1.0]], dtype=torch.float64)


class Contacts(NamedTuple):
    """P points at which one box may press on another.

    Args:
        supporter: (P,) int64 box indices; `GROUND` is the ground plane.
        supported: (P,) int64 box indices.
        point: (P, 3) metres, world frame.
        normal: (P, 3) unit vectors from the supporter to the supported; a force along them is one of pressure.
    """

    supporter: Tensor
    supported: Tensor
    point: Tensor
    normal: Tensor


def contacts_of(
    boxes: Boxes, candidates: Supports, angle_deg: float = 20.0, edge_m: float = EDGE_M
) -> Contacts:
    """Corners of the patches in which boxes touch that may hold each other up.

    A patch is where what the two boxes turn to each other, a face, an edge or a corner each, overlaps as seen along
    their separating direction.

    Args:
        boxes: N boxes, world frame, +y up.
        candidates: relations between them; a pair that is there both ways is one contact.
        angle_deg: an edge that leans towards the other box by less belongs to what faces it.
        edge_m: half the width of edges and corners, metres.
    """
    below, above = candidates.supporter, candidates.supported
    floor = torch.unique(above[below == GROUND])
    pair = torch.stack([below, above], dim=1)[below != GROUND].sort(dim=1).values
    first, second = torch.unique(pair, dim=0).unbind(dim=1)
    along = separation(boxes, first, second).direction
    limit = math.sin(math.radians(angle_deg))
    points, count = _overlaps(
        _facing(boxes[first], along, limit), _facing(boxes[second], -along, limit), along, edge_m
    )
    up = along.new_tensor([0.0, 1.0, 0.0]).expand(len(floor), 3)
    resting, corners = _facing(boxes[floor], -up, limit)
    parts = [
        (first, second, points, count, along),
        (torch.full_like(floor, GROUND), floor, resting, corners, up),
    ]
    return _flattened(parts)


def loosened(contacts: Contacts, slack: Tensor) -> Contacts:
    """Each point as four, `slack` (N,) metres of the less certain of its two boxes to either side along its patch."""
    beside = torch.where(contacts.supporter == GROUND, 0.0, slack[contacts.supporter.clamp(min=0)])
    reach = torch.maximum(slack[contacts.supported], beside)[:, None, None]
    axes = plane_axes(contacts.normal).transpose(1, 2) * reach
    shift = torch.cat([axes, -axes], dim=1)
    return Contacts(
        contacts.supporter.repeat_interleave(4),
        contacts.supported.repeat_interleave(4),
        (contacts.point[:, None] + shift).flatten(0, 1),
        contacts.normal.repeat_interleave(4, dim=0),
    )


def _flattened(parts: list[tuple[Tensor, Tensor, Tensor, Tensor, Tensor]]) -> Contacts:
    columns: list[list[Tensor]] = [[], [], [], []]
    for supporter, supported, points, count, normal in parts:
        patch, corner = (torch.arange(points.shape[1]) < count[:, None]).nonzero(as_tuple=True)
        for column, values in zip(
            columns, (supporter[patch], supported[patch], points[patch, corner], normal[patch]), strict=True
        ):
            column.append(values)
    return Contacts(*map(torch.cat, columns))


def _facing(boxes: Boxes, along: Tensor, limit: float) -> tuple[Tensor, Tensor]:
    """Corners (N, 4, 3) of the face, edge or corner of each box furthest along a direction, and how many (N,)."""
    cosine = torch.einsum("nik,ni->nk", boxes.rotation, along)
    order = cosine.abs().argsort(dim=1, stable=True)
    cosine = cosine.gather(1, order)
    free = cosine[:, :2].abs() <= limit
    free[:, 1] &= free[:, 0]
    toward = torch.where(cosine < 0, -1.0, 1.0)
    sign = torch.where(free[:, :, None], _WALK, toward[:, :2, None])  # (N, 2, 4)
    sign = torch.cat([sign, toward[:, 2:, None].expand(-1, 1, 4)], dim=1)
    axes = boxes.rotation.gather(2, order[:, None].expand(-1, 3, -1))
    half = boxes.half_extent.gather(1, order)
    corners = boxes.center[:, None] + torch.einsum("nik,nkc->nci", axes, sign * half[:, :, None])
    return corners, 2 ** free.sum(dim=1)


def _overlaps(
    one: tuple[Tensor, Tensor], other: tuple[Tensor, Tensor], along: Tensor, edge_m: float
) -> tuple[Tensor, Tensor]:
    """Corners (C, V, 3) of the overlap of two features seen along a direction, halfway between, and how many (C,)."""
    axes = plane_axes(along)
    (corners, count), (others, other_count) = one, other
    swap = other_count > count
    clipping = torch.where(swap[:, None, None], others, corners)
    clipped = torch.where(swap[:, None, None], corners, others)
    frame, frame_count = torch.einsum("cvi,ciu->ucv", clipping, axes), torch.maximum(count, other_count)
    polygon = torch.einsum("cvi,ciu->uvc", clipped, axes).contiguous()
    amount = torch.minimum(count, other_count)
    slack = SLACK * polygon.abs().amax(dim=(0, 1))
    for anchor, inward in _sides(frame, frame_count, edge_m):
        polygon, amount = cut(polygon, amount, anchor, inward, slack)
    height = (
        torch.einsum("cvi,ci->cv", corners, along).amax(1) + torch.einsum("cvi,ci->cv", others, along).amin(1)
    ) / 2
    points = torch.einsum("uvc,ciu->cvi", polygon, axes) + (height[:, None] * along)[:, None]
    return points, amount


def _sides(frame: Tensor, count: Tensor, edge_m: float) -> list[tuple[Tensor, Tensor]]:
    """Anchors (2, C) and inward normals (2, C) of the four sides of features (2, C, 4), edges and corners widened."""
    start, right, far = frame[:, :, 0], frame[:, :, 1], frame[:, :, 3]
    middle = (
        frame[:, :, 0] + torch.where(count == 4, frame[:, :, 2], torch.where(count == 2, right, start))
    ) / 2
    u = torch.where(count >= 2, right - start, start.new_tensor([[1.0], [0.0]]))
    v = torch.where(count == 4, far - start, torch.stack([-u[1], u[0]]))
    result = []
    for edge, across in ((u, v), (v, u)):
        normal = torch.stack([-edge[1], edge[0]]) / edge.norm(dim=0)
        reach = (normal * across).sum(dim=0)
        normal = torch.where(reach < 0, -normal, normal)
        thick = (count == 4) | ((count == 2) & (edge is v))
        half = torch.where(thick, reach.abs() / 2, 0.0) + torch.where(count == 4, 0.0, edge_m)
        result += [(middle - half * normal, normal), (middle + half * normal, -normal)]
    return result


def plane_axes(normal: Tensor) -> Tensor:
    """Two unit vectors at right angles to each normal (C, 3) and to each other: (C, 3, 2), its columns."""
    least = torch.nn.functional.one_hot(normal.abs().argmin(dim=1), 3).to(normal.dtype)
    u = torch.linalg.cross(normal, least)
    u = u / u.norm(dim=1, keepdim=True)
    return torch.stack([u, torch.linalg.cross(normal, u)], dim=2)


def islands_of(contacts: Contacts, movable: Tensor) -> Iterator[tuple[Tensor, Contacts]]:
    """Movable boxes that touch, directly or by others, with the background that they touch, and their contacts.

    Yields:
        (M,) box indices, ascending, and contacts in which box `i` is the one in place `i` of those.
    """
    held, holding = contacts.supported, contacts.supporter
    number = linked(holding, held, movable)
    of_contact = number[torch.where(movable[held], held, holding)]
    for island in torch.unique(number[movable]).tolist():
        mine, own = of_contact == island, (number == island) & movable
        ends = torch.cat([holding[mine], held[mine]])
        own[ends[ends >= 0]] = True
        place = torch.cat([own.cumsum(dim=0) - 1, torch.tensor([GROUND])])  # which is the last place
        yield (
            own.nonzero()[:, 0],
            Contacts(place[holding[mine]], place[held[mine]], contacts.point[mine], contacts.normal[mine]),
        )


def linked(below: Tensor, above: Tensor, movable: Tensor) -> Tensor:
    """(N,) int64 numbers, the same of movable boxes that pairs (E,), (E,) of box indices link, directly or not."""
    both = (below >= 0) & movable[below] & movable[above]
    ends = below[both].numpy(), above[both].numpy()
    links = coo_array((np.ones(len(ends[0])), ends), shape=(len(movable), len(movable)))
    return torch.from_numpy(connected_components(links, directed=False)[1]).to(torch.int64)
