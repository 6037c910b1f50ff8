"""Occlusion: what the camera saw, and what was hidden from it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import torch
from torch import Tensor

from blockstab.rgbd.frame import Camera


@dataclass(frozen=True)
class Occlusion:
    """Depth along every ray of the camera.

    Args:
        depth: (H, W) metres, 0 where the sensor gave none.
        camera: intrinsics.
        world_from_camera: (3, 3) rotation.
    """

    depth: Tensor
    camera: Camera
    world_from_camera: Tensor

    def without_gaps(self) -> Occlusion:
        """The same where missing depth is that of what lies further back, to the left of the gap or to the right.

        A sensor with two eyes sees nothing beside what stands before a surface; that is the surface's.
        """
        at_left, at_right = _carried_on(self.depth), _carried_on(self.depth.flip(1)).flip(1)
        behind = torch.maximum(at_left, at_right)
        return replace(self, depth=torch.where(self.depth > 0, self.depth, behind))

    def hidden(self, points: Tensor, slack_m: float) -> Tensor:
        """Mask of the points of the world frame (..., 3) that the camera could not have seen, (...) bool.

        A point is hidden if the surface seen in its direction is nearer, by more than the slack, or if nothing is
        known there: no depth, or outside the image.
        """
        x, y, z = (points @ self.world_from_camera).unbind(dim=-1)
        column = (self.camera.fx * x / z + self.camera.cx).round().long()
        row = (self.camera.fy * y / z + self.camera.cy).round().long()
        height, width = self.depth.shape
        inside = (row >= 0) & (row < height) & (column >= 0) & (column < width) & (z > 0)
        seen = self.depth[row.clamp(0, height - 1), column.clamp(0, width - 1)]
        return ~inside | (seen == 0) | (seen < z - slack_m)


def _carried_on(depth: Tensor) -> Tensor:
    """(H, W) depth, where it is missing that of the nearest pixel to the left that has some; 0 without one."""
    column = torch.arange(depth.shape[1]).expand_as(depth)
    last = torch.where(depth > 0, column, -1).cummax(dim=1).values
    return torch.where(last >= 0, depth.gather(1, last.clamp(min=0)), 0.0)
