"""Things stood on things, and one structure placed beside another without overlap.

Structures stand on the plane y = 0 of their own frame (right-handed, +y up, metres), near its origin. They are
built in exact contact; `lifted` then makes them what a hand lets go of.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import torch
from torch import Tensor

from blockstab.boxes.separation import separation
from blockstab.simulation.layouts.draws import choice, whole
from blockstab.simulation.physics.solids import Pile, Solid, concatenate

Structure = Callable[[torch.Generator], Pile]

LIFT = 0.001  # metres; so low a drop does not upset a structure
UPRIGHT = torch.eye(3, dtype=torch.float64)
_CLEARANCE = 0.003  # metres between structures
_TRIES = 100  # places tried for a structure, further and further out
_DRAWS = 20  # structures drawn for one more place, where nothing else is said
_REACH = 0.45  # metres from the middle of the table that a corner may be
_LEVEL = 1e-6  # metres; lowest points closer than this are at one level


def about(axis: int, angle: Tensor | float) -> Tensor:
    """Rotations (..., 3, 3) by `angle` (...) radians about axis 0, 1 or 2."""
    angle = torch.as_tensor(angle, dtype=torch.float64)
    first, second = (axis + 1) % 3, (axis + 2) % 3
    turn = torch.eye(3, dtype=torch.float64).repeat(*angle.shape, 1, 1)
    turn[..., first, first] = turn[..., second, second] = angle.cos()
    turn[..., second, first] = angle.sin()
    turn[..., first, second] = -angle.sin()
    return turn


def about_up(yaw: Tensor | float) -> Tensor:
    """Rotations (..., 3, 3) by `yaw` (...) radians about +y."""
    return about(1, yaw)


def stand(
    solid: Solid, x: float = 0.0, z: float = 0.0, on: float = 0.0, yaw: float = 0.0, tilt: Tensor = UPRIGHT
) -> Pile:
    """A pile of one solid whose bounding box has its lowest point at height `on`.

    Args:
        x, z: where the centre is, metres.
        yaw: radians about +y, after `tilt`.
        tilt: (3, 3) rotation from the pose in which the solid stands as it should.
    """
    rotation = about_up(yaw) @ tilt
    y = on + float(rotation[1].abs() @ solid.half_extent)
    return Pile((solid,), torch.tensor([[x, y, z]], dtype=torch.float64), rotation[None])


def leaning(solid: Solid, slope: float, edge: float, x: float) -> Pile:
    """The solid with its lower end on y = 0 and its lower face on an edge along z at (x, `edge`)."""
    long, thick = solid.half_extent[:2].tolist()
    c, s = math.cos(slope), math.sin(slope)
    # Its lower face goes up from the ground at this distance before the edge.
    foot = x - edge / math.tan(slope)
    return stand(solid, foot + long * c - thick * s, tilt=about(2, slope))


def height(solid: Solid) -> float:
    """Height of the solid where it stands as it should, metres."""
    return 2.0 * float(solid.half_extent[1])


def shifted(pile: Pile, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Pile:
    """The same pile somewhere else."""
    return Pile(pile.solids, pile.center + torch.tensor([x, y, z], dtype=torch.float64), pile.rotation)


def lifted(pile: Pile) -> Pile:
    """A structure whose every level hangs `LIFT` above the one below, and what leans above all it may lean on."""
    lowest = pile.boxes().corners()[..., 1].amin(dim=1)
    _, level = torch.unique((lowest / _LEVEL).round(), return_inverse=True)
    tilted = pile.rotation[:, 1].abs().amax(dim=1) < 1.0 - _LEVEL
    up = LIFT * (1.0 + level + tilted * (1.0 + level.max()))
    return Pile(pile.solids, pile.center + up[:, None] * torch.eye(3, dtype=torch.float64)[1], pile.rotation)


def side_by_side(
    generator: torch.Generator,
    structures: Sequence[Structure],
    goal: tuple[int, int],
    most: int,
    reach: float = _REACH,
    draws: int = _DRAWS,
) -> Pile:
    """Draw structures and place one beside another.

    Args:
        reach: metres from the middle that a corner may be.
        draws: of structures, at most.

    Returns:
        A pile in the table frame of at least as many solids as a number drawn from `goal` (least, greatest),
        where they fit, and never more than `most`.
    """
    enough = whole(generator, *goal)
    parts: list[Pile] = []
    for _ in range(draws):
        room = most - sum(map(len, parts))
        if most - room >= enough:
            break
        structure = lifted(choice(generator, structures)(generator))
        placed = beside(generator, structure, parts, reach) if len(structure) <= room else None
        parts += [] if placed is None else [placed]
    return concatenate(parts)


def beside(
    generator: torch.Generator, structure: Pile, parts: list[Pile], reach: float = _REACH
) -> Pile | None:
    """Turn and shift a structure to a free place near the middle; None where there is none within reach, metres."""
    for attempt in range(_TRIES):
        yaw, angle, share = torch.rand(3, generator=generator, dtype=torch.float64)
        radius = float(reach * attempt / _TRIES * share.sqrt())
        angle = float(2 * math.pi * angle)
        turned = structure.moved(about_up(2 * math.pi * yaw), torch.zeros(3, dtype=torch.float64))
        moved = shifted(turned, x=radius * math.cos(angle), z=radius * math.sin(angle))
        in_reach = bool((moved.boxes().corners()[..., [0, 2]].norm(dim=-1) < reach).all())
        if in_reach and (not parts or clear(moved, concatenate(parts), _CLEARANCE)):
            return moved
    return None


def clear(first: Pile, second: Pile, clearance: float) -> bool:
    """True if all bounding boxes of one pile are at least `clearance` metres from all of the other."""
    boxes, radius = concatenate([first, second]).boxes(), torch.cat([_radius(first), _radius(second)])
    i = torch.arange(len(first)).repeat_interleave(len(second))
    j = len(first) + torch.arange(len(second)).repeat(len(first))
    # Most pairs are so far apart that their centres alone tell: along an axis of a box these are 1 / sqrt(3) of their
    # distance apart at least, and along none do both boxes together reach further than their half diagonals.
    near = (boxes.center[i] - boxes.center[j]).norm(dim=1) < 3**0.5 * (radius[i] + radius[j] + clearance)
    return bool((separation(boxes, i[near], j[near]).gap >= clearance).all())


def _radius(pile: Pile) -> Tensor:
    radius: Tensor = pile.boxes().half_extent.norm(dim=1)
    return radius
