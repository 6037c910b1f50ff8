"""Boundary maps: the likelihood of an edge between two objects at each pixel, and its orientation."""

from __future__ import annotations

from dataclasses import dataclass

from torch import Tensor


@dataclass(frozen=True)
class BoundaryMap:
    """The strength of boundaries.

    Args:
        oriented: (4, H, W) float64, 0 to 1. Channel k is for edges whose tangent is at 45 k degrees, turning
            counter-clockwise from the image's x axis as one sees it: "-", "/", "|" and "\\".
        strength: (H, W) float64, 0 to 1: what a watershed floods.
    """

    oriented: Tensor
    strength: Tensor
