"""Simulated scenes with exact truth: settled by physics, seen by ray casting, measured by a depth sensor."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from importlib.metadata import version
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor

from blockstab.datasets.truth import MIN_VISIBLE_PX, ObjectTruth, Truth
from blockstab.determinism.threads import one_thread
from blockstab.rgbd.frame import Frame
from blockstab.simulation.appearance.rendering import TABLE, Picture, photograph
from blockstab.simulation.appearance.room import furnish
from blockstab.simulation.appearance.viewpoint import Viewpoint, draw_view
from blockstab.simulation.layouts.presets import Preset, preset
from blockstab.simulation.physics.contacts import Contacts, contacts
from blockstab.simulation.physics.settling import falls, settle
from blockstab.simulation.physics.solids import Pile
from blockstab.simulation.sensors import sensor
from blockstab.stability.support import SupportType

VERSION = 5  # raised whenever the same seed makes another scene than before
_ATTEMPTS = 50


class Arranged(NamedTuple):
    """Arrangement of solids that a picture is taken of.

    Args:
        pile: in the table frame.
        held: who carries whom; None where it does not rest.
        moves: (N,) bool, which would move if they were let go; None where it rests.
    """

    pile: Pile
    held: Contacts | None
    moves: Tensor | None = None


@dataclass(frozen=True)
class Recipe:
    """Recipe of a set of scenes.

    Args:
        preset: a key of `PRESETS`, or the path of a preset of one's own.
        seed: not negative.
        sensor: a key of `SENSORS`, or the path of a class of one's own.
        variety: from 0, plain colours under one light, to 1, the full range of materials and lights.

    Raises:
        ValueError: a name is not known, or a number is out of range.
    """

    preset: str = "blocks"
    seed: int = 0
    sensor: str = "kinect"
    variety: float = 1.0

    def __post_init__(self) -> None:
        preset(self.preset)
        sensor(self.sensor)
        if self.seed < 0:
            raise ValueError(f"A seed must not be negative, but is {self.seed}.")
        if not 0.0 <= self.variety <= 1.0:
            raise ValueError(f"Variety must lie between 0 and 1, but is {self.variety}.")

    def scene(self, index: int) -> str:
        """Name of scene number `index`."""
        return f"{self.preset.rpartition('.')[2]}_{index:04d}"

    def origin(self, index: int) -> dict[str, Any]:
        """Origin of scene number `index`, as its meta.json records it."""
        versions = {name: version(name) for name in ("blockstab", "mujoco")}
        return {**asdict(self), "index": index, "recipe": VERSION, "versions": versions}

    def generator(self, index: int) -> torch.Generator:
        """Generator of all that is random in scene number `index`."""
        entropy = np.random.SeedSequence((self.seed, index)).generate_state(1, np.uint64)
        return torch.Generator().manual_seed(int(entropy[0]))

    def arranged(self, generator: torch.Generator) -> Arranged:
        """A pile at rest."""
        return Arranged(*resting_pile(preset(self.preset), generator))


def simulate_scene(recipe: Recipe, index: int) -> tuple[Frame, Truth]:
    """Scene number `index` of a recipe; the same to the bit whenever it is made on the same machine.

    Returns:
        The image, and the truth about it. In the label image 1 is the table, 2 and up are the objects, then
        come the other parts of the room. What carries 5 % of an object's weight or more by contact, friction
        included, supports it.

    Raises:
        ModuleNotFoundError: MuJoCo is not installed.
    """
    kind, eye, generator = preset(recipe.preset), sensor(recipe.sensor), recipe.generator(index)
    with one_thread():
        arranged = recipe.arranged(generator)
        pile = arranged.pile
        view = draw_view(generator, pile, eye, kind.setting)
        room = furnish(generator, view, pile, kind.setting)
        picture = photograph(recipe.scene(index), pile, view, room, eye, recipe.variety, generator)
        return picture.frame, _truth(arranged, view, picture)


def resting_pile(kind: Preset, generator: torch.Generator) -> tuple[Pile, Contacts]:
    """A pile at rest, and who carries whom in it."""
    for _ in range(_ATTEMPTS):
        pile = settle(kind.arrange(generator), kind.reach)
        if pile is None:
            continue
        held = contacts(pile)
        carried = held.type >= 0
        stacked = carried[:-1].any(dim=0).to(torch.float64).mean()
        if float(stacked) >= kind.stacked_share and bool(carried.any(dim=0).all()):
            return pile, held
    raise RuntimeError(f"None of {_ATTEMPTS} arrangements came to rest with enough of it stacked.")


def _truth(arranged: Arranged, view: Viewpoint, picture: Picture) -> Truth:
    pile = arranged.pile
    seen = view.in_camera(pile.boxes())
    label = picture.frame.label
    assert label is not None
    measured = torch.where(picture.frame.depth > 0, label, 0)
    relations = _relations(arranged)
    objects = []
    for i, solid in enumerate(pile.solids):
        own = i + TABLE + 1
        pose = torch.eye(4, dtype=torch.float64)
        pose[:3, :3], pose[:3, 3] = seen.rotation[i], seen.center[i]
        objects.append(
            ObjectTruth(
                id=own,
                kind=solid.kind,
                half_extent=solid.half_extent,
                pose_camera=pose,
                category=solid.style,
                total_pixels=int(picture.total_pixels[i]),
                hardly_seen=int((measured == own).sum()) < MIN_VISIBLE_PX,
                **relations[i],
            )
        )
    frame = picture.frame
    rests = arranged.held is not None
    return Truth(frame.background_ids, tuple(objects), frame.up_camera, rests, boundary_of(label))


def _relations(arranged: Arranged) -> list[dict[str, Any]]:
    """Of each solid what `ObjectTruth` says of how it stands: who carries it, and what falls without it."""
    if arranged.held is None:
        assert arranged.moves is not None
        return [{"moves": moved} for moved in arranged.moves.tolist()]
    fallen, found = falls(arranged.pile), []
    for i in range(len(arranged.pile)):
        # The table's row is the last, and its id is the lowest.
        type_by_id = arranged.held.type[:, i].roll(1)
        supporters = (type_by_id >= 0).nonzero().flatten()
        found.append(
            {
                "supported_by": tuple((supporters + TABLE).tolist()),
                "falls_if_removed": tuple((fallen[i].nonzero().flatten() + TABLE + 1).tolist()),
                "support_types": tuple(SupportType(t).name.lower() for t in type_by_id[supporters].tolist()),
            }
        )
    return found


def boundary_of(surface: Tensor) -> Tensor:
    """Boundaries between things, (2, H, W) bool as in `Truth`, from the things (H, W) seen."""
    boundary = torch.zeros(2, *surface.shape, dtype=torch.bool)
    boundary[0, :, :-1] = surface[:, :-1] != surface[:, 1:]
    boundary[1, :-1] = surface[:-1] != surface[1:]
    return boundary
