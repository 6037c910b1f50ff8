"""Static equilibrium of rigid boxes: can forces of contact, with friction, carry them? How far may gravity tilt?

Forces act at the corners of contact patches and lie in friction pyramids. That they balance weights and moments is a
set of linear equations in what is not negative (Whiting, Ochsendorf and Durand 2009; Shao et al. 2014).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import torch
from scipy.optimize import linprog, nnls
from scipy.sparse import coo_array, csc_array, hstack
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.stability.contacts import FRICTION, Contacts, plane_axes

_DIRECTIONS = 8  # in which gravity is tilted first
_AT_REST = 1e-6  # of gravity: what is less is rounding
_STEEP = 100.0  # the greatest tilt that is asked about, as a ratio: what holds then would hold on a wall


class Equations(NamedTuple):
    """Balance of M movable boxes: `forces @ x = weight + a * slope[0] + b * slope[1]`, x not negative.

    Args:
        forces: (6 M, G) what each generator of a friction pyramid does: three forces and three moments of each box.
        weight: (6 M,) what has to be carried, shares of all the weight there is; moments about the centres of mass.
        slope: (2, 6 M) what is to be carried besides where gravity tilts so that it pulls along +x, or +z, as much as
            it pulls down.
        body: (M,) box indices.
    """

    forces: csc_array
    weight: np.ndarray
    slope: np.ndarray
    body: np.ndarray


class Tilt(NamedTuple):
    """The least tilt of gravity for which something begins to move.

    Args:
        degrees: 0 where something moves already.
        direction: (2,) float64, in which gravity then pulls, x and z; NaN where nothing limits it, or all does.
    """

    degrees: float
    direction: Tensor


def equations(boxes: Boxes, movable: Tensor, contacts: Contacts, friction: float) -> Equations:
    """Assemble the balance of forces and moments.

    Args:
        boxes: N boxes of one density, world frame, +y up; movable: (N,) bool, the others hold whatever comes.
        contacts: where they touch.
        friction: coefficient.
    """
    body = movable.nonzero()[:, 0].numpy()
    row = np.full(len(movable) + 1, -1)  # the last place is that of the ground
    row[body] = np.arange(len(body))
    center = boxes.center.numpy()
    tangents = plane_axes(contacts.normal).numpy()
    normal = contacts.normal.numpy()[:, None]
    sides = friction * np.stack(
        [tangents[..., 0], -tangents[..., 0], tangents[..., 1], -tangents[..., 1]], axis=1
    )
    pyramid = normal + sides  # (P, 4, 3)
    size = float(np.abs(boxes.half_extent.numpy()).max(initial=0.0)) or 1.0
    blocks, rows, columns = [], [], []
    column = np.arange(4 * len(pyramid)).reshape(-1, 4)
    for box, sign in ((contacts.supported.numpy(), 1.0), (contacts.supporter.numpy(), -1.0)):
        mine = row[box] >= 0
        arm = contacts.point.numpy()[mine] - center[box[mine]]
        force = sign * pyramid[mine]
        wrench = np.concatenate([force, np.cross(arm[:, None], force) / size], axis=2)  # (K, 4, 6)
        first = 6 * row[box[mine]][:, None, None] + np.arange(6)
        blocks.append(wrench.ravel())
        rows.append(np.broadcast_to(first, wrench.shape).ravel())
        columns.append(np.broadcast_to(column[mine][:, :, None], wrench.shape).ravel())
    shape = (6 * len(body), column.size)
    forces = coo_array((np.concatenate(blocks), (np.concatenate(rows), np.concatenate(columns))), shape=shape)
    volume = boxes.volume().numpy()[body]
    share = volume / max(volume.sum(), 1e-300)
    weight, slope = np.zeros((len(body), 6)), np.zeros((2, len(body), 6))
    weight[:, 1], slope[0, :, 0], slope[1, :, 2] = share, -share, -share
    return Equations(forces.tocsc(), weight.ravel(), slope.reshape(2, -1), body)


def moving(boxes: Boxes, movable: Tensor, contacts: Contacts, friction: float = FRICTION) -> Tensor:
    """(N,) bool: boxes that begin to move, let go where they are; the arguments are those of `equations`."""
    system = equations(boxes, movable, contacts, friction)
    moves = torch.zeros(len(movable), dtype=torch.bool)
    if len(system.body) and not _balances(system):
        moves[torch.from_numpy(system.body)] = torch.from_numpy(_moving(system))
    return moves


def least_tilt(boxes: Boxes, movable: Tensor, contacts: Contacts, friction: float = FRICTION) -> Tilt:
    """The least tilt, in the worst direction; the arguments are those of `equations`."""
    system = equations(boxes, movable, contacts, friction)
    if not len(system.body):
        return Tilt(90.0, torch.full((2,), float("nan"), dtype=torch.float64))
    ratio, direction = _least_tilt(system) if _balances(system) else (0.0, np.full(2, np.nan))
    return Tilt(float(np.degrees(np.arctan(ratio))), torch.from_numpy(direction))


def _balances(system: Equations) -> bool:
    """Whether forces can carry the weight as it is."""
    if not system.forces.shape[1]:
        return False
    cost = np.zeros(system.forces.shape[1])
    found = linprog(cost, A_eq=system.forces, b_eq=system.weight, bounds=(0, None), method="highs")
    return bool(found.status == 0)


def _furthest(system: Equations, direction: np.ndarray) -> tuple[float, np.ndarray] | None:
    """How far gravity may tilt in a direction (2,), a ratio, and what limits it there; None where nothing balances.

    What limits it is the line `bound @ tilt = 1` in the plane of tilts, from the duals of the programme.
    """
    tilted = csc_array(-(direction @ system.slope)[:, None])
    matrix = hstack([system.forces, tilted], format="csc")
    cost = np.zeros(matrix.shape[1])
    cost[-1] = -1.0
    bounds = np.zeros((matrix.shape[1], 2))
    bounds[:, 1] = np.inf
    bounds[-1, 1] = _STEEP
    found = linprog(cost, A_eq=matrix, b_eq=system.weight, bounds=bounds, method="highs")
    if found.status != 0:
        return None
    dual = found.eqlin.marginals
    carried = -(dual @ system.weight)
    bound = (system.slope @ dual) / carried if abs(carried) > 1e-12 else np.zeros(2)
    return float(found.x[-1]), bound


def _least_tilt(system: Equations) -> tuple[float, np.ndarray]:
    """The nearest bound in the plane of tilts, a ratio, and the direction to it, (2,).

    The tilts that balance are convex. From each of some directions it is walked to the foot of the bound that is met,
    until a foot is met itself.
    """
    best, where = _STEEP, np.full(2, np.nan)
    for angle in np.arange(_DIRECTIONS) * 2 * np.pi / _DIRECTIONS:
        direction = np.array([np.cos(angle), np.sin(angle)])
        for _ in range(_DIRECTIONS):
            found = _furthest(system, direction)
            if found is None:
                return 0.0, direction
            reach, bound = found
            if reach < best:
                best, where = reach, direction
            steep = float(np.linalg.norm(bound))
            if steep <= 1.0 / _STEEP or 1.0 / steep > best - 1e-9:
                break
            direction = bound / steep
    return best, where


def _moving(system: Equations) -> np.ndarray:
    """(M,) bool: which boxes begin to move, where forces leave the least acceleration (Gauss's principle)."""
    if not system.forces.shape[1]:
        return np.ones(len(system.body), dtype=bool)
    inverse_root = np.repeat(1.0 / np.sqrt(system.weight.reshape(-1, 6)[:, 1]), 6)
    forces, residual = nnls(inverse_root[:, None] * system.forces.toarray(), inverse_root * system.weight)
    if residual < _AT_REST:
        return np.zeros(len(system.body), dtype=bool)
    left = (system.forces @ forces - system.weight).reshape(-1, 6)
    moving: np.ndarray = np.linalg.norm(left, axis=1) > _AT_REST * system.weight.reshape(-1, 6)[:, 1]
    return moving
