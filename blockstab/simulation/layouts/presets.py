"""The kinds of scenes that can be simulated: the like of the paper's Block, SOD and Grocery sets, desks and rooms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import torch

from blockstab.simulation.appearance.viewpoint import Setting
from blockstab.simulation.layouts.blocks import arrange_blocks
from blockstab.simulation.layouts.desk import arrange_desk
from blockstab.simulation.layouts.grocery import arrange_grocery
from blockstab.simulation.layouts.objects import arrange_objects
from blockstab.simulation.layouts.room import REACH, arrange_room
from blockstab.simulation.naming import named
from blockstab.simulation.physics.solids import Pile


@dataclass(frozen=True)
class Preset:
    """Preset for scenes of one kind.

    Args:
        arrange: draws a pile, not yet at rest, in the table frame.
        stacked_share: of a scene's objects stand on another object, at least.
        setting: what the pile stands on.
        reach: metres along x or z from the middle, beyond which a thing is lost.
    """

    arrange: Callable[[torch.Generator], Pile]
    stacked_share: float
    setting: Setting
    reach: float = 0.5


PRESETS: dict[str, Preset] = {
    "blocks": Preset(arrange_blocks, 1 / 3, "table"),
    "objects": Preset(arrange_objects, 0.1, "table"),
    "grocery": Preset(arrange_grocery, 0.1, "shelf"),
    "desk": Preset(arrange_desk, 0.0, "desk"),
    "room": Preset(arrange_room, 0.1, "room", REACH + 0.1),
}


def preset(name: str) -> Preset:
    """The preset of that name, or one of one's own that is named as `package.module.NAME`.

    Raises:
        ValueError: there is none.
    """
    return named("preset", name, PRESETS)
