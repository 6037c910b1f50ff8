"""Support by something that nobody saw: where under a box it can stand, and whether it would do."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.geometry.convex_hulls import Polygons, concatenate, hull, signed_distance
from blockstab.stability.area import footprints, on_ground
from blockstab.stability.unseen import Hidden

_GRID = 9  # columns along either side of the rectangle around a box's shadow
_LEVELS = 6  # at which a column is looked at
_HIDDEN_SHARE = 0.9  # of them must be hidden
_LEAST_SHARE = 0.9  # of a box's shadow; each thing hides some of what is beneath it


@dataclass(frozen=True)
class HiddenSupport:
    """Something unseen that carries a box.

    Args:
        area: on the ground plane, where it can touch the box, (V, 2) metres (x, z), counter-clockwise.
        top: the height at which it ends, metres; bottom: the height of what it stands on itself.
    """

    area: Tensor
    top: float
    bottom: float


def hidden_support(
    boxes: Boxes, i: int, hidden: Hidden, held: Polygons, mass_center: Tensor, ground_height: float
) -> HiddenSupport | None:
    """What may carry box i unseen; None where the camera would have seen it, or where it would not do.

    Under the box columns go down to the ground or to the box beneath. Something can stand in those that were hidden.
    It does if the centre of mass lies over the hull of them and of what else holds the box.

    Args:
        boxes: N boxes, world frame.
        held: the areas that hold it already; mass_center: (3,) of the box and all that rests on it.
    """
    shadow = footprints(boxes[[i]])
    corners = boxes[[i]].corners()[0]
    low, high = on_ground(corners).amin(dim=0), on_ground(corners).amax(dim=0)
    step = (torch.arange(_GRID, dtype=torch.float64) + 0.5) / _GRID
    x, z = torch.meshgrid(
        low[0] + step * (high[0] - low[0]), low[1] + step * (high[1] - low[1]), indexing="ij"
    )
    spot = torch.stack([x.flatten(), z.flatten()], dim=1)
    count = len(spot)
    same = Polygons(shadow.vertices.expand(count, -1, -1), shadow.count.expand(count))
    spot = spot[signed_distance(same, spot) > 0]
    top = float(corners[:, 1].amin())
    floor = _floor(boxes, i, spot, top, ground_height)
    share = (torch.arange(_LEVELS, dtype=torch.float64) + 0.5) / _LEVELS
    height = floor[:, None] + share * (top - floor)[:, None]
    points = torch.stack([spot[:, :1].expand_as(height), height, spot[:, 1:].expand_as(height)], dim=-1)
    free = (hidden(points).double().mean(dim=1) >= _HIDDEN_SHARE) & (floor < top)
    if float(free.double().mean()) < _LEAST_SHARE:
        return None
    unseen = _hull(spot[free])
    both = _hull(
        torch.cat([spot[free], *(v[:c] for v, c in zip(held.vertices, held.count.tolist(), strict=True))])
    )
    if float(signed_distance(both, on_ground(mass_center)[None])[0]) < 0:
        return None
    return HiddenSupport(unseen.vertices[0, : int(unseen.count[0])], top, float(floor[free].amin()))


def _floor(boxes: Boxes, i: int, spot: Tensor, top: float, ground_height: float) -> Tensor:
    """(S,) height of the highest thing beneath box i at each spot (S, 2)."""
    shadows, tops = footprints(boxes), boxes.corners()[..., 1].amax(dim=1)
    floor = torch.full((len(spot),), ground_height, dtype=torch.float64)
    for j in range(len(boxes)):
        if j != i and float(tops[j]) < top:
            count = len(spot)
            one = Polygons(shadows.vertices[[j]].expand(count, -1, -1), shadows.count[[j]].expand(count))
            over = signed_distance(one, spot) > 0
            floor = torch.where(over, floor.clamp(min=float(tops[j])), floor)
    return floor


def _hull(points: Tensor) -> Polygons:
    return hull(points[None], torch.ones(1, len(points), dtype=torch.bool))


def areas_of(found: list[HiddenSupport]) -> Polygons:
    """The areas of several, as polygons."""
    return concatenate([_hull(one.area) for one in found])
