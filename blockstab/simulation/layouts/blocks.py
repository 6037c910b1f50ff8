"""The preset `blocks`: wooden blocks on a table, one structure beside another (the like of the paper's Block set)."""

from __future__ import annotations

import torch

from blockstab.simulation.layouts.placing import side_by_side
from blockstab.simulation.layouts.structures import STRUCTURES
from blockstab.simulation.physics.solids import Pile

_GOAL, _MOST = (3, 10), 14


def arrange_blocks(generator: torch.Generator) -> Pile:
    """Three to fourteen blocks in towers, bridges, overhangs, walls, stairs, rows and leaning planks.

    Returns:
        A pile in the table frame (right-handed, +y up, metres; the table is the plane y = 0), where a hand
        lets go of it: nothing overlaps, each is a millimetre or two above what it is to rest on.
    """
    return side_by_side(generator, STRUCTURES, _GOAL, _MOST)
