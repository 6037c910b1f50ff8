"""Who may support whom, and how: surface, partial, side (paper, section 5.2)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from torch import Tensor

from blockstab.convex import Polygons

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
