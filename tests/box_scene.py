"""Scenes made of boxes alone: one atom for each box, all boxes neighbours in the image, and all looking alike."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.boxes.separation import separation
from blockstab.features.appearance.pair_columns import APPEARANCE_COLUMNS
from blockstab.rgbd.ground import Ground
from blockstab.scene.types import Pairs, Scene
from blockstab.segments.segmentation import Pair, Segmentation
from blockstab.testing.worlds import Block, build, judge_boxes

FIT_MEAN, FIT_VARIANCE, VISIBLE = 0.002, 1e-6, 0.75


def alike(pairs: Sequence[Pair]) -> Tensor:
    """The appearance of pairs that look the same in every way, (P, 51)."""
    return torch.zeros(len(pairs), len(APPEARANCE_COLUMNS), dtype=torch.float64)


def scene_of(*blocks: Block, pixels: Sequence[int] | None = None) -> Scene:
    """What the paper's rule makes of the blocks; each has 10 pixels more than the one before, or `pixels`."""
    return scene_of_boxes(*build(*blocks), pixels)


def scene_of_boxes(boxes: Boxes, movable: Tensor, pixels: Sequence[int] | None = None) -> Scene:
    """The same for boxes in the world frame."""
    n = len(boxes)
    first, second = torch.triu_indices(n, n, offset=1)
    apart = separation(boxes, first, second)
    verdict = judge_boxes(boxes, movable)
    size = torch.tensor(pixels) if pixels is not None else 100 + 10 * torch.arange(n)
    up = torch.tensor([0.0, 1.0, 0.0], dtype=torch.float64)
    near = torch.ones(len(first), dtype=torch.bool)
    return Scene(
        segmentation=Segmentation(tuple(frozenset({k}) for k in range(n))),
        ground=Ground(up, torch.eye(3, dtype=torch.float64), 0.0, 1.0),
        pixel_count=size,
        point_count=size,
        background=~movable,
        boxes=boxes,
        fit_mean=torch.full((n,), FIT_MEAN, dtype=torch.float64),
        fit_variance=torch.full((n,), FIT_VARIANCE, dtype=torch.float64),
        visible_share=torch.full((n,), VISIBLE, dtype=torch.float64),
        pairs=Pairs(first, second, apart.gap, apart.direction, near),
        candidates=verdict.candidates,
        supports=verdict.supports,
        balance=verdict.balance,
    )
