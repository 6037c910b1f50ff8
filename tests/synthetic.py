"""Photographs of blocks on a table, with the noise of a depth camera: what stands where is known exactly."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import torch
from PIL import Image
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.observation import given_ground, observe
from blockstab.proposals import Proposal
from blockstab.proposals.files import LabelFile
from blockstab.proposals.search_input import SearchInput, make_search_input
from blockstab.rgbd.frame import Camera, Frame
from blockstab.scene.builder import SceneBuilder
from blockstab.scene.inference import Rules
from blockstab.segments.hierarchy import build_hierarchy, split
from blockstab.segments.segmentation import Segmentation
from tests.worlds import Block, build

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
LEAST_PX = 40  # of a part
SHADES = (190, 60, 150, 100, 215)


@dataclass(frozen=True)
class Photograph:
    """An image and its truth: label 1 is the table, block k is k + 2; `boxes` are in the world frame."""

    frame: Frame
    boxes: Boxes


def photograph(
    *blocks: Block, turn_deg: float = 25.0, noise: float = NOISE, seed: int = 0, name: str = "blocks"
) -> Photograph:
    """Look down on blocks that stand around the middle of a table, turned together about the vertical.

    Args:
        turn_deg: of the table, so that the camera sees two sides of each block.
        noise: standard deviation of inverse depth, 1/m; seed: of the noise.
    """
    placed = placed_boxes(blocks, turn_deg)
    cos, sin = math.cos(math.radians(PITCH_DEG)), math.sin(math.radians(PITCH_DEG))
    turn = torch.tensor([[1.0, 0.0, 0.0], [0.0, -cos, -sin], [0.0, sin, -cos]], dtype=torch.float64)
    camera = Camera(FOCAL, FOCAL, (WIDTH - 1) / 2, (HEIGHT - 1) / 2)
    v, u = torch.meshgrid(torch.arange(HEIGHT).double(), torch.arange(WIDTH).double(), indexing="ij")
    rays = torch.stack([(u - camera.cx) / FOCAL, (v - camera.cy) / FOCAL, torch.ones_like(u)], dim=2) @ turn.T
    depth = torch.where(rays[..., 1] < 0, TABLE_Y / rays[..., 1], torch.inf)
    label = torch.full((HEIGHT, WIDTH), TABLE)
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


def view_of(photo: Photograph, proposal: Proposal | None = None) -> SearchInput:
    """The photograph made ready, its true labels as the first segmentation."""
    return make_search_input(observe(photo.frame, given_ground), proposal or LabelFile())


def builder(search_input: SearchInput, rules: Rules | None = None) -> SceneBuilder:
    """One that has understood nothing yet."""
    cloud, ground = search_input.observation.cloud, search_input.observation.ground
    return SceneBuilder(cloud, search_input.occlusion, ground, search_input.atoms, rules or Rules())


def over_split(search_input: SearchInput, rounds: int = 1) -> Segmentation:
    """The start with every object split in two, each part again, and so on, but into no specks: of these few points
    fit any box, so they tell nothing about a search."""
    hierarchy, background = build_hierarchy(search_input.atoms), search_input.start.segments[0]
    now = search_input.start
    for _ in range(rounds):
        for segment in now.segments:
            parts = split(segment, search_input.atoms, hierarchy) if segment != background else None
            if parts and min(int(search_input.atoms.pixels[list(part)].sum()) for part in parts) >= LEAST_PX:
                now = now.replace(now.segments.index(segment), parts)
    return now


def variants(search_input: SearchInput, count: int, seed: int = 0) -> list[Segmentation]:
    """Different segmentations, the start among them, by random splits and merges of objects."""
    generator, hierarchy = torch.Generator().manual_seed(seed), build_hierarchy(search_input.atoms)
    background, found = search_input.start.segments[0], [search_input.start]

    def drawn(below: int) -> int:
        return int(torch.randint(0, below, (1,), generator=generator))

    while len(found) < count:
        child = found[drawn(len(found))]
        pairs = [
            (a, b)
            for a, b in zip(*(side.tolist() for side in child.neighbours(search_input.atoms)), strict=True)
            if background not in (child.segments[a], child.segments[b])
        ]
        if drawn(3) == 0 and pairs:
            child = child.merge(*pairs[drawn(len(pairs))])
        else:
            index = 1 + drawn(len(child) - 1)
            parts = split(child.segments[index], search_input.atoms, hierarchy)
            child = child.replace(index, parts) if parts else child
        found += [child] * (child not in found)
    return found


def write_folder(frame: Frame, folder: Path) -> Path:
    """A scene folder that holds the frame."""
    folder.mkdir(parents=True)
    Image.fromarray(frame.color.numpy()).save(folder / "color.png")
    Image.fromarray((1000 * frame.depth).round().numpy().astype(np.uint16)).save(folder / "depth.png")
    assert frame.label is not None
    assert frame.up_camera is not None
    Image.fromarray(frame.label.numpy().astype(np.uint16)).save(folder / "label.png")
    meta = {
        **vars(frame.camera),
        "depth_unit": "mm",
        "up_camera": frame.up_camera.tolist(),
        "background_ids": list(frame.background_ids),
    }
    (folder / "meta.json").write_text(json.dumps(meta))
    return folder
