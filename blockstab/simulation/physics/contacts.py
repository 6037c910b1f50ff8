"""Support in a pile at rest, from the forces at its contacts: who carries whom, and how."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor

from blockstab.geometry.convex_hulls import hull
from blockstab.simulation.physics.engine import require_mujoco, world
from blockstab.simulation.physics.solids import Pile
from blockstab.stability.support import SupportType

CARRIES = 0.05  # share of an object's weight from which on another one supports it
_LISTEN_STEPS = 25  # over which forces are averaged
_STEEP = math.cos(math.radians(20.0))  # the paper's 20 degrees, section 5.2
_BROAD = 0.005  # metres; a patch of contact that is narrower is an edge or a corner


@dataclass(frozen=True)
class Contacts:
    """Supports of N solids, from contact forces; row i is solid i, and row N the table.

    Args:
        share: (N + 1, N) float64. Entry [i, j] is the upward part of the mean contact force of i on j,
            friction included, over the weight of j. It exceeds 1 where j carries other things too, and is 0
            where i does not push upwards.
        type: (N + 1, N) int64, values of `SupportType` where the share is `CARRIES` or more, else -1. If most
            of the force comes through contacts whose normals lean more than 20 degrees it is SIDE. Else it is
            SURFACE where the points of contact spread over more than 5 mm in every direction of the ground
            plane, and PARTIAL where they do not: an edge, a corner, the underside of a ball.
    """

    share: Tensor
    type: Tensor


@dataclass(frozen=True)
class _Touches:
    """C contacts heard: the bodies (C, 2), point (C, 3), normal (C, 3), and force on the second (C, 3), newtons."""

    bodies: Tensor
    point: Tensor
    normal: Tensor
    force: Tensor


def contacts(pile: Pile) -> Contacts:
    """Listen to the contacts of a pile at rest for a twentieth of a second."""
    model, data = world(pile)
    heard = _heard(model, data)
    n = len(pile) + 1
    weight = torch.from_numpy(model.body_mass[1:] * np.linalg.norm(model.opt.gravity))
    # Every contact is heard from both sides.
    supporter, supported = heard.bodies.T.flatten(), heard.bodies.flip(1).T.flatten()
    upward = torch.cat([heard.force[:, 1], -heard.force[:, 1]]) / _LISTEN_STEPS
    total = torch.zeros(n * n, dtype=torch.float64).index_add(0, supporter * n + supported, upward)
    # Body 0 is the table, whose row is to be the last.
    share = (total.view(n, n)[:, 1:] / weight).clamp(min=0.0).roll(-1, dims=0)
    kind = torch.full_like(share, -1, dtype=torch.int64)
    for i, j in (share >= CARRIES).nonzero().tolist():
        kind[i, j] = _type(heard, (i + 1) % n, j + 1)
    return Contacts(share, kind)


def _heard(model: Any, data: Any) -> _Touches:
    mujoco = require_mujoco()
    bodies, points, frames, forces = [], [], [], []
    for _ in range(_LISTEN_STEPS):
        mujoco.mj_step(model, data)
        force = np.zeros((data.ncon, 6))
        for k in range(data.ncon):
            mujoco.mj_contactForce(model, data, k, force[k])
        bodies.append(model.geom_bodyid[data.contact.geom])
        points.append(data.contact.pos.copy())
        frames.append(data.contact.frame.reshape(-1, 3, 3).copy())  # the rows are the axes
        forces.append(force[:, :3])
    axes, local = (torch.from_numpy(np.concatenate(part)) for part in (frames, forces))
    return _Touches(
        torch.from_numpy(np.concatenate(bodies)).long(),
        torch.from_numpy(np.concatenate(points)),
        axes[:, 0],
        (local[:, :, None] * axes).sum(dim=1),
    )


def _type(heard: _Touches, supporter: int, supported: int) -> SupportType:
    mine = ((heard.bodies == torch.tensor([supporter, supported])).all(dim=1)) | (
        (heard.bodies == torch.tensor([supported, supporter])).all(dim=1)
    )
    weight = heard.force[mine].norm(dim=1)
    on_top = heard.normal[mine, 1].abs() > _STEEP
    if float(weight[on_top].sum()) <= float(weight[~on_top].sum()):
        return SupportType.SIDE
    patch = heard.point[mine][on_top][:, [0, 2]]
    return SupportType.SURFACE if _width(patch) > _BROAD else SupportType.PARTIAL


def _width(points: Tensor) -> float:
    """Spread of P points (P, 2) in the direction in which they spread least."""
    corners = hull(points[None])
    corner = corners.vertices[0, : int(corners.count[0])]
    if len(corner) < 3:
        return 0.0
    # A convex polygon is narrowest across one of its sides.
    side = corner.roll(-1, dims=0) - corner
    across = torch.stack([-side[:, 1], side[:, 0]], dim=1) / side.norm(dim=1, keepdim=True)
    reach = across @ corner.T
    return float((reach.amax(dim=1) - reach.amin(dim=1)).amin())
