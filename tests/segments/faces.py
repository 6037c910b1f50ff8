"""Which face of a block each pixel shows."""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes


class Faces(NamedTuple):
    """The faces that an image shows, the table's first.

    Args:
        label: (H, W) int64, 0 = none, faces from 1.
        normals: (F, 3) float64, in the world frame.
    """

    label: Tensor
    normals: Tensor


def faces_of(boxes: Boxes, region: Tensor, points: Tensor) -> Faces:
    """The faces of a table and the boxes on it.

    Args:
        boxes: in the world frame.
        region: (H, W) int64, 0 = none, 1 = the table, box k is k + 2.
        points: (H, W, 3) float64, what each pixel shows of them, exactly.
    """
    label, normals = (region == 1).long(), [torch.tensor([0.0, 1.0, 0.0], dtype=torch.float64)]
    for k in range(len(boxes)):
        local = (points - boxes.center[k]) @ boxes.rotation[k]
        side = (local.abs() - boxes.half_extent[k]).argmax(dim=2)
        for axis in range(3):
            for sign in (-1.0, 1.0):
                seen = (region == k + 2) & (side == axis) & (local[..., axis] * sign > 0)
                if bool(seen.any()):
                    normals.append(sign * boxes.rotation[k][:, axis])
                    label[seen] = len(normals)
    return Faces(label, torch.stack(normals))
