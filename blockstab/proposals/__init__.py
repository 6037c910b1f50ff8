"""First guesses at the objects of an image, to be improved by a search."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

from torch import Tensor

from blockstab.observation import Observation


@dataclass(frozen=True)
class Proposed:
    """Regions of an image, each meant to be one object or one piece of background.

    Args:
        label: (H, W) int64; 0 = no region, ids carry no order.
        is_background: for ids of which the proposal knows it, whether they are background (table, floor, wall).
        scores: for ids of which the proposal says it, how sure it is of them; higher is surer.
    """

    label: Tensor
    is_background: Mapping[int, bool] = field(default_factory=dict)
    scores: Mapping[int, float] = field(default_factory=dict)


class Proposal(Protocol):
    """Segmentation method: divides an image into regions; a class with its settings, called once per image.

    One that reads a file for each scene has a method `stamp` too, from the scene's name to a word that changes
    whenever the file does.
    """

    def __call__(self, observation: Observation) -> Proposed:
        """Divide the image.

        Args:
            observation: the image, its points in the world frame, the ground, boundaries and atoms.

        Convention:
            The same image gives the same regions, bit for bit, in any process.
        """
        ...


def stamp_of(plugin: object, scene: str) -> str:
    """Stamp of the files that a plug-in reads for a scene, by its own `stamp`; empty where it has none."""
    stamp = getattr(plugin, "stamp", None)
    return "" if stamp is None else str(stamp(scene))
