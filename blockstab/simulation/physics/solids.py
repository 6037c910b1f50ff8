"""Rigid things of everyday shapes, and piles of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes


@dataclass(frozen=True)
class Part:
    """A convex piece of a solid, in the solid's own frame.

    Args:
        form: "box", "cylinder" (about its own y axis), "sphere", or "hull" of some points.
        center: (3,) float64 metres.
        rotation: (3, 3) float64; the columns are the part's axes.
        half_extent: (3,) float64 metres along its own axes: radius, half height, radius of a cylinder; three
            times the radius of a sphere; of a hull, half the size of its bounding box.
        points: (V, 3) float64 corners of a hull in the part's frame; None for the others.
        echo: share of infrared light that comes back from it, above 0: 1 from most things, little from black
            glass.
    """

    form: Literal["box", "cylinder", "sphere", "hull"]
    center: Tensor
    rotation: Tensor
    half_extent: Tensor
    points: Tensor | None = None
    echo: float = 1.0


@dataclass(frozen=True)
class Solid:
    """A rigid thing, in a frame whose origin is the centre of its bounding box.

    Args:
        kind: its shape, as the truth names it: "box", "cylinder", "sphere", "bowl", "bottle", "l_shape",
            "screen", "laptop", "mouse", "table", "chair".
        style: what it is made up as: "block", "plank", "book", "carton", "tin", "can", "ball", "bowl", "plate",
            "bottle", "bracket", "screen", "laptop", "keyboard", "mouse", "pen", "tool", "phone"; the furniture's
            are "table", "floor", "wall", "shelf".
        half_extent: (3,) float64 metres, of its bounding box; +y is up where it stands as it should.
        parts: what it is made of; they may touch or overlap a little.
        density: kg per cubic metre of its parts.
        product: solids of equal product look alike; those with None look like nothing else.
    """

    kind: str
    style: str
    half_extent: Tensor
    parts: tuple[Part, ...]
    density: float = 600.0
    product: int | None = None


@dataclass(frozen=True)
class Pile:
    """N solids, each with a pose.

    Args:
        solids: the N things.
        center: (N, 3) float64 metres, where the centres of their bounding boxes are.
        rotation: (N, 3, 3) float64; the columns are the axes of each solid's frame.
    """

    solids: tuple[Solid, ...]
    center: Tensor
    rotation: Tensor

    def __len__(self) -> int:
        return len(self.solids)

    def __getitem__(self, index: Sequence[int]) -> Pile:
        at = list(index)
        return Pile(tuple(self.solids[i] for i in at), self.center[at], self.rotation[at])

    def boxes(self) -> Boxes:
        """The bounding boxes."""
        return Boxes(self.center, self.rotation, torch.stack([s.half_extent for s in self.solids]))

    def moved(self, rotation: Tensor, shift: Tensor) -> Pile:
        """The same pile turned by `rotation` (3, 3) about the origin, then shifted by `shift` (3,)."""
        return Pile(self.solids, self.center @ rotation.T + shift, rotation @ self.rotation)


def concatenate(piles: Sequence[Pile]) -> Pile:
    """One pile from several, in order; an empty one from none."""
    return Pile(
        tuple(solid for pile in piles for solid in pile.solids),
        torch.cat([torch.empty(0, 3, dtype=torch.float64), *(pile.center for pile in piles)]),
        torch.cat([torch.empty(0, 3, 3, dtype=torch.float64), *(pile.rotation for pile in piles)]),
    )


def box(half_extent: Sequence[float], style: str = "block", density: float = 600.0) -> Solid:
    """A box of one part."""
    half = torch.tensor(half_extent, dtype=torch.float64)
    part = Part("box", torch.zeros(3, dtype=torch.float64), torch.eye(3, dtype=torch.float64), half)
    return Solid("box", style, half, (part,), density)
