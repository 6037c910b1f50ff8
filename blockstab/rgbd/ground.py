"""Which way is up, and how high the ground is (silberman.md 1.5, 1.7)."""

from __future__ import annotations

from dataclasses import dataclass

from torch import Tensor


@dataclass(frozen=True)
class Ground:
    """The ground plane, as the camera sees it.

    Args:
        up_camera: (3,) float64 unit vector, camera frame.
        world_from_camera: (3, 3) float64 rotation, det +1, that takes `up_camera` to +y.
        height: y of the ground plane in the world frame, metres; None where no horizontal surface was found.
        confidence: between 0 and 1.
    """

    up_camera: Tensor
    world_from_camera: Tensor
    height: float | None
    confidence: float
