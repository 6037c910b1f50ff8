"""Boxes at rest on a table: where they settle, who carries whom, what falls (MuJoCo; Todorov et al. 2012).

The table frame: right-handed, +y up, metres; the table is the plane y = 0.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import torch
from torch import Tensor

from blockstab.boxes.box import Boxes

DENSITY = 600.0  # kg per cubic metre, as of wood; one for all, since the paper takes weight to be volume
FRICTION = 0.7
_TIMESTEP = 0.002  # seconds
_LONGEST_SETTLE = 4.0  # seconds
_WATCH = 0.5  # seconds for which a thing at rest must keep its pose
_REST_SHIFT = 0.0005  # metres
_REST_TURN = math.radians(0.2)
_REST_SPEED = 0.005  # metres and radians a second
_LISTEN_STEPS = 25  # over which contact forces are averaged
_FALL_SECONDS = 1.5
_FALL_SHIFT = 0.02  # metres
_FALL_TURN = math.radians(10.0)


def require_mujoco() -> Any:
    """The physics engine, which only simulation needs.

    Raises:
        ModuleNotFoundError: it is not installed.
    """
    try:
        import mujoco
    except ModuleNotFoundError:
        raise ModuleNotFoundError(
            "Simulating scenes needs MuJoCo, which is not installed; run: pip install 'blockstab[sim]'"
        ) from None
    return mujoco


def settle(boxes: Boxes) -> Boxes | None:
    """Let go of boxes and wait until they rest.

    Returns:
        The boxes as they lie: for half a second each has moved less than 0.5 mm and turned less than 0.2
        degrees, and all speeds are below 5 mm/s and 5 mrad/s. None where that does not happen within 4 s.
    """
    mujoco = require_mujoco()
    model, data = _world(boxes)
    before = boxes
    for _ in range(round(_LONGEST_SETTLE / _WATCH)):
        mujoco.mj_step(model, data, round(_WATCH / _TIMESTEP))
        after = _poses(data, boxes)
        still = bool(np.abs(data.qvel).max() < _REST_SPEED)
        if still and not bool(_moved(before, after, _REST_SHIFT, _REST_TURN).any()):
            return after
        before = after
    return None


def carried_share(boxes: Boxes) -> Tensor:
    """How much of the weight of each of N resting boxes each other box, and the table, carries.

    Returns:
        (N + 1, N) float64. Entry [i, j] is the upward part of the mean contact force of i on j, friction
        included, over the weight of j; the last row is the table's. It exceeds 1 where j carries other boxes
        too, and is 0 where i does not push upwards.
    """
    mujoco = require_mujoco()
    model, data = _world(boxes)
    upward = np.zeros((len(boxes) + 1, len(boxes) + 1))  # geom 0 is the table, geom i + 1 is box i
    force = np.zeros(6)
    for _ in range(_LISTEN_STEPS):
        mujoco.mj_step(model, data)
        rows = data.contact.frame.reshape(-1, 3, 3)  # the rows are the axes of the contact frame
        for k, (first, second) in enumerate(data.contact.geom):
            mujoco.mj_contactForce(model, data, k, force)
            on_second = float(rows[k, :, 1] @ force[:3])
            upward[first, second] += on_second
            upward[second, first] -= on_second
    weight = model.body_mass[1:] * np.linalg.norm(model.opt.gravity)
    share = np.roll(upward[:, 1:] / (_LISTEN_STEPS * weight), -1, axis=0)
    return torch.from_numpy(share).clamp(min=0.0)


def falls(boxes: Boxes) -> Tensor:
    """What falls when one of N resting boxes is taken away, found by taking it away.

    Returns:
        (N, N) bool: [i, j] where j moves more than 2 cm, or turns by more than 10 degrees, within 1.5 s
        after i is gone.
    """
    mujoco = require_mujoco()
    n = len(boxes)
    result = torch.zeros(n, n, dtype=torch.bool)
    for i in range(n):
        others = torch.tensor([j for j in range(n) if j != i], dtype=torch.int64)
        left = boxes[others]
        model, data = _world(left)
        mujoco.mj_step(model, data, round(_FALL_SECONDS / _TIMESTEP))
        result[i, others] = _moved(left, _poses(data, left), _FALL_SHIFT, _FALL_TURN)
    return result


def _world(boxes: Boxes) -> tuple[Any, Any]:
    mujoco = require_mujoco()
    spec = mujoco.MjSpec()
    spec.option.gravity = [0.0, -9.81, 0.0]
    spec.option.timestep = _TIMESTEP
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10.0  # without it, boxes at rest creep
    friction = [FRICTION, 0.005, 0.0001]
    stiff = [0.005, 1.0]  # a stack sinks in by less than half a millimetre
    facing_up = [math.sqrt(0.5), -math.sqrt(0.5), 0.0, 0.0]
    plane = mujoco.mjtGeom.mjGEOM_PLANE
    spec.worldbody.add_geom(type=plane, size=[0, 0, 1], quat=facing_up, friction=friction, solref=stiff)
    quaternion = np.zeros(4)
    for i in range(len(boxes)):
        mujoco.mju_mat2Quat(quaternion, boxes.rotation[i].flatten().numpy())
        body = spec.worldbody.add_body(pos=boxes.center[i].numpy(), quat=quaternion)
        body.add_freejoint()
        half = boxes.half_extent[i].numpy()
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX, size=half, density=DENSITY, friction=friction, solref=stiff
        )
    model = spec.compile()
    return model, mujoco.MjData(model)


def _poses(data: Any, boxes: Boxes) -> Boxes:
    # mj_step moves qpos last, so the body frames it leaves behind are one step old.
    require_mujoco().mj_kinematics(data.model, data)
    center = torch.from_numpy(data.xpos[1:].copy())
    return Boxes(center, torch.from_numpy(data.xmat[1:].reshape(-1, 3, 3).copy()), boxes.half_extent)


def _moved(before: Boxes, after: Boxes, shift: float, turn: float) -> Tensor:
    distance = (after.center - before.center).norm(dim=1)
    # The chord between two rotations a small angle t apart is 2 sqrt(2) sin(t / 2).
    chord = (after.rotation - before.rotation).flatten(1).norm(dim=1)
    fell: Tensor = (distance > shift) | (chord > 2.0 * math.sqrt(2.0) * math.sin(turn / 2.0))
    return fell
