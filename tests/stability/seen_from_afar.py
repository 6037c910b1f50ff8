"""Worlds of blocks looked at by a camera: what true boxes hide from it, by intersecting rays with them."""

from __future__ import annotations

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.stability.judges import TrimmedSupports
from blockstab.stability.situation import Situation, Unseen
from blockstab.stability.support import SupportRules
from blockstab.stability.unseen import Hidden
from blockstab.testing.worlds import Block, build

EYE = torch.tensor([0.0, 0.6, 1.2], dtype=torch.float64)  # before the blocks, and above them
RULES = SupportRules(touch_m=0.005, touch_per_square_m=0.0)


def looked_at(*blocks: Block, eye: Tensor = EYE) -> tuple[Boxes, Tensor]:
    """The boxes of blocks, with the camera in the origin, and which of them are movable."""
    boxes, movable = build(*blocks)
    return Boxes(boxes.center - eye, boxes.rotation, boxes.half_extent), movable


def hidden_by(boxes: Boxes) -> Hidden:
    """Tells what lies behind a face of these boxes, or in them."""

    def hidden(points: Tensor) -> Tensor:
        rays = points.reshape(-1, 3)
        found = torch.zeros(len(rays), dtype=torch.bool)
        for k in range(len(boxes)):
            start, along = -(boxes.center[k] @ boxes.rotation[k]), rays @ boxes.rotation[k]
            ends = torch.stack([(s * boxes.half_extent[k] - start) / along for s in (-1.0, 1.0)])
            enter, leave = ends.amin(dim=0).amax(dim=1), ends.amax(dim=0).amin(dim=1)
            found |= (enter < leave) & (enter > 0) & (enter * rays.norm(dim=1) < rays.norm(dim=1) - 1e-6)
        return found.view(points.shape[:-1])

    return hidden


def situation(boxes: Boxes, movable: Tensor, eye: Tensor = EYE) -> Situation:
    """What may stand on what, as the paper's rule judges it; the ground is that of the blocks."""
    ground = torch.zeros_like(movable)
    return Situation(boxes, movable, ground, -float(eye[1]), RULES, TrimmedSupports(), Unseen.none())
