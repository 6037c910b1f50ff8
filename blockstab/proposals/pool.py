"""Pools of masks: segments that may be objects, from which a search carves."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol

from blockstab.proposals import Proposal, stamp_of
from blockstab.proposals.plane_pieces import Planes
from blockstab.proposals.search_input import SearchInput
from blockstab.proposals.watershed import Watershed
from blockstab.segments.segmentation import Segment, Segmentation


class Pool(Protocol):
    """A source of masks: a class with its settings, called once per image."""

    def __call__(self, search_input: SearchInput, /) -> Sequence[Segment]:
        """Masks of the image as sets of atoms; they may overlap, and repeat each other."""


@dataclass(frozen=True)
class NoMasks:
    """Nothing is offered beside the nodes of the hierarchy."""

    def __call__(self, search_input: SearchInput) -> list[Segment]:
        """None."""
        return []


@dataclass(frozen=True)
class Regions:
    """The regions of proposals, each as the atoms that lie mostly in it.

    Args:
        proposals: any number; mask files of another segmenter among them, whose masks may overlap.
    """

    proposals: Sequence[Proposal] = (Watershed(0.15), Watershed(0.3), Watershed(0.7), Planes())

    def __call__(self, search_input: SearchInput) -> list[Segment]:
        """The regions of all proposals."""
        return [segment for proposal in self.proposals for segment in self._regions(proposal, search_input)]

    def _regions(self, proposal: Proposal, search_input: SearchInput) -> Iterable[Segment]:
        return Segmentation.from_labels(search_input.atoms, proposal(search_input.observation).label).segments

    def stamp(self, scene: str) -> str:
        """Of the files that the proposals read for a scene."""
        stamps = [stamp_of(proposal, scene) for proposal in self.proposals]
        return " ".join(stamps) if any(stamps) else ""
