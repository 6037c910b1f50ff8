"""The centre of mass of an island over the area that holds it (paper, section 6)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.geometry.convex_hulls import Polygons, centroid, hull, signed_distance
from blockstab.stability.area import on_ground
from blockstab.stability.loads import loads
from blockstab.stability.support import Supports

EDGE_REACH = 0.01  # metres by which a support without area, an edge or a corner, reaches around itself


@dataclass(frozen=True)
class Balance:
    """Stability verdicts of N boxes.

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

    @staticmethod
    def of_background(mass_center: Tensor) -> Balance:
        """Verdicts on background: it stands."""
        n = len(mass_center)
        inf, nan = mass_center.new_full((n,), float("inf")), mass_center.new_full((n, 2), float("nan"))
        stands = torch.ones(n, dtype=torch.bool)
        return Balance(stands, stands, inf, mass_center, nan)

    def with_rows(self, index: Tensor, rows: Balance) -> Balance:
        """These verdicts with those of `rows` (n) in the places `index` (n,)."""
        return Balance(
            self.stable.index_copy(0, index, rows.stable),
            self.stable_alone.index_copy(0, index, rows.stable_alone),
            self.margin.index_copy(0, index, rows.margin),
            self.mass_center.index_copy(0, index, rows.mass_center),
            self.support_center.index_copy(0, index, rows.support_center),
        )

    def __getitem__(self, index: Tensor | slice) -> Balance:
        return Balance(
            self.stable[index],
            self.stable_alone[index],
            self.margin[index],
            self.mass_center[index],
            self.support_center[index],
        )


def concatenate(parts: Sequence[Balance]) -> Balance:
    """The verdicts on several sets of boxes, in order."""
    return Balance(
        torch.cat([p.stable for p in parts]),
        torch.cat([p.stable_alone for p in parts]),
        torch.cat([p.margin for p in parts]),
        torch.cat([p.mass_center for p in parts]),
        torch.cat([p.support_center for p in parts]),
    )


def combined(areas: Polygons, slots: Tensor, used: Tensor) -> Polygons:
    """The hulls of K combinations of supporting areas (Fig. 8 f-g).

    Args:
        areas: E supporting areas.
        slots: (K, S) indices into `areas`; used: (K, S) bool, which of them take part.
    """
    if len(areas) == 0:
        return Polygons(areas.vertices.new_zeros(len(slots), 1, 2), torch.zeros(len(slots), dtype=torch.long))
    # Most combinations are of few areas: those that take part come first, and the rest is left out.
    order = used.to(torch.int8).argsort(dim=1, descending=True, stable=True)
    width = max(int(used.sum(dim=1).max()), 1) if len(used) else 1
    slots, used = slots.gather(1, order)[:, :width], used.gather(1, order)[:, :width]
    vertices = areas.vertices[slots]  # (K, S, V, 2)
    present = used[..., None] & (torch.arange(vertices.shape[2]) < areas.count[slots][..., None])
    return hull(vertices.flatten(1, 2), present.flatten(1, 2))


def margins(held: Polygons, center: Tensor) -> Tensor:
    """Distances of the centres of mass (K, 3) inside the hulls that hold them, (K,) metres; NaN without one.

    Convention:
        A hull without area holds what lies within `EDGE_REACH` of it: no edge is infinitely sharp, but one
        edge alone is a poor support. A hull with area is taken as it is.
    """
    margin = signed_distance(held, on_ground(center))
    margin = torch.where(held.count <= 2, margin + EDGE_REACH, margin)
    return margin.masked_fill(held.count == 0, float("nan"))


def mass_centers(boxes: Boxes, load: Tensor) -> Tensor:
    """Eq. 1: the centre of mass of each set of boxes of equal density.

    Args:
        load: (K, N) bool, the boxes of each set.

    Returns:
        (K, 3) metres.
    """
    carrier, carried = load.nonzero(as_tuple=True)
    volume = boxes.volume()[carried, None]
    # A sum in the order of the boxes rounds alike however many boxes there are beside them; a product does not,
    # and whether a box on the very edge of its support stands hangs on the last bit.
    mass = volume.new_zeros(len(load), 1).index_add(0, carrier, volume)
    return mass.new_zeros(len(load), 3).index_add(0, carrier, volume * boxes.center[carried]) / mass


def slots_of(supports: Supports, n: int) -> tuple[Tensor, Tensor]:
    """The supports of each of N boxes side by side: (N, S) indices into `supports`, and which are real."""
    order = supports.supported.argsort(stable=True)
    owner = supports.supported[order]
    amount = torch.bincount(owner, minlength=n)
    start = amount.cumsum(dim=0) - amount
    slots = torch.zeros(n, max(int(amount.max()), 1) if n else 1, dtype=torch.long)
    slots[owner, torch.arange(len(order)) - start[owner]] = order
    return slots, torch.arange(slots.shape[1]) < amount[:, None]


def balance(boxes: Boxes, movable: Tensor, supports: Supports, slack: Tensor) -> Balance:
    """Judge each box, with all that rests on it, over the hull of its supporting areas.

    Args:
        boxes: N boxes; movable: (N,) bool, false for background; supports: the relations that count.
        slack: (N,) metres by which a centre of mass may lie outside and still count as held: what the boxes are
            uncertain by, 0 where they are exact.
    """
    n = len(boxes)
    slots, used = slots_of(supports, n)
    # Side supports carry no weight: they push, and what they hold up rests elsewhere.
    center = mass_centers(boxes, loads(*supports.resting(), n))
    held = combined(supports.area, slots, used)
    margin = margins(held, center)
    return Balance(
        stable=(margin >= -slack) | ~movable,
        stable_alone=(margins(held, boxes.center) >= -slack) | ~movable,
        margin=margin.masked_fill(~movable, float("inf")),
        mass_center=center,
        support_center=centroid(held),
    )
