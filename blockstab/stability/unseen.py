"""Reach of the faces of boxes into what the camera did not see: how far each may go on unseen."""

from __future__ import annotations

from collections.abc import Callable

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.stability.amodal import HIDDEN_SHARE

STEP_M = 0.01  # by which faces are moved out
MOST_M = 0.4  # and how far at most
_GRID = 5  # points along an edge of a face
_INSIDE_M = 0.005  # deeper than this in another box, there is no room
# Boxes reach a little beyond their thing: of a face this much is left out along its rim, but not more than that
# share of half of it.
_RIM_M, _RIM_SHARE = 0.01, 0.4

Hidden = Callable[[Tensor], Tensor]  # from points (..., 3) to whether the camera could not have seen them


def unseen_reach(boxes: Boxes, which: Tensor, hidden: Hidden, others: Tensor, ground_height: float) -> Tensor:
    """How far each face of some boxes may go on unseen, (K, 6) metres; 0 where what was seen ends it.

    A face goes on step by step, as long as what the camera would have seen of the step was hidden from it, and there
    is room: no other box, and not the ground. So a face that was seen stays where it is, and so does one beside or
    behind which the camera looks past.

    Args:
        boxes: N boxes, world frame, the camera in the origin.
        which: (K,) indices of those that are asked about.
        hidden: tells what the camera could not see.
        others: (N,) bool, the boxes that take up room.
        ground_height: metres.
    """
    levels = torch.arange(1, round(MOST_M / STEP_M) + 1, dtype=torch.float64) * STEP_M
    reach = torch.zeros(len(which), 6, dtype=torch.float64)
    for face in range(6):
        sides, end = _shell(boxes[which], face, levels)
        shown = torch.cat([sides[0].flatten(2, 3), end[0]], dim=2)
        facing = torch.cat([sides[1].flatten(2, 3), end[1]], dim=2)
        unseen = (hidden(shown) & facing).sum(dim=2) >= HIDDEN_SHARE * facing.sum(dim=2)
        room = ~_occupied(end[0], boxes, which, others, ground_height)
        reach[:, face] = (unseen & room).to(torch.float64).cumprod(dim=1).sum(dim=1) * STEP_M
    return reach


def _shell(boxes: Boxes, face: int, levels: Tensor) -> tuple[tuple[Tensor, Tensor], tuple[Tensor, Tensor]]:
    """Surface of each step beyond one face of K boxes: its four sides, and its end.

    Returns:
        points (K, L, 4, G, 3) in the middle of the step, and whether each faces the camera, (K, L, 4, G);
        points (K, L, G * G, 3) at the end of it, and the same, (K, L, G * G).
    """
    across = (2 * torch.arange(_GRID, dtype=torch.float64) + 1) / _GRID - 1
    out, center = boxes.face_normals()[:, face], boxes.face_centers()[:, face]
    u, v = (k for k in range(3) if k != face // 2)
    half = boxes.half_extent - torch.minimum(boxes.half_extent * _RIM_SHARE, torch.tensor(_RIM_M).double())
    edges = [boxes.rotation[:, :, k] * half[:, k, None] for k in (u, v)]
    middle = center[:, None] + out[:, None] * (levels - STEP_M / 2)[:, None]
    points, normals = [], []
    for one, other in (edges, edges[::-1]):
        for turn in (1.0, -1.0):
            line = turn * one[:, None] + across[:, None] * other[:, None]
            points.append(middle[:, :, None] + line[:, None])
            normals.append(turn * one)
    sides = torch.stack(points, dim=2)
    outward = torch.stack(normals, dim=1)[:, None, :, None]
    grid = across[:, None, None] * edges[0][:, None, None] + across[:, None] * edges[1][:, None, None]
    end = (center[:, None] + out[:, None] * levels[:, None])[:, :, None] + grid.flatten(1, 2)[:, None]
    return (sides, (sides * outward).sum(dim=-1) < 0), (end, (end * out[:, None, None]).sum(dim=-1) < 0)


def _occupied(points: Tensor, boxes: Boxes, which: Tensor, others: Tensor, ground_height: float) -> Tensor:
    """(K, L) bool: whether any of the points (K, L, P, 3) lies in another box, or in the ground."""
    local = boxes.local(points.view(1, -1, 3).expand(len(boxes), -1, 3)).view(len(boxes), *points.shape)
    inside = (local.abs() < (boxes.half_extent - _INSIDE_M)[:, None, None, None]).all(dim=-1)
    inside &= (others[:, None] & (which != torch.arange(len(boxes))[:, None]))[..., None, None]
    return inside.any(dim=0).any(dim=2) | (points[..., 1] < ground_height - _INSIDE_M).any(dim=2)


def grown(boxes: Boxes, added: Tensor) -> Boxes:
    """The boxes with each face moved out by `added` (N, 6) metres."""
    along, against = added[:, 0::2], added[:, 1::2]
    shift = (boxes.rotation * ((along - against) / 2)[:, None]).sum(dim=-1)
    return Boxes(boxes.center + shift, boxes.rotation, boxes.half_extent + (along + against) / 2)
