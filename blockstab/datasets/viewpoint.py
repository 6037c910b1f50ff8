"""Where the camera stands, and the room that it sees around the table."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.datasets.structures import about_up
from blockstab.rgbd.frame import Camera

KINECT = Camera(fx=525.0, fy=525.0, cx=319.5, cy=239.5)
HEIGHT_PX, WIDTH_PX = 480, 640
_NEAREST, _FURTHEST = 0.8, 1.4  # metres from the middle of the pile
_TRIES = 20  # viewpoints tried until every centre is in the picture
_TABLE_HEIGHT = 0.75  # metres above the floor
_SLAB = 0.02  # metres, half the thickness of table, floor and wall


@dataclass(frozen=True)
class View:
    """A camera in the table frame (right-handed, +y up, metres; the table is the plane y = 0).

    Args:
        camera: intrinsics of a picture of `HEIGHT_PX` by `WIDTH_PX` pixels.
        center: (3,) float64, where the camera is.
        camera_from_table: (3, 3) float64 rotation.
    """

    camera: Camera
    center: Tensor
    camera_from_table: Tensor

    def rays(self) -> Tensor:
        """The direction of each pixel in the table frame, (H, W, 3), a metre deep along the optical axis."""
        v, u = torch.meshgrid(
            torch.arange(HEIGHT_PX, dtype=torch.float64),
            torch.arange(WIDTH_PX, dtype=torch.float64),
            indexing="ij",
        )
        x, y = (u - self.camera.cx) / self.camera.fx, (v - self.camera.cy) / self.camera.fy
        return torch.stack([x, y, torch.ones_like(x)], dim=-1) @ self.camera_from_table

    def in_camera(self, boxes: Boxes) -> Boxes:
        """Boxes of the table frame in the camera frame."""
        return Boxes(boxes.center - self.center, boxes.rotation, boxes.half_extent).rotated(
            self.camera_from_table
        )

    def up_camera(self) -> Tensor:
        """The up direction in the camera frame, (3,)."""
        return self.camera_from_table[:, 1].clone()


def draw_view(generator: torch.Generator, pile: Boxes) -> View:
    """A viewpoint 0.8 to 1.4 m from the middle of a pile, looking down on it by 20 to 50 degrees.

    Among a few tries the first that has every box's centre in the picture is taken, or else the last.
    """
    middle = pile.center.mean(dim=0)
    for _ in range(_TRIES):
        share = torch.rand(4, generator=generator, dtype=torch.float64)
        distance = _NEAREST + (_FURTHEST - _NEAREST) * share[0]
        elevation = torch.deg2rad(20.0 + 30.0 * share[1])
        view = _look(
            middle, distance, elevation, 2 * math.pi * share[2], torch.deg2rad(10.0 * share[3] - 5.0)
        )
        x, y, z = view.in_camera(pile).center.unbind(dim=1)
        u, v = view.camera.fx * x / z + view.camera.cx, view.camera.fy * y / z + view.camera.cy
        if bool(((u > 0) & (u < WIDTH_PX - 1) & (v > 0) & (v < HEIGHT_PX - 1) & (z > 0)).all()):
            break
    return view


def furnish(generator: torch.Generator, view: View) -> Boxes:
    """Slabs in the table frame: the table, the floor and, two times in three, a wall behind the table."""
    share = torch.rand(6, generator=generator, dtype=torch.float64)
    half_table = 0.8 + 0.4 * share[:2]
    half_extent = [[float(half_table[0]), _SLAB, float(half_table[1])], [4.0, _SLAB, 4.0]]
    center = [[0.0, -_SLAB, 0.0], [0.0, -_TABLE_HEIGHT - _SLAB, 0.0]]
    yaw = [0.0, 0.0]
    if float(share[2]) < 2 / 3:
        away = math.atan2(-float(view.center[0]), -float(view.center[2])) + 0.6 * float(share[3]) - 0.3
        far = 0.9 + 0.8 * float(share[4])
        center.append([far * math.sin(away), 0.5, far * math.cos(away)])
        half_extent.append([4.0, 1.5, _SLAB])
        yaw.append(away)
    return Boxes(
        torch.tensor(center, dtype=torch.float64),
        about_up(torch.tensor(yaw, dtype=torch.float64)),
        torch.tensor(half_extent, dtype=torch.float64),
    )


def _look(middle: Tensor, distance: Tensor, elevation: Tensor, azimuth: Tensor, roll: Tensor) -> View:
    flat = elevation.cos()
    outward = torch.stack([flat * azimuth.cos(), elevation.sin(), flat * azimuth.sin()])
    right = torch.stack([azimuth.sin(), torch.zeros_like(azimuth), -azimuth.cos()])
    level = torch.stack([right, torch.linalg.cross(-outward, right), -outward])
    c, s = roll.cos(), roll.sin()
    tilt = torch.eye(3, dtype=torch.float64)
    tilt[0, 0], tilt[0, 1], tilt[1, 0], tilt[1, 1] = c, -s, s, c
    return View(KINECT, middle + distance * outward, tilt @ level)
