"""Table, floor and walls: segments that need no support and have no mass."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.rgbd.noise import KINECT


@dataclass(frozen=True)
class BackgroundRules:
    """Rules for what counts as background.

    A segment is background if at least `plane_share` of its points lie in the ground plane or lower; if as many
    lie in one plane that is a wall larger than `wall_m`, or covers more than `image_share` of the image; or if it
    lies deeper than `below_m` below the ground.

    Args:
        plane_m, plane_per_square_m: how far from the plane its points may lie, with r the distance from the
            camera: `plane_m + plane_per_square_m * r ** 2`.
        angle_deg: how far from vertical a wall may be.
        ground_m: how far above the ground plane a point of it may lie; `plane_per_square_m * r ** 2` where that
            is more.
    """

    plane_share: float = 0.8
    plane_m: float = 0.008
    plane_per_square_m: float = KINECT.step
    angle_deg: float = 10.0
    ground_m: float = 0.01
    below_m: float = 0.05
    wall_m: float = 1.5
    image_share: float = 0.2

    def coarser(self, times: float) -> BackgroundRules:
        """The same for depth whose step is that many times as large."""
        return replace(self, plane_per_square_m=times * self.plane_per_square_m)


def is_background(
    boxes: Boxes, points: Tensor, count: Tensor, share: Tensor, ground_height: float, rules: BackgroundRules
) -> tuple[Tensor, Tensor]:
    """Tell background segments from objects by their boxes and points.

    Args:
        boxes: N boxes in the world frame; points: (N, P, 3) their points; count: (N,) how many are real.
        share: (N,) of the image that each covers.

    Returns:
        (N,) bool, background; (N,) bool, lies in the ground plane (whether or not it is background).
    """
    n = torch.arange(len(boxes))
    present = torch.arange(points.shape[1]) < count[:, None]
    thin = boxes.half_extent.argmin(dim=1)
    normal = boxes.rotation[n, :, thin]
    height = (points @ normal[..., None])[..., 0]
    middle = height.masked_fill(~present, float("nan")).nanmedian(dim=1).values
    allowed = rules.plane_m + rules.plane_per_square_m * points.square().sum(dim=-1)
    near = ((height - middle[:, None]).abs() < allowed) & present
    planar = near.sum(dim=1) >= rules.plane_share * count
    slope = normal[:, 1].abs()
    level = points[..., 1].masked_fill(~present, float("nan")).nanmedian(dim=1).values
    # By the points, not by the box: a strip of table at the border of an image has a box of any direction.
    reach = (rules.plane_per_square_m * points.square().sum(dim=-1)).clamp(min=rules.ground_m)
    low = (points[..., 1] - ground_height < reach) & present
    at_ground = low.sum(dim=1) >= rules.plane_share * count
    # What is seen beyond the edge of a table, and lower, does not stand on the table.
    below = level < ground_height - rules.below_m
    wall = (slope < math.sin(math.radians(rules.angle_deg))) & (
        2 * boxes.half_extent.amax(dim=1) > rules.wall_m
    )
    lies_in_ground = (level - ground_height).abs() < 2 * rules.ground_m
    return below | at_ground | planar & (wall | (share > rules.image_share)), lies_in_ground
