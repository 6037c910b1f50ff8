"""Made-up images, of which every cue is known, for the appearance features."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import torch
import torch.nn.functional as F
from torch import Tensor

from blockstab.boundaries import BoundaryMap
from blockstab.boundaries.cues import CUES
from blockstab.observation import Observation
from blockstab.rgbd.cloud import Cloud
from blockstab.rgbd.frame import Camera, Frame
from blockstab.rgbd.ground import Ground, world_from_camera
from blockstab.segments.plane_map import PlaneMap

HEIGHT, WIDTH, FOCAL = 60, 80, 80.0


def cells(count: int, generator: torch.Generator) -> Tensor:
    """(H, W) int64 labels from 1: the pixels nearest to each of some random points."""
    size = torch.tensor([HEIGHT, WIDTH], dtype=torch.float64)
    points = torch.rand(count, 2, dtype=torch.float64, generator=generator) * size
    row, column = torch.meshgrid(torch.arange(HEIGHT).double(), torch.arange(WIDTH).double(), indexing="ij")
    nearest = torch.cdist(torch.stack([row, column], dim=-1).view(-1, 2), points).argmin(dim=1)
    return torch.unique(nearest, return_inverse=True)[1].view(HEIGHT, WIDTH) + 1


def cluttered(label: Tensor, generator: torch.Generator, tilt: float = 0.3) -> Observation:
    """Every region has its own colour, depth and direction, and all of them have noise."""

    def drawn(*shape: int) -> Tensor:
        return torch.rand(*shape, dtype=torch.float64, generator=generator)

    axes = F.normalize(torch.tensor([[0, 1, 0], [1, 0, 0.4], [-0.4, 0, 1], [1, 0, 1], [1, 1, 1.0]]), dim=1)
    kind = torch.randint(len(axes), (int(label.max()) + 1,), generator=generator)
    normals = F.normalize(axes.double()[kind][label] + 0.3 * (drawn(*label.shape, 3) - 0.5), dim=-1)
    depth = 0.8 + drawn(len(kind))[label] + 0.05 * drawn(*label.shape)
    color = (200 * drawn(len(kind), 3)[label] + 55 * drawn(*label.shape, 3)).to(torch.uint8)
    planes = torch.where(drawn(*label.shape) < 0.7, kind[label] % 4, 0)
    return observed(depth, normals, color, planes, drawn(4, *label.shape), tilt, drawn(8, *label.shape))


def observed(
    depth: Tensor,
    normals: Tensor,
    color: Tensor,
    planes: Tensor,
    oriented: Tensor,
    tilt: float = 0.0,
    cues: Tensor | None = None,
) -> Observation:
    """What the given cues make up, for a camera that is turned down by `tilt`, radians.

    Args:
        depth: (H, W) metres, 0 where not measured; normals: (H, W, 3), of either sign, in the world frame.
        color: (H, W, 3) uint8; planes: (H, W) labels; oriented: (4, H, W) boundary strength;
            cues: (8, H, W) how strong each cue of an edge is, by default none.
    """
    height, width = depth.shape
    camera = Camera(FOCAL, FOCAL, (width - 1) / 2, (height - 1) / 2)
    angle = torch.tensor(tilt, dtype=torch.float64)
    up = torch.stack([angle * 0.0, -angle.cos(), -angle.sin()])
    ground = Ground(up, world_from_camera(up), None, 1.0)
    v, u = torch.meshgrid(torch.arange(height).double(), torch.arange(width).double(), indexing="ij")
    rays = torch.stack([(u - camera.cx) / FOCAL, (v - camera.cy) / FOCAL, torch.ones_like(u)], dim=-1)
    points = (rays * depth[..., None]) @ ground.world_from_camera.T
    away = (points * normals).sum(dim=-1, keepdim=True) > 0
    facing = torch.where(away, -normals, normals) * (depth > 0)[..., None]
    return Observation(
        frame=Frame("made", color, depth, camera),
        cloud=Cloud(points, facing, depth > 0, depth),
        ground=ground,
        boundary_map=BoundaryMap(oriented, oriented.amax(dim=0)),
        cues=torch.zeros(len(CUES), height, width) if cues is None else cues.float(),
        planes=cast(PlaneMap, SimpleNamespace(label=planes)),
        fine=torch.zeros_like(planes),
    )
