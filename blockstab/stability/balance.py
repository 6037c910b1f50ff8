"""The centre of mass of a pile over the area that holds it (paper, section 6)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.convex import Polygons, area, centroid, hull, signed_distance
from blockstab.stability.area import on_ground
from blockstab.stability.support import Supports, SupportType

EDGE_REACH = 0.01  # metres by which a support without area (an edge, a corner) is taken to reach around itself


@dataclass(frozen=True)
class Balance:
    """Which of N boxes stand.

    Args:
        stable: (N,) bool, the box with everything resting on it ("global stability"); background stands.
        stable_alone: (N,) bool, the box by itself over its own support.
        margin: (N,) metres from the projected centre of mass to the border of the support hull, positive
            inside; NaN where nothing supports the box, +inf for background.
        mass_center: (N, 3) metres, centre of mass of the box and all that rests on it (Eq. 1).
        support_center: (N, 2) centre (x, z) of the support hull, metres; NaN where nothing supports the box.
    """

    stable: Tensor
    stable_alone: Tensor
    margin: Tensor
    mass_center: Tensor
    support_center: Tensor

    def between(self, start: int, stop: int) -> Balance:
        """The verdicts on boxes `start` to `stop - 1`."""
        return Balance(
            self.stable[start:stop],
            self.stable_alone[start:stop],
            self.margin[start:stop],
            self.mass_center[start:stop],
            self.support_center[start:stop],
        )


class Footing(NamedTuple):
    """How well combined supporting areas hold up a centre of mass.

    Args:
        margin: (K,) metres inside the hull of the areas; NaN where there is none.
        area: (K,) square metres of that hull.
        center: (K, 2) its centre.
    """

    margin: Tensor
    area: Tensor
    center: Tensor


def footing(areas: Polygons, slots: Tensor, used: Tensor, center: Tensor) -> Footing:
    """Stand K centres of mass on K combinations of supporting areas (Fig. 8 f-g: the hull of them all).

    Args:
        areas: E supporting areas.
        slots: (K, S) indices into `areas`; used: (K, S) bool, which of them take part.
        center: (K, 3) centres of mass.

    Convention:
        A hull without area holds what lies within `EDGE_REACH` of it: no edge is infinitely sharp, but one
        edge alone is a poor support. A hull with area is taken as it is.
    """
    if len(areas) == 0:
        none = center.new_full((len(center),), float("nan"))
        return Footing(none, torch.zeros_like(none), center.new_full((len(center), 2), float("nan")))
    vertices = areas.vertices[slots]  # (K, S, V, 2)
    present = used[..., None] & (torch.arange(vertices.shape[2]) < areas.count[slots][..., None])
    combined = hull(vertices.flatten(1, 2), present.flatten(1, 2))
    margin = signed_distance(combined, on_ground(center))
    margin = torch.where(combined.count <= 2, margin + EDGE_REACH, margin)
    margin = margin.masked_fill(combined.count == 0, float("nan"))
    return Footing(margin, area(combined), centroid(combined))


def mass_centers(boxes: Boxes, load: Tensor) -> Tensor:
    """Eq. 1: the centre of mass of each set of boxes of equal density.

    Args:
        load: (K, N) bool, the boxes of each set.

    Returns:
        (K, 3) metres.
    """
    mass = load.to(boxes.center.dtype) * boxes.volume()
    return mass @ boxes.center / mass.sum(dim=1, keepdim=True)


def slots_of(supports: Supports, n: int) -> tuple[Tensor, Tensor]:
    """The supports of each of N boxes side by side: (N, S) indices into `supports`, and which are real."""
    order = supports.supported.argsort(stable=True)
    owner = supports.supported[order]
    amount = torch.bincount(owner, minlength=n)
    start = amount.cumsum(dim=0) - amount
    slots = torch.zeros(n, max(int(amount.max()), 1) if n else 1, dtype=torch.long)
    slots[owner, torch.arange(len(order)) - start[owner]] = order
    return slots, torch.arange(slots.shape[1]) < amount[:, None]


def levels(supports: Supports, n: int) -> Tensor:
    """(N,) how many layers of boxes lie on each box: 0 for those on top, so that load flows upwards in number."""
    resting = (supports.supporter >= 0) & (supports.type != SupportType.SIDE)
    upper, lower = supports.supported[resting], supports.supporter[resting]
    level = torch.zeros(n, dtype=torch.long)
    for _ in range(n):
        raised = level.scatter_reduce(0, lower, level[upper] + 1, "amax")
        if bool((raised == level).all()):
            break
        level = raised
    return level


def loads(supports: Supports, n: int) -> Tensor:
    """(N, N) bool: row b holds b and every box that rests, through however many others, on b.

    Side supports carry no weight: they push, and what they hold up rests elsewhere.
    """
    resting = (supports.supporter >= 0) & (supports.type != SupportType.SIDE)
    on = torch.eye(n)
    on[supports.supporter[resting], supports.supported[resting]] = 1.0
    while True:
        further = ((on @ on) > 0).to(on.dtype)
        if bool((further == on).all()):
            return on > 0
        on = further


def balance(boxes: Boxes, movable: Tensor, supports: Supports, slack: Tensor) -> Balance:
    """Judge each box, with all that rests on it, over the hull of its supporting areas.

    Args:
        boxes: N boxes; movable: (N,) bool, false for background; supports: the relations that count.
        slack: (N,) metres by which a centre of mass may lie outside and still count as held: what the boxes are
            uncertain by, 0 where they are exact.
    """
    n = len(boxes)
    slots, used = slots_of(supports, n)
    center = mass_centers(boxes, loads(supports, n))
    held = footing(supports.area, slots, used, center)
    alone = footing(supports.area, slots, used, boxes.center)
    return Balance(
        stable=(held.margin >= -slack) | ~movable,
        stable_alone=(alone.margin >= -slack) | ~movable,
        margin=held.margin.masked_fill(~movable, float("inf")),
        mass_center=center,
        support_center=held.center,
    )
