"""Draw docs/figures/segmentation.png of scene folders: python docs/figures/segmentation.py SCENE SCENE ...

A row for each scene: the boundary map, the atoms, and what the learned stages make of them. The photographs
themselves are not shown, because their owners have not given them away.
"""

from __future__ import annotations

import sys
from pathlib import Path

import torch
from PIL import Image
from torch import Tensor

from blockstab.observation import estimated_ground, observe
from blockstab.rgbd.frame import read_scene
from models.stages.stages import silberman

TARGET = Path(__file__).with_suffix(".png")
GAP, WIDTH = 8, 400  # pixels between panels, and of each


def panels(folder: Path) -> list[Tensor]:
    """Boundary map, atoms and regions of one scene, (H, W, 3) uint8 each."""
    observation = observe(read_scene(folder), estimated_ground)
    strength = (255 * (1 - observation.boundary_map.strength)).round().to(torch.uint8)
    return [
        strength[..., None].expand(-1, -1, 3),
        colored(observation.fine),
        colored(silberman()(observation).label),
    ]


def colored(label: Tensor) -> Tensor:
    """(H, W, 3) uint8: a colour of its own for each region, black for none."""
    palette = torch.randint(60, 256, (int(label.max()) + 1, 3), generator=torch.Generator().manual_seed(4))
    palette[0] = 0
    return palette[label].to(torch.uint8)


def sheet(rows: list[list[Tensor]]) -> Image.Image:
    """All panels, each scaled to one width."""
    images = [[Image.fromarray(panel.contiguous().numpy()) for panel in row] for row in rows]
    scaled = [
        [i.resize((WIDTH, round(i.height * WIDTH / i.width)), Image.Resampling.NEAREST) for i in row]
        for row in images
    ]
    height = sum(row[0].height + GAP for row in scaled) - GAP
    whole = Image.new("RGB", (len(scaled[0]) * (WIDTH + GAP) - GAP, height), "white")
    top = 0
    for row in scaled:
        for k, panel in enumerate(row):
            whole.paste(panel, (k * (WIDTH + GAP), top))
        top += row[0].height + GAP
    return whole


if __name__ == "__main__":
    sheet([panels(Path(folder)) for folder in sys.argv[1:]]).quantize(128).save(TARGET, optimize=True)
