"""A pile as a world of the physics engine MuJoCo (Todorov et al. 2012)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import torch
from torch import Tensor

from blockstab.simulation.physics.solids import Part, Pile

_TIMESTEP = 0.002  # seconds
_FRICTION = 0.7
_TORSION, _ROLLING = 0.005, 0.002  # metres: the arms by which friction resists spinning and rolling
_STIFF = [0.005, 1.0]  # a stack sinks in by less than half a millimetre
_FACING_UP = [math.sqrt(0.5), -math.sqrt(0.5), 0.0, 0.0]
_Y_FROM_Z = torch.tensor([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]], dtype=torch.float64)


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


def world(pile: Pile) -> tuple[Any, Any]:
    """The engine's model and state of a pile on a table; body i + 1 is solid i, body 0 the table."""
    mujoco = require_mujoco()
    spec = mujoco.MjSpec()
    spec.option.gravity = [0.0, -9.81, 0.0]
    spec.option.timestep = _TIMESTEP
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10.0  # without it, boxes at rest creep
    surface = {"friction": [_FRICTION, _TORSION, _ROLLING], "solref": _STIFF}
    plane = mujoco.mjtGeom.mjGEOM_PLANE
    spec.worldbody.add_geom(type=plane, size=[0, 0, 1], quat=_FACING_UP, **surface)
    for i, solid in enumerate(pile.solids):
        body = spec.worldbody.add_body(pos=pile.center[i].numpy(), quat=_quaternion(pile.rotation[i]))
        body.add_freejoint()
        for k, part in enumerate(solid.parts):
            shape = _geom(spec, part, f"{i}_{k}")
            body.add_geom(**shape, density=solid.density, condim=_condim(part), **surface)
    model = spec.compile()
    return model, mujoco.MjData(model)


def steps_of(seconds: float) -> int:
    """Number of steps of the engine in a time."""
    return round(seconds / _TIMESTEP)


def poses(data: Any, pile: Pile) -> Pile:
    """The pile where the engine has it now."""
    # mj_step moves qpos last, so the body frames it leaves behind are one step old.
    require_mujoco().mj_kinematics(data.model, data)
    center = torch.from_numpy(data.xpos[1:].copy())
    return Pile(pile.solids, center, torch.from_numpy(data.xmat[1:].reshape(-1, 3, 3).copy()))


def _geom(spec: Any, part: Part, name: str) -> dict[str, Any]:
    types = require_mujoco().mjtGeom
    pose = {"pos": part.center.numpy(), "quat": _quaternion(part.rotation)}
    half = part.half_extent.tolist()
    if part.form == "hull":
        assert part.points is not None
        spec.add_mesh(name=name, uservert=part.points.flatten().tolist())
        return {"type": types.mjGEOM_MESH, "meshname": name, **pose}
    if part.form == "cylinder":
        # The engine's cylinders stand along z.
        turned = _quaternion(part.rotation @ _Y_FROM_Z)
        return {"type": types.mjGEOM_CYLINDER, "size": [half[0], half[1], 0.0], **pose, "quat": turned}
    if part.form == "sphere":
        return {"type": types.mjGEOM_SPHERE, "size": [half[0], 0.0, 0.0], **pose}
    return {"type": types.mjGEOM_BOX, "size": half, **pose}


def _condim(part: Part) -> int:
    # Rolling friction is asked for where something can roll: it costs the solver three rows a contact.
    return 6 if part.form in ("sphere", "cylinder") else 3


def _quaternion(rotation: Tensor) -> np.ndarray[Any, np.dtype[np.float64]]:
    quaternion = np.zeros(4)
    require_mujoco().mju_mat2Quat(quaternion, rotation.flatten().numpy())
    return quaternion
