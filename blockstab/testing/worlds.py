"""Small worlds of boxes whose truth is known by hand: metres, +y up, the ground at y = 0, seen from afar off."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.boxes.separation import separation
from blockstab.stability.balance import Balance, balance
from blockstab.stability.support import GROUND, SupportRules, Supports, SupportType, candidate_supports
from blockstab.stability.trimming import trim


@dataclass(frozen=True)
class Block:
    """A box by the middle of its lower face before it is tilted about the z axis through its lowest edge.

    Args:
        x, y, z: middle of the lower face.
        w, h, d: full extent along x, y, z.
        tilt_deg: turn towards -x (positive) about the lower edge on that side of the turn.
        fixed: background.
    """

    x: float
    y: float
    w: float
    h: float
    z: float = 0.0
    d: float = 0.1
    tilt_deg: float = 0.0
    fixed: bool = False


@dataclass(frozen=True)
class WorldVerdicts:
    """Verdicts of the rule on a world."""

    boxes: Boxes
    movable: Tensor
    candidates: Supports
    supports: Supports
    balance: Balance

    def supporters(self, box: int) -> set[tuple[int, str]]:
        """The supports of one box as (supporter, type in lower case); -1 is the ground."""
        mine = self.supports.supported == box
        pairs = zip(self.supports.supporter[mine].tolist(), self.supports.type[mine].tolist(), strict=True)
        return {(below, SupportType(kind).name.lower()) for below, kind in pairs}


def build(*blocks: Block) -> tuple[Boxes, Tensor]:
    """Boxes of the blocks, and which of them are movable."""
    centers, rotations, halves = [], [], []
    for b in blocks:
        angle = math.radians(b.tilt_deg)
        turn = torch.tensor(
            [[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]],
            dtype=torch.float64,
        )
        # The lowest edge stays where it was: the left one for a turn to the left.
        hinge = torch.tensor([-b.w / 2 if b.tilt_deg >= 0 else b.w / 2, 0.0, 0.0], dtype=torch.float64)
        middle = torch.tensor([0.0, b.h / 2, 0.0], dtype=torch.float64)
        base = torch.tensor([b.x, b.y, b.z], dtype=torch.float64)
        centers.append(base + hinge + turn @ (middle - hinge))
        rotations.append(turn)
        halves.append(torch.tensor([b.w / 2, b.h / 2, b.d / 2], dtype=torch.float64))
    boxes = Boxes(torch.stack(centers), torch.stack(rotations), torch.stack(halves))
    return boxes, torch.tensor([not b.fixed for b in blocks])


def judge(*blocks: Block) -> WorldVerdicts:
    """Ask the paper's rule about a world that stands on the ground at y = 0."""
    return judge_boxes(*build(*blocks))


def judge_boxes(boxes: Boxes, movable: Tensor) -> WorldVerdicts:
    """The same for boxes."""
    n = len(boxes)
    first, second = torch.triu_indices(n, n, offset=1)
    candidates = candidate_supports(
        boxes,
        (first, second),
        separation(boxes, first, second),
        torch.zeros(n, dtype=torch.float64),
        movable,
        torch.zeros(n, dtype=torch.bool),
        SupportRules(),
    )
    exact = torch.zeros(n, dtype=torch.float64)
    supports = trim(boxes, candidates, exact)
    return WorldVerdicts(boxes, movable, candidates, supports, balance(boxes, movable, supports, exact))


TABLE = (GROUND, "surface")

ONE_BLOCK = (Block(0, 0, 0.2, 0.1),)
STACK = (Block(0, 0, 0.2, 0.1), Block(0, 0.1, 0.2, 0.1))
BRIDGE = (Block(-0.3, 0, 0.08, 0.2), Block(0.3, 0, 0.08, 0.2), Block(0, 0.2, 0.7, 0.04))
# A plank of 0.6 m at 65 degrees whose top touches a wall on its left.
LEANING_PLANK = (
    Block(0, 0, 0.03, 0.6, tilt_deg=25.0),
    Block(-0.015 - 0.6 * math.sin(math.radians(25.0)) - 0.05, 0, 0.1, 1.8, d=2.0, fixed=True),
)
FINE_LOCALLY_FALLS_GLOBALLY = (
    Block(0, 0, 0.2, 0.05),
    Block(0.08, 0.05, 0.2, 0.05),
    Block(0.16, 0.10, 0.2, 0.05),
)
TOUCHING_NEIGHBOURS = (Block(0, 0, 0.1, 0.2), Block(0.105, 0, 0.1, 0.15))
# Two planks of 0.5 m that lean on each other like a tent; their upper ends meet at x = 0.
_FOOT = 0.5 * math.sin(math.radians(25.0)) + 0.01 * math.cos(math.radians(25.0))
TENT = (Block(_FOOT, 0, 0.02, 0.5, tilt_deg=25.0), Block(-_FOOT, 0, 0.02, 0.5, tilt_deg=-25.0))
COUNTERWEIGHT = (
    Block(0, 0, 0.1, 0.2),
    Block(0.12, 0.2, 0.4, 0.03),
    Block(-0.04, 0.23, 0.08, 0.2),
)


def overhang(past_tipping_m: float) -> tuple[Block, Block]:
    """A block on another, its middle so far beyond the edge below."""
    return Block(0, 0, 0.2, 0.1), Block(0.1 + past_tipping_m, 0.1, 0.2, 0.1)
