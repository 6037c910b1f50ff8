"""Occlusion: what the camera saw, and what was hidden from it."""

from __future__ import annotations

from dataclasses import dataclass

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
