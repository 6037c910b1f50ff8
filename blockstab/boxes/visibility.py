"""Visible faces of boxes, and the share of a segment's points that lie on them (paper, section 4.2)."""

from __future__ import annotations

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes


def visible_faces(boxes: Boxes) -> Tensor:
    """Faces whose outer side looks at the camera in the origin, (N, 6) bool; at most three a box."""
    return (boxes.face_normals() * boxes.face_centers()).sum(dim=-1) < 0


def nearest_face(boxes: Boxes, points: Tensor) -> Tensor:
    """The face of its box that each of the points (N, P, 3) is nearest to, (N, P) in 0..5."""
    local, half = boxes.local(points), boxes.half_extent[:, None]
    distance = torch.stack([(local - half).abs(), (local + half).abs()], dim=-1)
    return distance.flatten(2).argmin(dim=-1)


def visible_share(boxes: Boxes, points: Tensor, present: Tensor) -> Tensor:
    """Share of the points (N, P, 3) that are nearest to a face the camera sees, (N,) between 0 and 1."""
    seen = visible_faces(boxes).gather(1, nearest_face(boxes, points))
    return (seen & present).sum(dim=1).to(points.dtype) / present.sum(dim=1).clamp(min=1)
