"""A 3-D point and a normal for every pixel with depth."""

from __future__ import annotations

from dataclasses import dataclass

from torch import Tensor


@dataclass(frozen=True)
class Cloud:
    """An organised point cloud; the camera centre is the origin, in the camera frame and in the world frame alike.

    Args:
        points: (H, W, 3) float64, metres; zero where invalid.
        normals: (H, W, 3) float64 unit vectors towards the camera; zero where unknown.
        valid: (H, W) bool, where the sensor measured depth.
        depth: (H, W) float64, metres along the optical axis; 0 where invalid. Rotation does not change it.
    """

    points: Tensor
    normals: Tensor
    valid: Tensor
    depth: Tensor

    def rotated(self, rotation: Tensor) -> Cloud:
        """The same cloud in a frame turned by `rotation` (3, 3)."""
        return Cloud(self.points @ rotation.T, self.normals @ rotation.T, self.valid, self.depth)
