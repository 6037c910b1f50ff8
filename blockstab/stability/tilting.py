"""The margin of a scene: how far gravity may tilt, in the worst direction, before something begins to move.

The tilts that balance are a convex set in the plane of horizontal pulls. Its bound nearest to no tilt is the margin,
and the duals of the linear programme that finds it say how it changes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import torch
from scipy.optimize import linprog
from scipy.sparse import csc_array, hstack
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.stability.contacts import FRICTION, Contacts
from blockstab.stability.equilibrium import Equations, balances, equations, pyramids

_DIRECTIONS = 8  # in which gravity is tilted first
_STEEP = 100.0  # the greatest tilt that is asked about, as a ratio: what holds then would hold on a wall


class Tilt(NamedTuple):
    """The least tilt of gravity for which something begins to move.

    Args:
        degrees: () float64, 0 where something moves already; its gradient is that by all that it was computed from.
        direction: (2,) float64, in which gravity then pulls, x and z; NaN where nothing limits it, or all does.
    """

    degrees: Tensor
    direction: Tensor


class _Bound(NamedTuple):
    """How far gravity may tilt in one direction.

    Args:
        ratio: of the pull sideways to that down.
        line: (2,) what limits it there: `line @ tilt = 1` in the plane of tilts.
        forces: (G,) along the generators; duals: (6 M,) of the equations.
    """

    ratio: float
    line: np.ndarray
    forces: np.ndarray
    duals: np.ndarray


def least_tilt(boxes: Boxes, movable: Tensor, contacts: Contacts, friction: float = FRICTION) -> Tilt:
    """The least tilt, in the worst direction; the arguments are those of `equations`.

    It can be differentiated with respect to boxes and contacts, where one bound alone is nearest and its forces are
    the only ones.
    """
    system, nowhere = (
        equations(boxes, movable, contacts, friction),
        torch.full((2,), torch.nan, dtype=torch.float64),
    )
    if not len(system.body):
        return Tilt(torch.tensor(90.0, dtype=torch.float64), nowhere)
    if not balances(system):
        return Tilt(torch.tensor(0.0, dtype=torch.float64), nowhere)
    bound, direction = _nearest(system)
    pull = torch.from_numpy(direction)
    left = _imbalance(
        boxes, movable, contacts, friction, torch.from_numpy(bound.forces), bound.ratio * pull, system
    )
    # The imbalance is nothing; how it would change, weighed by the duals, is how the ratio does.
    ratio = bound.ratio + torch.from_numpy(bound.duals) @ (left - left.detach())
    return Tilt(torch.rad2deg(torch.atan(ratio)), pull)


def _nearest(system: Equations) -> tuple[_Bound, np.ndarray]:
    """The nearest bound, and the direction to it, (2,).

    From each of some directions it is walked to the foot of the bound that is met, until a foot is met itself.
    """
    best, where = None, np.full(2, np.nan)
    for angle in np.arange(_DIRECTIONS) * 2 * np.pi / _DIRECTIONS:
        direction = np.array([np.cos(angle), np.sin(angle)])
        for _ in range(_DIRECTIONS):
            found = _furthest(system, direction)
            if best is None or found.ratio < best.ratio:
                best, where = found, direction
            steep = float(np.linalg.norm(found.line))
            if steep <= 1.0 / _STEEP or 1.0 / steep > best.ratio - 1e-9:
                break
            direction = found.line / steep
    assert best is not None
    return best, where


def _furthest(system: Equations, direction: np.ndarray) -> _Bound:
    """How far gravity may tilt in a direction (2,), where it balances untilted."""
    tilted = csc_array(-(direction @ system.slope)[:, None])
    matrix = hstack([system.forces, tilted], format="csc")
    cost, bounds = np.zeros(matrix.shape[1]), np.zeros((matrix.shape[1], 2))
    cost[-1] = -1.0
    bounds[:, 1] = np.inf
    bounds[-1, 1] = _STEEP
    found = linprog(cost, A_eq=matrix, b_eq=system.weight, bounds=bounds, method="highs")
    if found.status != 0:  # it balances, but by less than rounding
        nothing = np.zeros(len(system.weight))
        return _Bound(0.0, np.zeros(2), np.zeros(system.forces.shape[1]), nothing)
    duals = found.eqlin.marginals
    carried = -(duals @ system.weight)
    line = (system.slope @ duals) / carried if abs(carried) > 1e-12 else np.zeros(2)
    return _Bound(float(found.x[-1]), line, found.x[:-1], duals)


def _imbalance(
    boxes: Boxes,
    movable: Tensor,
    contacts: Contacts,
    friction: float,
    forces: Tensor,
    tilt: Tensor,
    system: Equations,
) -> Tensor:
    """(6 M,) what forces (G,) along the generators leave unbalanced under a tilt (2,), as in `equations`."""
    force = (forces.view(-1, 4, 1) * pyramids(contacts.normal, friction)).sum(dim=1)
    wrench = torch.zeros(len(movable), 6, dtype=torch.float64)
    for box, sign in ((contacts.supported, 1.0), (contacts.supporter, -1.0)):
        real = box >= 0
        arm = contacts.point[real] - boxes.center[box[real]]
        moment = torch.linalg.cross(arm, sign * force[real]) / system.size
        wrench = wrench.index_add(0, box[real], torch.cat([sign * force[real], moment], dim=1))
    volume = boxes.volume() * movable
    share = volume / volume.sum()
    needed = torch.stack([-tilt[0] * share, share, -tilt[1] * share], dim=1)
    return (wrench - torch.nn.functional.pad(needed, (0, 3)))[torch.from_numpy(system.body)].flatten()
