"""Solids at rest on a table: where they settle, what falls, what moves (MuJoCo; Todorov et al. 2012).

The table frame: right-handed, +y up, metres; the table is the plane y = 0.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import torch
from torch import Tensor

from blockstab.simulation.physics.engine import poses, require_mujoco, steps_of, world
from blockstab.simulation.physics.solids import Pile

_LONGEST_SETTLE = 4.0  # seconds
_WATCH = 0.5  # seconds for which a thing at rest must keep its pose
_REST_SHIFT = 0.0005  # metres
_REST_TURN = math.radians(0.2)
_REST_SPEED = 0.005  # metres and radians a second
_FALL_SECONDS = 1.5
_FALL_SHIFT = 0.01  # metres; less than the thinnest plank, off which a thing falls
_FALL_TURN = math.radians(10.0)
_ROUND = ("sphere", "cylinder", "bowl", "bottle")


def settle(pile: Pile, reach: float = 0.5) -> Pile | None:
    """Let go of a pile and wait until it rests.

    Args:
        reach: metres along x or z from the middle of the table; what gets further is lost.

    Returns:
        The pile as it lies: for half a second each solid has moved less than 0.5 mm and turned less than 0.2
        degrees, and all speeds are below 5 mm/s and 5 mrad/s. None where that does not happen within 4 s, or
        something is lost.
    """
    for after, resting in _until_rest(pile, _LONGEST_SETTLE):
        if bool((after.center[:, [0, 2]].abs() > reach).any()):
            return None
        if resting:
            return after
    return None


def falls(pile: Pile) -> Tensor:
    """Removal of each of N resting solids, one at a time: the others that fall, found by simulation.

    Returns:
        (N, N) bool: [i, j] where j moves more than 1 cm, or turns by more than 10 degrees, within 1.5 s
        after i is gone. A round solid that turns about its own axis has not turned.
    """
    n = len(pile)
    result = torch.zeros(n, n, dtype=torch.bool)
    model, data = world(pile)
    require_mujoco().mj_forward(model, data)
    bodies = model.geom_bodyid[data.contact.geom]
    # What touches the table alone holds nothing up.
    holding = set(bodies[(bodies > 0).all(axis=1)].flatten().tolist())
    for i in range(n):
        if i + 1 in holding:
            others = [j for j in range(n) if j != i]
            result[i, others] = moves(pile[others])
    return result


def moves(pile: Pile) -> Tensor:
    """Mask of the N solids that move, let go where they are.

    Returns:
        (N,) bool: within 1.5 s it moves more than 1 cm, or turns by more than 10 degrees.
    """
    if len(pile) == 0:
        return torch.zeros(0, dtype=torch.bool)
    *_, (after, _) = _until_rest(pile, _FALL_SECONDS)
    return _moved(pile, after, _FALL_SHIFT, _FALL_TURN)


def _until_rest(pile: Pile, seconds: float) -> Iterator[tuple[Pile, bool]]:
    """The pile after each half second, and whether it rested during it; ends with rest, or after `seconds`."""
    model, data = world(pile)
    before = pile
    for _ in range(round(seconds / _WATCH)):
        require_mujoco().mj_step(model, data, steps_of(_WATCH))
        after = poses(data, pile)
        still = bool(np.abs(data.qvel).max() < _REST_SPEED)
        resting = still and not bool(_moved(before, after, _REST_SHIFT, _REST_TURN).any())
        yield after, resting
        if resting:
            return
        before = after


def _moved(before: Pile, after: Pile, shift: float, turn: float) -> Tensor:
    distance = (after.center - before.center).norm(dim=1)
    # The chord between two rotations a small angle t apart is 2 sqrt(2) sin(t / 2); that between two axes is
    # 2 sin(t / 2).
    apart = after.rotation - before.rotation
    full = apart.flatten(1).norm(dim=1) / math.sqrt(2.0)
    tilt = apart[:, :, 1].norm(dim=1)
    kinds = [solid.kind for solid in before.solids]
    chord = torch.where(torch.tensor([kind in _ROUND for kind in kinds]), tilt, full)
    chord = torch.where(torch.tensor([kind == "sphere" for kind in kinds]), 0.0, chord)
    fell: Tensor = (distance > shift) | (chord > 2.0 * math.sin(turn / 2.0))
    return fell
