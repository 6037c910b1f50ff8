"""A parse made by hand: three things and a table, seen by a tilted camera."""

from __future__ import annotations

import math
from dataclasses import replace

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.geometry.convex_hulls import Polygons
from blockstab.parsing.parsed import Parsed
from blockstab.parsing.taken_away import Removal
from blockstab.rgbd.cloud import Cloud
from blockstab.rgbd.frame import Camera, Frame
from blockstab.rgbd.ground import Ground
from blockstab.scene.completion import Verdict
from blockstab.scene.types import Pairs, Scene
from blockstab.segments.segmentation import Segmentation
from blockstab.stability.balance import Balance
from blockstab.stability.support import GROUND, Supports, SupportType
from blockstab.stability.taking_apart import Reason

IDS = (7, 2, 40, 5)
TABLE, BLOCK, TOPPLING, LEANING = range(4)
TILT = math.radians(30)


def parsed_table() -> Parsed:
    """Table 7 is background, 2 stands on it, 40 topples off 2, 5 stands on the ground and leans on 2."""
    label = torch.zeros(24, 32, dtype=torch.int64)
    label[12:, :] = IDS[TABLE]
    label[8:16, 8:16] = IDS[BLOCK]
    label[2:8, 12:18] = IDS[TOPPLING]
    label[10:18, 18:26] = IDS[LEANING]
    color = torch.full((24, 32, 3), 90, dtype=torch.uint8)
    ground, scene = _ground(), _scene(label)
    depth = torch.where(label > 0, 1.0 + label.double() / 100, 0.0)
    return Parsed(
        name="table",
        frame=Frame("table", color, depth, Camera(30.0, 30.0, 15.5, 11.5)),
        cloud=_cloud(depth).rotated(ground.world_from_camera),
        label=label,
        scene=scene,
        ids=IDS,
        unary=torch.tensor([0.1, 0.2, 0.9, 0.4]),
        pairwise=torch.tensor([0.3, 0.7]),
        badness=torch.tensor([0.05, 0.1, 0.8, 0.3]),
        seen=scene.boxes,
        verdict=(Verdict.BACKGROUND, Verdict.STABLE, Verdict.UNSTABLE, Verdict.STABLE),
        unseen={},
        removal=Removal(
            {BLOCK: (TOPPLING, LEANING), TOPPLING: (), LEANING: ()},
            {(BLOCK, TOPPLING): Reason.SUPPORT, (BLOCK, LEANING): Reason.NEIGHBOUR},
            (TOPPLING, LEANING, BLOCK),
        ),
        judge="TrimmedSupports",
        energy=2.5,
        trace=(4.0, 2.5),
        seconds={"cloud": 0.25, "search": 1.5},
        potentials_name="svm",
        potentials_sha256="0123456789abcdef" * 4,
        seed=7,
    )


def with_scene(parsed: Parsed, **changes: object) -> Parsed:
    """The same parse with some fields of its scene replaced."""
    return replace(parsed, scene=replace(parsed.scene, **changes))


def _ground() -> Ground:
    cos, sin = math.cos(TILT), math.sin(TILT)
    turn = torch.tensor([[1.0, 0.0, 0.0], [0.0, -cos, -sin], [0.0, sin, -cos]], dtype=torch.float64)
    return Ground(up_camera=turn[1].clone(), world_from_camera=turn, height=-0.6, confidence=0.9)


def _scene(label: Tensor) -> Scene:
    pixels = torch.tensor([int((label == i).sum()) for i in IDS])
    center = torch.tensor(
        [
            [0, -0.62, -1],
            [-0.1, -0.5, -1],
            [0, -0.35, -1],
            [0.15, -0.52, -1],
        ],
        dtype=torch.float64,
    )
    half = torch.tensor(
        [
            [0.5, 0.02, 0.5],
            [0.1, 0.1, 0.1],
            [0.1, 0.05, 0.1],
            [0.05, 0.08, 0.1],
        ],
        dtype=torch.float64,
    )
    turn = torch.tensor([[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [-0.8, 0.0, 0.6]], dtype=torch.float64)
    boxes = Boxes(center, turn.repeat(4, 1, 1), half)
    first, second = torch.triu_indices(4, 4, 1)
    direction = torch.nn.functional.normalize(center[second] - center[first], dim=1)
    neighbours = torch.tensor([True, False, False, True, False, False])
    background = torch.tensor([True, False, False, False])
    stable = torch.tensor([True, True, False, True])
    margin = torch.tensor([math.inf, 0.04, -0.012, math.nan], dtype=torch.float64)
    supports = Supports(
        supporter=torch.tensor([TABLE, BLOCK, GROUND, BLOCK]),
        supported=torch.tensor([BLOCK, TOPPLING, LEANING, LEANING]),
        type=torch.tensor([SupportType.SURFACE, SupportType.PARTIAL, SupportType.SURFACE, SupportType.SIDE]),
        area=Polygons(torch.zeros(4, 1, 2).double(), torch.zeros(4, dtype=torch.int64)),
    )
    return Scene(
        segmentation=Segmentation(tuple(frozenset({i}) for i in range(4))),
        ground=_ground(),
        pixel_count=pixels,
        point_count=pixels,
        background=background,
        boxes=boxes,
        fit_mean=torch.full((4,), 0.003).double(),
        fit_variance=torch.full((4,), 1e-5).double(),
        visible_share=torch.full((4,), 0.9).double(),
        pairs=Pairs(first, second, torch.linspace(-0.01, 0.3, 6).double(), direction, neighbours),
        candidates=supports,
        supports=supports,
        balance=Balance(stable, stable, margin, center, center[:, [0, 2]]),
    )


def _cloud(depth: Tensor) -> Cloud:
    rows, columns = torch.meshgrid(torch.arange(24.0), torch.arange(32.0), indexing="ij")
    rays = torch.stack([(columns - 15.5) / 30, (rows - 11.5) / 30, torch.ones(24, 32)], dim=-1).double()
    points = rays * depth[..., None]
    return Cloud(points, torch.zeros_like(points), depth > 0, depth)
