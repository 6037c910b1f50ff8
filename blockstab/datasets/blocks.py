"""The preset `blocks`: wooden blocks of 6 to 24 cm on a table, one structure beside another."""

from __future__ import annotations

import math

import torch

from blockstab.boxes.box import Boxes, concatenate
from blockstab.boxes.separation import separation
from blockstab.datasets.structures import STRUCTURES, about_up, as_boxes

_FEWEST, _MOST = 3, 10
_CLEARANCE = 0.003  # metres between structures
_TRIES = 100  # places tried for a structure, further and further out
_REACH = 0.4  # metres from the middle of the table


def arrange_blocks(generator: torch.Generator) -> Boxes:
    """Three to ten blocks in towers, bridges, overhangs, rows and leaning pairs.

    Returns:
        Boxes in the table frame (right-handed, +y up, metres; the table is the plane y = 0), where a hand
        lets go of them: nothing overlaps, each is a millimetre or two above what it is to rest on.
    """
    goal = int(torch.randint(_FEWEST, _MOST + 1, (), generator=generator))
    pile = _structure(generator)
    while len(pile) < goal:
        placed = _place(generator, _structure(generator), pile)
        if placed is None or len(pile) + len(placed) > _MOST:
            break
        pile = concatenate([pile, placed])
    return pile


def _structure(generator: torch.Generator) -> Boxes:
    chosen = int(torch.randint(len(STRUCTURES), (), generator=generator))
    return as_boxes(STRUCTURES[chosen](generator))


def _place(generator: torch.Generator, structure: Boxes, pile: Boxes) -> Boxes | None:
    """Turn and shift a structure to a free place near the pile; None where there is none within reach."""
    new = torch.arange(len(structure)).repeat_interleave(len(pile))
    old = len(structure) + torch.arange(len(pile)).repeat(len(structure))
    for attempt in range(_TRIES):
        yaw, angle, share = torch.rand(3, generator=generator, dtype=torch.float64)
        radius = _REACH * (attempt + 1) / _TRIES * share.sqrt()
        angle = 2 * math.pi * angle
        shift = torch.stack([radius * angle.cos(), torch.zeros_like(radius), radius * angle.sin()])
        turned = structure.rotated(about_up(2 * math.pi * yaw))
        moved = Boxes(turned.center + shift, turned.rotation, turned.half_extent)
        if bool((separation(concatenate([moved, pile]), new, old).gap > _CLEARANCE).all()):
            return moved
    return None
