"""The 63 features of two neighbouring segments (paper, Table 1, bottom): 12 of their boxes, 51 of how they look."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import torch
from torch import Tensor

from blockstab.features.appearance.pair_columns import APPEARANCE_COLUMNS
from blockstab.features.formulas import columns_of
from blockstab.features.unary import UNSUPPORTED_M, intersections
from blockstab.scene.types import Scene
from blockstab.segments.segmentation import Pair
from blockstab.stability.area import on_ground

_MIN_VOLUME = 1e-6  # cubic metres


class _Measured(NamedTuple):
    """Measurements of M pairs in a scene of N segments; metres and cubic metres."""

    larger: Tensor  # (M,)
    smaller: Tensor  # (M,)
    depth: Tensor  # (M,) of the overlap of their boxes
    apart: Tensor  # (M,) distance of the centres
    kind: Tensor  # (M,) of support between them, -1 for none
    offset: Tensor  # (M,) of the centre of mass from the middle of its support area
    volume: Tensor  # (N,)
    intersections: Tensor  # (N,)
    stable: Tensor  # (N,) bool


_FORMULAS: dict[str, Callable[[_Measured], Tensor]] = {
    "intersections_larger": lambda m: m.intersections[m.larger],
    "intersections_smaller": lambda m: m.intersections[m.smaller],
    "overlap_relative_larger": lambda m: m.depth / m.volume[m.larger],
    "overlap_relative_smaller": lambda m: m.depth / m.volume[m.smaller],
    "stable_larger": lambda m: m.stable[m.larger],
    "stable_smaller": lambda m: m.stable[m.smaller],
    "support_surface": lambda m: m.kind == 0,
    "support_partial": lambda m: m.kind == 1,
    "support_side": lambda m: m.kind == 2,
    "supporting": lambda m: m.kind >= 0,
    "center_distance": lambda m: m.apart,
    "offset_from_support": lambda m: m.offset,
}
BOX_COLUMNS = tuple(_FORMULAS)
PAIRWISE_COLUMNS = (*BOX_COLUMNS, *APPEARANCE_COLUMNS)


def neighbour_pairs(scene: Scene) -> tuple[Tensor, Tensor]:
    """The pairs that the pairwise potential judges: neighbouring objects, the larger segment first, (M,) and (M,).

    Where two segments have equally many pixels, the one that comes first in the scene counts as the larger.
    """
    judged = _judged(scene)
    first, second = scene.pairs.first[judged], scene.pairs.second[judged]
    in_order = scene.pixel_count[first] >= scene.pixel_count[second]
    return torch.where(in_order, first, second), torch.where(in_order, second, first)


def _judged(scene: Scene) -> Tensor:
    """Numbers of those pairs among all of a scene."""
    pairs, movable = scene.pairs, ~scene.background
    return (pairs.neighbours & movable[pairs.first] & movable[pairs.second]).nonzero()[:, 0]


def pairs_of(scene: Scene) -> list[Pair]:
    """The segments of each pair of `neighbour_pairs(scene)`."""
    segments = scene.segmentation.segments
    larger, smaller = neighbour_pairs(scene)
    return [(segments[a], segments[b]) for a, b in zip(larger.tolist(), smaller.tolist(), strict=True)]


def pairwise_features(scene: Scene, appearance: Tensor) -> Tensor:
    """Features of each pair of `neighbour_pairs(scene)`, (M, 63) float64, in the order of `PAIRWISE_COLUMNS`.

    Args:
        appearance: (M, 51) how the pairs of `pairs_of(scene)` look, in the order of `APPEARANCE_COLUMNS`.
    """
    return torch.cat([box_features(scene), appearance], dim=1)


def box_features(scene: Scene) -> Tensor:
    """Box features of each pair of `neighbour_pairs(scene)`, (M, 12) float64, in the order of `BOX_COLUMNS`."""
    larger, smaller = neighbour_pairs(scene)
    kind, offset = _support_between(scene, larger, smaller)
    measured = _Measured(
        larger,
        smaller,
        (-scene.pairs.gap[_judged(scene)]).clamp(min=0.0),
        (scene.boxes.center[larger] - scene.boxes.center[smaller]).norm(dim=-1),
        kind,
        offset,
        scene.boxes.volume().clamp(min=_MIN_VOLUME),
        intersections(scene)[0],
        scene.balance.stable,
    )
    return columns_of(_FORMULAS, measured)


def _support_between(scene: Scene, larger: Tensor, smaller: Tensor) -> tuple[Tensor, Tensor]:
    """The type of support between the two, (M,), -1 for none; and, (M,) metres, how far the centre of mass of the
    supported one lies from the centre of its support area, horizontally, 0 without support."""
    center, area_center = on_ground(scene.balance.mass_center), scene.balance.support_center
    offset = (center - area_center).norm(dim=-1).nan_to_num(UNSUPPORTED_M).clamp(max=UNSUPPORTED_M)
    up, down = _kind(scene, larger, smaller), _kind(scene, smaller, larger)
    offset_between = torch.where(up >= 0, offset[smaller], torch.where(down >= 0, offset[larger], 0.0))
    return torch.where(up >= 0, up, down), offset_between


def _kind(scene: Scene, below: Tensor, above: Tensor) -> Tensor:
    """The type of the support of `above` (M,) by `below` (M,), -1 where there is none."""
    n, supports = len(scene), scene.supports
    key = supports.supporter * n + supports.supported  # negative for the ground
    order = key.argsort(stable=True)
    wanted = below * n + above
    # The last of several between the same two.
    place = torch.searchsorted(key[order], wanted, right=True) - 1
    known = torch.cat([key[order], key.new_full((1,), -1)])[place]
    return torch.where(known == wanted, torch.cat([supports.type[order], key.new_full((1,), -1)])[place], -1)
