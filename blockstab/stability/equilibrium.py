"""Static equilibrium of rigid boxes: can forces of contact, with friction, carry them?

Forces act at the corners of contact patches and lie in friction pyramids. That they balance weights and moments is a
set of linear equations in what is not negative (Whiting, Ochsendorf and Durand 2009; Shao et al. 2014).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import torch
from scipy.optimize import linprog, nnls
from scipy.sparse import coo_array, csc_array
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.stability.contacts import FRICTION, Contacts, plane_axes

_AT_REST = 1e-6  # of gravity: what is less is rounding


class Equations(NamedTuple):
    """Balance of M movable boxes: `forces @ x = weight + a * slope[0] + b * slope[1]`, x not negative.

    Args:
        forces: (6 M, G) what each generator of a friction pyramid does: three forces and three moments of each box.
        weight: (6 M,) what has to be carried, shares of all the weight there is; moments about the centres of mass.
        slope: (2, 6 M) what is to be carried besides where gravity tilts so that it pulls along +x, or +z, as much as
            it pulls down.
        body: (M,) box indices.
        size: metres by which moments are divided.
    """

    forces: csc_array
    weight: np.ndarray
    slope: np.ndarray
    body: np.ndarray
    size: float


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
    center, point = boxes.center.detach().numpy(), contacts.point.detach().numpy()
    pyramid = pyramids(contacts.normal, friction).detach().numpy()
    size = float(np.abs(boxes.half_extent.detach().numpy()).max(initial=0.0)) or 1.0
    blocks, rows, columns = [], [], []
    column = np.arange(4 * len(pyramid)).reshape(-1, 4)
    for box, sign in ((contacts.supported.numpy(), 1.0), (contacts.supporter.numpy(), -1.0)):
        mine = row[box] >= 0
        arm = point[mine] - center[box[mine]]
        force = sign * pyramid[mine]
        wrench = np.concatenate([force, np.cross(arm[:, None], force) / size], axis=2)  # (K, 4, 6)
        first = 6 * row[box[mine]][:, None, None] + np.arange(6)
        blocks.append(wrench.ravel())
        rows.append(np.broadcast_to(first, wrench.shape).ravel())
        columns.append(np.broadcast_to(column[mine][:, :, None], wrench.shape).ravel())
    shape = (6 * len(body), column.size)
    forces = coo_array((np.concatenate(blocks), (np.concatenate(rows), np.concatenate(columns))), shape=shape)
    volume = boxes.volume().detach().numpy()[body]
    share = volume / max(volume.sum(), 1e-300)
    weight, slope = np.zeros((len(body), 6)), np.zeros((2, len(body), 6))
    weight[:, 1], slope[0, :, 0], slope[1, :, 2] = share, -share, -share
    return Equations(forces.tocsc(), weight.ravel(), slope.reshape(2, -1), body, size)


def pyramids(normal: Tensor, friction: float) -> Tensor:
    """Generators (P, 4, 3) of friction pyramids about normals (P, 3): what a contact can exert is a sum of these."""
    tangents = friction * plane_axes(normal).transpose(1, 2)
    return normal[:, None] + torch.cat([tangents, -tangents], dim=1)


def moving(boxes: Boxes, movable: Tensor, contacts: Contacts, friction: float = FRICTION) -> Tensor:
    """(N,) bool: boxes that begin to move, let go where they are; the arguments are those of `equations`."""
    system = equations(boxes, movable, contacts, friction)
    moves = torch.zeros(len(movable), dtype=torch.bool)
    if len(system.body) and not balances(system):
        moves[torch.from_numpy(system.body)] = torch.from_numpy(_moving(system))
    return moves


def balances(system: Equations) -> bool:
    """Whether forces can carry the weight as it is."""
    if not system.forces.shape[1]:
        return False
    cost = np.zeros(system.forces.shape[1])
    found = linprog(cost, A_eq=system.forces, b_eq=system.weight, bounds=(0, None), method="highs")
    return bool(found.status == 0)


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
