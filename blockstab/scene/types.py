"""One segmentation understood: boxes, gaps, supports, balance."""

from __future__ import annotations

from dataclasses import dataclass

from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.rgbd.ground import Ground
from blockstab.segments.segmentation import Segmentation
from blockstab.stability.balance import Balance
from blockstab.stability.support import Supports


@dataclass(frozen=True)
class Pairs:
    """P pairs of segments: every pair of a scene, once.

    Args:
        first, second: (P,) int64 segment indices, first < second.
        gap: (P,) metres between the boxes, negative where they overlap.
        direction: (P, 3) unit vectors from first to second, world frame.
        neighbours: (P,) bool, whether the two share a border in the image.
    """

    first: Tensor
    second: Tensor
    gap: Tensor
    direction: Tensor
    neighbours: Tensor


@dataclass(frozen=True)
class Scene:
    """A segmentation and what it means, in the world frame (+y up, origin at the camera, metres).

    Args:
        segmentation: N segments; every (N,) field below follows their order.
        ground: the ground plane and the world frame.
        pixel_count: (N,) int64 pixels of each segment.
        point_count: (N,) int64 pixels with depth.
        background: (N,) bool; table, floor, wall: always stable, without mass.
        boxes: N boxes, after the re-fit.
        fit_mean: (N,) metres, mean distance of a point to the nearest face.
        fit_variance: (N,) square metres.
        visible_share: (N,) share of points on faces that the camera sees.
        pairs: all pairs of boxes, with their gap.
        candidates: supports by nearness alone (the paper's "Neighbor" baseline).
        supports: those that stability needs (section 6).
        balance: which boxes stand, on `supports`.
    """

    segmentation: Segmentation
    ground: Ground
    pixel_count: Tensor
    point_count: Tensor
    background: Tensor
    boxes: Boxes
    fit_mean: Tensor
    fit_variance: Tensor
    visible_share: Tensor
    pairs: Pairs
    candidates: Supports
    supports: Supports
    balance: Balance

    def __len__(self) -> int:
        return len(self.segmentation)
