"""Photographs of blocks on a table, with the noise of a depth camera: what stands where is known exactly."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.rgbd.frame import Camera, Frame
from blockstab.testing.worlds import Block, build

HEIGHT, WIDTH, FOCAL = 144, 192, 260.0  # pixels
TABLE_Y, DISTANCE = -0.55, 0.85  # metres: the table below the camera, the blocks' origin before it
PITCH_DEG = 33.0
TABLE = 1
NOISE = 5e-4  # 1/m, of inverse depth: half a millimetre at one metre

# Labels 2, 3, 4, 5: a tower of two beside a low box and a high one.
BLOCKS = (
    Block(-0.12, 0, 0.16, 0.08, d=0.12),
    Block(-0.12, 0.08, 0.12, 0.07, d=0.1),
    Block(0.06, 0, 0.12, 0.06, z=0.06, d=0.1),
    Block(0.13, 0, 0.08, 0.16, z=-0.1, d=0.08),
)
SHADES = (190, 60, 150, 100, 215)


@dataclass(frozen=True)
class Photograph:
    """An image and its truth: label 1 is the table, block k is k + 2; `boxes` are in the world frame."""

    frame: Frame
    boxes: Boxes


def photograph(
    *blocks: Block,
    turn_deg: float = 25.0,
    noise: float = NOISE,
    seed: int = 0,
    name: str = "blocks",
    finer: int = 1,
) -> Photograph:
    """Look down on blocks that stand around the middle of a table, turned together about the vertical.

    Args:
        turn_deg: of the table, so that the camera sees two sides of each block.
        noise: standard deviation of inverse depth, 1/m; seed: of the noise.
        finer: so many times as many rows and columns show the same.
    """
    placed = placed_boxes(blocks, turn_deg)
    cos, sin = math.cos(math.radians(PITCH_DEG)), math.sin(math.radians(PITCH_DEG))
    turn = torch.tensor([[1.0, 0.0, 0.0], [0.0, -cos, -sin], [0.0, sin, -cos]], dtype=torch.float64)
    height, width, focal = finer * HEIGHT, finer * WIDTH, finer * FOCAL
    camera = Camera(focal, focal, (width - 1) / 2, (height - 1) / 2)
    v, u = torch.meshgrid(torch.arange(height).double(), torch.arange(width).double(), indexing="ij")
    rays = torch.stack([(u - camera.cx) / focal, (v - camera.cy) / focal, torch.ones_like(u)], dim=2) @ turn.T
    depth = torch.where(rays[..., 1] < 0, TABLE_Y / rays[..., 1], torch.inf)
    label = torch.full((height, width), TABLE)
    for k in range(len(placed)):
        entry = _entry(placed[k : k + 1], rays)
        nearer = entry < depth
        depth, label = torch.where(nearer, entry, depth), torch.where(nearer, k + 2, label)
    random = torch.randn(depth.shape, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)
    depth = torch.where(depth < 4.0, 1 / (1 / depth + noise * random), 0.0)
    depth = (1000 * depth).round() / 1000  # a depth image holds whole millimetres
    label = torch.where(depth > 0, label, 0)
    # Stripes cut what is seen into atoms, so that a search has something to split.
    stripe = torch.where((u + 2 * v) % 24 < 12, 40, 0).long()
    color = torch.tensor([0, *SHADES])[label.clamp(max=len(SHADES))] + torch.where(label > TABLE, stripe, 0)
    background = (TABLE, *(k + 2 for k, block in enumerate(blocks) if block.fixed))
    frame = Frame(
        name,
        color[..., None].expand(-1, -1, 3).to(torch.uint8).contiguous(),
        depth,
        camera,
        label,
        background,
        turn[1],
    )
    return Photograph(frame, placed)


def placed_boxes(blocks: tuple[Block, ...], turn_deg: float) -> Boxes:
    """The blocks in the world frame of the photograph."""
    boxes, _ = build(*blocks)
    cos, sin = math.cos(math.radians(turn_deg)), math.sin(math.radians(turn_deg))
    turn = torch.tensor([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]], dtype=torch.float64)
    turned = boxes.rotated(turn)
    return replace(turned, center=turned.center + turned.center.new_tensor([0.0, TABLE_Y, -DISTANCE]))


def _entry(box: Boxes, rays: Tensor) -> Tensor:
    """(H, W) how many times its ray it is from the origin to the box; infinite where the ray misses it."""
    direction, start = rays @ box.rotation[0], -box.center[0] @ box.rotation[0]
    ends = torch.stack([(sign * box.half_extent[0] - start) / direction for sign in (-1, 1)])
    enter, leave = ends.amin(dim=0).amax(dim=-1), ends.amax(dim=0).amin(dim=-1)
    return torch.where((enter < leave) & (enter > 0), enter, torch.inf)
