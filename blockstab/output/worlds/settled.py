"""Boxes set down exactly on what carries them: a simulator throws apart what overlaps by a millimetre."""

from __future__ import annotations

from dataclasses import replace

import torch

from blockstab.boxes.separation import separation
from blockstab.stability.arrangement import Arrangement
from blockstab.stability.judges import TrimmedSupports
from blockstab.stability.support import GROUND, SupportType

_LEAST_RISE = 0.5  # of the direction between two boxes that are on top of each other


def settled(asked: Arrangement) -> Arrangement:
    """The arrangement with every object moved up or down until it touches the highest thing that carries it.

    From the lowest up, by no more than boxes may be apart and still touch, or overlap. Side supports move nothing.
    """
    candidates = asked.candidates()
    supports = TrimmedSupports()(asked.boxes, asked.movable, candidates, asked.slack).supports
    resting = supports.type != SupportType.SIDE
    below, above = supports.supporter[resting].tolist(), supports.supported[resting].tolist()
    carriers: dict[int, list[int]] = {}
    for lower, upper in zip(below, above, strict=True):
        carriers.setdefault(upper, []).append(lower)
    boxes = asked.boxes
    for i in boxes.corners()[..., 1].amin(dim=1).argsort(stable=True).tolist():
        if i not in carriers or not bool(asked.movable[i]):
            continue
        rises = []
        for lower in carriers[i]:
            if lower == GROUND:
                rises.append(asked.ground_height - float(boxes.corners()[i, :, 1].amin()))
            else:
                apart = separation(boxes, torch.tensor([lower]), torch.tensor([i]))
                rises.append(-float(apart.gap[0]) / max(float(apart.direction[0, 1]), _LEAST_RISE))
        center = boxes.center.clone()
        center[i, 1] += max(rises)
        boxes = replace(boxes, center=center)
    return replace(asked, boxes=boxes)


def overlapping(asked: Arrangement, least_m: float) -> list[tuple[int, int]]:
    """Pairs of boxes that overlap by more than so many metres."""
    n = len(asked.boxes)
    first, second = torch.triu_indices(n, n, offset=1)
    gap = separation(asked.boxes, first, second).gap
    deep = gap < -least_m
    return list(zip(first[deep].tolist(), second[deep].tolist(), strict=True))
