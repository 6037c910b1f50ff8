"""Pictures of axis-parallel blocks on a table, without noise: what each pixel sees is known exactly."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.observation import Observation, observation_of
from blockstab.rgbd.cloud import Cloud, cloud_from_frame
from blockstab.rgbd.frame import Camera, Frame
from blockstab.rgbd.ground import Ground

HEIGHT, WIDTH, FOCAL = 240, 320, 290.0
TABLE_Y = -0.6  # metres below the camera
TABLE = 1

Block = tuple[
    Sequence[float], Sequence[float]
]  # least and greatest x, height above the table, distance (metres)

# To the left and right of the middle, so that no side face is seen at a grazing angle.
APART: tuple[Block, ...] = (((-0.4, 0, 0.6), (-0.25, 0.15, 0.75)), ((0.2, 0, 0.6), (0.35, 0.1, 0.72)))
STACK: tuple[Block, ...] = (((-0.2, 0, 0.55), (0.15, 0.08, 0.75)), ((-0.1, 0.08, 0.6), (0.1, 0.2, 0.7)))


@dataclass(frozen=True)
class Picture:
    """An image and its truth: label 1 is the table, block k is k + 2."""

    frame: Frame
    cloud: Cloud
    ground: Ground

    @property
    def observation(self) -> Observation:
        """All that is computed of it once."""
        return observation_of(self.frame, self.cloud, self.ground)


def picture(blocks: Sequence[Block], pitch_deg: float = 40.0) -> Picture:
    """Look at the blocks from above, the camera turned down by `pitch_deg`; points are in the world frame."""
    cos, sin = math.cos(math.radians(pitch_deg)), math.sin(math.radians(pitch_deg))
    turn = torch.tensor([[1.0, 0.0, 0.0], [0.0, -cos, -sin], [0.0, sin, -cos]], dtype=torch.float64)
    v, u = torch.meshgrid(torch.arange(HEIGHT).double(), torch.arange(WIDTH).double(), indexing="ij")
    camera = Camera(FOCAL, FOCAL, (WIDTH - 1) / 2, (HEIGHT - 1) / 2)
    rays = torch.stack([(u - camera.cx) / FOCAL, (v - camera.cy) / FOCAL, torch.ones_like(u)], dim=2) @ turn.T
    depth = torch.where(rays[..., 1] < 0, TABLE_Y / rays[..., 1], torch.inf)
    label = torch.full((HEIGHT, WIDTH), TABLE)
    for number, (least, greatest) in enumerate(blocks):
        low = torch.tensor([least[0], least[1] + TABLE_Y, -greatest[2]], dtype=torch.float64)
        high = torch.tensor([greatest[0], greatest[1] + TABLE_Y, -least[2]], dtype=torch.float64)
        enter = torch.minimum(low / rays, high / rays).amax(dim=2)
        leave = torch.maximum(low / rays, high / rays).amin(dim=2)
        seen = (enter < leave) & (enter > 0) & (enter < depth)
        depth, label = torch.where(seen, enter, depth), torch.where(seen, number + 2, label)
    depth = torch.where(depth < 3.0, depth, 0.0)
    label = torch.where(depth > 0, label, 0)
    color = _paint(label)
    frame = Frame("blocks", color, depth, camera, label, (TABLE,), turn[1].clone())
    return Picture(frame, cloud_from_frame(frame).rotated(turn), Ground(turn[1].clone(), turn, TABLE_Y, 1.0))


def _paint(label: Tensor) -> Tensor:
    """Wood for the table, and stripes on every block, as strong as any edge between two things."""
    columns = torch.arange(WIDTH).expand(HEIGHT, WIDTH)
    stripe = torch.where((columns // 12) % 2 == 0, 210, 60)
    grey = torch.where(label > TABLE, stripe, 150)
    return grey[..., None].expand(-1, -1, 3).to(torch.uint8).contiguous()
