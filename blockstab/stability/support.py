"""Candidate support relations: surface, partial, side (paper, section 5.2)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import IntEnum

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.boxes.separation import Separation
from blockstab.geometry.convex_hulls import Polygons, concatenate
from blockstab.rgbd.noise import KINECT
from blockstab.stability.area import footprints, lowest_corners, surface_areas, touching_edges
from blockstab.stability.loads import loads

GROUND = -1  # the ground plane, where a supporter's index is asked for


class SupportType(IntEnum):
    """The paper's three relations (Fig. 8 a-c)."""

    SURFACE = 0
    PARTIAL = 1
    SIDE = 2


@dataclass(frozen=True)
class Supports:
    """E support relations between N boxes.

    Args:
        supporter: (E,) int64 box indices; `GROUND` is the ground plane.
        supported: (E,) int64 box indices.
        type: (E,) int64 values of `SupportType`.
        area: E supporting areas on the ground plane, in (x, z) metres of the world frame.
    """

    supporter: Tensor
    supported: Tensor
    type: Tensor
    area: Polygons

    def __len__(self) -> int:
        return self.supporter.shape[0]

    def __getitem__(self, index: Tensor) -> Supports:
        return Supports(self.supporter[index], self.supported[index], self.type[index], self.area[index])

    def resting(self) -> tuple[Tensor, Tensor]:
        """Pairs (R,), (R,) of boxes of which the first rests on the second: on-top relations between boxes."""
        on_box = (self.supporter != GROUND) & (self.type != SupportType.SIDE)
        return self.supported[on_box], self.supporter[on_box]

    def split(self, start: Sequence[int]) -> list[Supports]:
        """The relations of the boxes `start[k]` to `start[k + 1] - 1`, for each k, which are counted from 0."""
        begin = torch.tensor(start)
        part = torch.searchsorted(begin, self.supported, right=True) - 1
        order = part.argsort(stable=True)
        first, sizes = begin[part[order]], torch.bincount(part, minlength=len(start) - 1).tolist()
        below = torch.where(self.supporter[order] == GROUND, GROUND, self.supporter[order] - first)
        columns = below, self.supported[order] - first, self.type[order], *vars(self.area[order]).values()
        parts = zip(*(torch.split(column, sizes) for column in columns), strict=True)
        return [Supports(below, above, kind, Polygons(*area)) for below, above, kind, *area in parts]


@dataclass(frozen=True)
class SupportRules:
    """Thresholds of section 5.2.

    Args:
        angle_deg: the paper's 20 degrees, for on-top against side and for partial against surface.
        touch_m, touch_per_square_m: boxes closer than `max(touch_m, touch_per_square_m * r ** 2)` touch,
            r being the distance from the camera: twice the depth step of a Kinect (Gupta et al. 2013).
    """

    angle_deg: float = 20.0
    touch_m: float = 0.02
    touch_per_square_m: float = 2 * KINECT.step

    def coarser(self, times: float) -> SupportRules:
        """The same for depth whose step is that many times as large."""
        return replace(self, touch_per_square_m=times * self.touch_per_square_m)

    def noise(self, boxes: Boxes) -> Tensor:
        """One depth step at each box, (N,) metres."""
        return self.touch_per_square_m / 2 * boxes.center.square().sum(dim=-1)

    def touch(self, boxes: Boxes) -> Tensor:
        """Touching distance of each box, (N,) metres."""
        return (self.touch_per_square_m * boxes.center.square().sum(dim=-1)).clamp(min=self.touch_m)


def candidate_supports(
    boxes: Boxes,
    pairs: tuple[Tensor, Tensor],
    apart: Separation,
    ground_height: Tensor,
    movable: Tensor,
    is_ground: Tensor,
    rules: SupportRules,
) -> Supports:
    """All relations that nearness allows (the paper's initialisation, its "Neighbor" baseline).

    On-top: the separating direction is within 20 degrees of the vertical, and the lower centre supports.
    Side: any other direction, both ways round, except from a box that itself rests on the one it would support.

    Args:
        boxes: N boxes in the world frame.
        pairs: (P,) first and (P,) second box of each pair that may touch.
        apart: gap and direction of those pairs.
        ground_height: (N,) height of the ground under each box, metres.
        movable: (N,) bool; the rest is background, which is never supported.
        is_ground: (N,) bool; boxes that are the ground plane itself, whose part `GROUND` plays.
    """
    touch = rules.touch(boxes)
    near = apart.gap < torch.maximum(touch[pairs[0]], touch[pairs[1]])
    near &= ~(is_ground[pairs[0]] | is_ground[pairs[1]])
    first, second, direction = pairs[0][near], pairs[1][near], apart.direction[near]
    upright = direction[:, 1].abs() > math.cos(math.radians(rules.angle_deg))
    higher = boxes.center[second, 1] >= boxes.center[first, 1]
    lower_box, upper_box = (
        torch.where(higher, first, second)[upright],
        torch.where(higher, second, first)[upright],
    )
    shadows = footprints(boxes)
    top = _on_top(boxes, shadows, lower_box, upper_box, rules)
    floor = _on_floor(boxes, shadows, ground_height, touch, rules)
    top, floor = top[movable[top.supported]], floor[movable[floor.supported]]
    carried = loads(*top.resting(), len(boxes))
    aside, beside = (
        torch.cat([first[~upright], second[~upright]]),
        torch.cat([second[~upright], first[~upright]]),
    )
    possible = movable[beside] & ~carried[beside, aside]
    aside, beside = aside[possible], beside[possible]
    side = Supports(
        aside, beside, torch.full_like(aside, SupportType.SIDE), touching_edges(boxes, aside, beside)
    )
    return join([floor, top, side])


def join(parts: list[Supports]) -> Supports:
    """One set of relations from several; without any, an empty one."""
    if not parts:
        none = torch.empty(0, dtype=torch.long)
        return Supports(none, none, none, Polygons(torch.empty(0, 1, 2, dtype=torch.float64), none))
    return Supports(
        torch.cat([p.supporter for p in parts]),
        torch.cat([p.supported for p in parts]),
        torch.cat([p.type for p in parts]),
        concatenate([p.area for p in parts]),
    )


def tilt(normals: Tensor) -> Tensor:
    """Angle of unit vectors (..., 3) to the vertical, sign-free, radians."""
    return torch.acos(normals[..., 1].abs().clamp(max=1.0))


def top_normal(boxes: Boxes) -> Tensor:
    """The box axis nearest to +y, pointing up, (N, 3)."""
    axes = boxes.rotation.transpose(1, 2)
    best = axes[torch.arange(len(boxes)), axes[..., 1].abs().argmax(dim=1)]
    return best * torch.where(best[:, 1:2] < 0, -1.0, 1.0)


def _on_top(boxes: Boxes, shadows: Polygons, lower: Tensor, upper: Tensor, rules: SupportRules) -> Supports:
    limit = math.radians(rules.angle_deg)
    up = top_normal(boxes)
    between = torch.acos((up[lower] * up[upper]).sum(dim=-1).clamp(-1.0, 1.0))
    partial = (between > limit) & ((tilt(up[lower]) - tilt(up[upper])).abs() > limit)
    over = surface_areas(shadows, lower, upper)
    edges = touching_edges(boxes, lower[partial], upper[partial])
    whole, tilted = over[~partial], edges
    kind = torch.cat(
        [
            torch.full_like(lower[~partial], SupportType.SURFACE),
            torch.full_like(lower[partial], SupportType.PARTIAL),
        ]
    )
    found = Supports(
        torch.cat([lower[~partial], lower[partial]]),
        torch.cat([upper[~partial], upper[partial]]),
        kind,
        concatenate([whole, tilted]),
    )
    return found[found.area.count > 0]


def _on_floor(
    boxes: Boxes, shadows: Polygons, ground_height: Tensor, touch: Tensor, rules: SupportRules
) -> Supports:
    bottom = boxes.corners()[..., 1].amin(dim=1)
    touching = (bottom < ground_height + touch).nonzero()[:, 0]
    standing = tilt(top_normal(boxes))[touching] < math.radians(rules.angle_deg)
    flat, tilted = touching[standing], touching[~standing]
    area = concatenate([shadows[flat], lowest_corners(boxes[tilted], touch[tilted])])
    supported = torch.cat([flat, tilted])
    kind = torch.cat(
        [torch.full_like(flat, SupportType.SURFACE), torch.full_like(tilted, SupportType.PARTIAL)]
    )
    return Supports(torch.full_like(supported, GROUND), supported, kind, area)
