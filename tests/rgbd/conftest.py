"""A scene folder to spoil, and rooms whose depth is known in closed form."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from PIL import Image
from torch import Tensor

from blockstab.rgbd.frame import Camera, Frame


@dataclass(frozen=True)
class SceneFolder:
    """A good scene of 8 x 6 pixels, 1 m deep, until one of its files is replaced."""

    path: Path

    def image(self, name: str, pixels: np.ndarray, **options: Any) -> Path:
        Image.fromarray(pixels).save(self.path / name, **options)
        return self.path / name

    def meta(self, **changes: Any) -> Path:
        """Write meta.json with keys changed, or left out where the value is Ellipsis."""
        values = {"fx": 10.0, "fy": 10.0, "cx": 3.5, "cy": 2.5, "depth_unit": "mm"} | changes
        text = json.dumps({key: value for key, value in values.items() if value is not ...})
        (self.path / "meta.json").write_text(text)
        return self.path / "meta.json"


@pytest.fixture
def scene(tmp_path: Path) -> SceneFolder:
    folder = SceneFolder(tmp_path)
    folder.image("color.png", np.arange(6 * 8 * 3, dtype=np.uint8).reshape(6, 8, 3))
    folder.image("depth.png", np.full((6, 8), 1000, dtype=np.uint16))
    folder.meta()
    return folder


@dataclass(frozen=True)
class View:
    """A frame of planes of which all is known.

    Args:
        frame: depth of what is nearest along each ray; 0 where there is nothing.
        up: (3,) true up direction in the camera frame.
        normals: (H, W, 3) of the plane seen, towards the camera; zero where there is nothing.
    """

    frame: Frame
    up: Tensor
    normals: Tensor


@pytest.fixture
def look() -> Callable[..., View]:
    return _look


def _look(
    surfaces: dict[tuple[float, float, float], float],
    down_deg: float = 0.0,
    roll_deg: float = 0.0,
    noise: float = 0.0,
    seed: int = 0,
) -> View:
    """See half spaces with a camera of 320 x 240 pixels.

    Args:
        surfaces: normal in the level camera's frame (x right, y down, z forward), and distance in metres.
        down_deg, roll_deg: how the camera is turned from level.
        noise: standard deviation of inverse depth, 1/m: at depth z that is `noise` z^2 metres.
        seed: of the noise.
    """
    down, roll = math.radians(down_deg), math.radians(roll_deg)
    pitch = [[1, 0, 0], [0, math.cos(down), -math.sin(down)], [0, math.sin(down), math.cos(down)]]
    turn = [[math.cos(roll), -math.sin(roll), 0], [math.sin(roll), math.cos(roll), 0], [0, 0, 1]]
    rotation = torch.tensor(turn, dtype=torch.float64) @ torch.tensor(pitch, dtype=torch.float64)

    camera = Camera(262.5, 262.5, 159.5, 119.5)
    row, column = torch.meshgrid(torch.arange(240.0).double(), torch.arange(320.0).double(), indexing="ij")
    x, y = (column - camera.cx) / camera.fx, (row - camera.cy) / camera.fy
    rays = torch.stack([x, y, torch.ones_like(x)], dim=-1)

    planes = torch.tensor(list(surfaces), dtype=torch.float64)
    planes = planes / planes.norm(dim=1, keepdim=True) @ rotation.T
    inverse, seen = (-(rays @ planes.T) / torch.tensor(list(surfaces.values())).double()).max(dim=-1)
    hit = inverse > 0.05
    noisy = inverse + noise * torch.randn(
        inverse.shape, generator=torch.Generator().manual_seed(seed), dtype=torch.float64
    )
    depth = torch.where(hit, 1.0 / noisy, 0.0)
    color = torch.zeros(240, 320, 3, dtype=torch.uint8)
    up = rotation @ torch.tensor([0.0, -1.0, 0.0], dtype=torch.float64)
    return View(Frame("planes", color, depth, camera), up, planes[seen] * hit[..., None])
