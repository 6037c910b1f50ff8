"""Viewpoints of the camera."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.rgbd.frame import Camera
from blockstab.simulation.physics.solids import Pile
from blockstab.simulation.sensors import Sensor

Setting = Literal["table", "desk", "shelf", "room"]

_TRIES = 20  # viewpoints tried until all of the pile is in the picture
_CLEARANCE = 0.5  # metres between camera and pile, as structured light needs


class _Stance(NamedTuple):
    """Limits on the viewpoint of a camera.

    Args:
        down_deg: how far it looks down, least and most.
        side_deg: how far from straight from the front it stands at most, to either side.
        span: of the picture's half width, that the pile takes, least and most.
        inside: share of the corners of the pile's boxes that must be in the picture.
        furthest: from the middle of the pile, metres, where it need not be further to be clear of it.
    """

    down_deg: tuple[float, float]
    side_deg: float
    span: tuple[float, float] = (0.35, 0.95)
    inside: float = 1.0
    furthest: float = 1.4


_STANCES = {
    "table": _Stance((20.0, 50.0), 180.0),
    # A desk fills the picture, whose border cuts through some of what is on it.
    "desk": _Stance((30.0, 65.0), 180.0, span=(0.5, 1.6), inside=0.7),
    "shelf": _Stance((5.0, 25.0), 35.0),
    "room": _Stance((20.0, 40.0), 180.0, span=(0.6, 1.0), inside=0.85, furthest=3.5),
}


@dataclass(frozen=True)
class Viewpoint:
    """A camera in the table frame (right-handed, +y up, metres; the table is the plane y = 0).

    Args:
        camera: intrinsics.
        size: height and width of the picture, pixels.
        center: (3,) float64, where the camera is.
        camera_from_table: (3, 3) float64 rotation.
    """

    camera: Camera
    size: tuple[int, int]
    center: Tensor
    camera_from_table: Tensor

    def rays(self) -> Tensor:
        """The direction of each pixel in the table frame, (H, W, 3), a metre deep along the optical axis."""
        rows, columns = (torch.arange(length, dtype=torch.float64) for length in self.size)
        return self.rays_at(*torch.meshgrid(rows, columns, indexing="ij"))

    def rays_at(self, row: Tensor, column: Tensor) -> Tensor:
        """The directions (..., 3) of points of the picture, pixels (...), in the table frame."""
        x, y = (column - self.camera.cx) / self.camera.fx, (row - self.camera.cy) / self.camera.fy
        return torch.stack([x, y, torch.ones_like(x)], dim=-1) @ self.camera_from_table

    def pixels(self, points: Tensor) -> Tensor:
        """Column, row and depth (..., 3) of points (..., 3) of the table frame; pixels and metres."""
        x, y, z = ((points - self.center) @ self.camera_from_table.T).unbind(dim=-1)
        column, row = self.camera.fx * x / z + self.camera.cx, self.camera.fy * y / z + self.camera.cy
        return torch.stack([column, row, z], dim=-1)

    def in_camera(self, boxes: Boxes) -> Boxes:
        """Boxes of the table frame in the camera frame."""
        return Boxes(boxes.center - self.center, boxes.rotation, boxes.half_extent).rotated(
            self.camera_from_table
        )

    def up_camera(self) -> Tensor:
        """The up direction in the camera frame, (3,)."""
        return self.camera_from_table[:, 1].clone()


def draw_view(
    generator: torch.Generator,
    pile: Pile,
    sensor: Sensor,
    setting: Setting = "table",
) -> Viewpoint:
    """A viewpoint at least half a metre from a pile, which spans a third of the picture or more, hardly rolled.

    On a table the camera looks down by 20 to 50 degrees, on a desk by 30 to 65, from any side. A shelf is open
    towards +z: there the camera looks down by 5 to 25 degrees, within 35 degrees of straight from the front. Into a
    room it looks down by 20 to 40. Among a few tries the first that has all of the pile in the picture, or most of
    it on a desk and in a room, is taken, or else the last.
    """
    corners, size = pile.boxes().corners().flatten(0, 1), (sensor.height_px, sensor.width_px)
    middle = (corners.amin(dim=0) + corners.amax(dim=0)) / 2
    reach = (corners - middle).norm(dim=1).amax()
    stance = _STANCES[setting]
    (low, high), (narrow, wide) = stance.down_deg, stance.span
    for _ in range(_TRIES):
        share = torch.rand(4, generator=generator, dtype=torch.float64)
        span = (narrow + (wide - narrow) * share[0]) * sensor.width_px / 2
        wanted = (reach * sensor.camera.fx / span).clamp(max=stance.furthest)
        distance = torch.maximum(wanted, reach + _CLEARANCE)
        elevation = torch.deg2rad(low + (high - low) * share[1])
        azimuth = math.pi / 2 + torch.deg2rad(stance.side_deg * (2.0 * share[2] - 1.0))
        roll = torch.deg2rad(10.0 * share[3] - 5.0)
        view = _look(sensor.camera, size, middle, distance, elevation, azimuth, roll)
        column, row, depth = view.pixels(corners).unbind(dim=1)
        inside = (row > 0) & (row < size[0] - 1) & (column > 0) & (column < size[1] - 1) & (depth > 0)
        if float(inside.double().mean()) >= stance.inside:
            break
    return view


def _look(
    camera: Camera,
    size: tuple[int, int],
    middle: Tensor,
    distance: Tensor,
    elevation: Tensor,
    azimuth: Tensor,
    roll: Tensor,
) -> Viewpoint:
    flat = elevation.cos()
    outward = torch.stack([flat * azimuth.cos(), elevation.sin(), flat * azimuth.sin()])
    right = torch.stack([azimuth.sin(), torch.zeros_like(azimuth), -azimuth.cos()])
    level = torch.stack([right, torch.linalg.cross(-outward, right), -outward])
    c, s = roll.cos(), roll.sin()
    tilt = torch.eye(3, dtype=torch.float64)
    tilt[0, 0], tilt[0, 1], tilt[1, 0], tilt[1, 1] = c, -s, s, c
    return Viewpoint(camera, size, middle + distance * outward, tilt @ level)
