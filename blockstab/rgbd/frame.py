"""A colour image and a depth image of the same view, and the camera that took them."""

from __future__ import annotations

from dataclasses import dataclass

from torch import Tensor


@dataclass(frozen=True)
class Camera:
    """Pinhole intrinsics, pixels. OpenCV frame: x right, y down, z forward."""

    fx: float
    fy: float
    cx: float
    cy: float


@dataclass(frozen=True)
class Frame:
    """One RGB-D image.

    Args:
        name: the scene's name, for messages and output folders.
        color: (H, W, 3) uint8, RGB.
        depth: (H, W) float64, metres; 0 where the sensor gave none.
        camera: intrinsics of both images.
        label: (H, W) int64 instance ids, 0 = no label; None where the scene has none.
        background_ids: label ids of table, floor, walls.
        up_camera: (3,) float64 true up direction in the camera frame, where the scene knows it.
    """

    name: str
    color: Tensor
    depth: Tensor
    camera: Camera
    label: Tensor | None = None
    background_ids: tuple[int, ...] = ()
    up_camera: Tensor | None = None
