"""Columns that describe segments, pairs and lone segments, and the sets of them that training may choose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from torch import Tensor

from blockstab.features.box_shape import BOX_SHAPE_COLUMNS
from blockstab.features.contour import CONTOUR_COLUMNS
from blockstab.features.pairwise import PAIRWISE_COLUMNS
from blockstab.features.surface import SURFACE_COLUMNS
from blockstab.features.unary import UNARY_COLUMNS
from blockstab.observation import Observation
from blockstab.scene.types import Scene
from blockstab.segments.atoms import Atoms

LONE_COLUMNS = (*CONTOUR_COLUMNS, *SURFACE_COLUMNS)
SEGMENT_COLUMNS = (*UNARY_COLUMNS, *BOX_SHAPE_COLUMNS, *LONE_COLUMNS)
COLUMNS = {
    "unary": SEGMENT_COLUMNS,
    "pairwise": PAIRWISE_COLUMNS,
    "alone": LONE_COLUMNS,
    "background": LONE_COLUMNS,
}
"""The columns that are always computed, for each kind of potential."""

_STABILITY = ("stable", "stable_alone", "offset_from_", "support", "stable_larger", "stable_smaller")


class SegmentColumns(Protocol):
    """Columns of one's own, beside ours: what else segments show in a scene."""

    @property
    def columns(self) -> tuple[str, ...]:
        """Their names, which differ from all others."""

    def __call__(self, observation: Observation, atoms: Atoms, scene: Scene, /) -> Tensor:
        """Values (N, C) of the N segments of a scene, which are sets of atoms; finite."""


def computed(own: Sequence[SegmentColumns]) -> dict[str, tuple[str, ...]]:
    """All columns for each kind of potential, where some of one's own stand after ours for segments in a scene.

    Raises:
        ValueError: if two have one name.
    """
    names = [*SEGMENT_COLUMNS, *(name for part in own for name in part.columns)]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ValueError(f"Columns must differ by name, but {', '.join(twice)} came twice; rename yours.")
    return {**COLUMNS, "unary": tuple(names)}


@dataclass(frozen=True)
class FeatureSet:
    """The columns that the potentials of segments and of pairs see.

    Args:
        unary, pairwise: names, in the order of `COLUMNS`.
    """

    unary: tuple[str, ...]
    pairwise: tuple[str, ...]

    def of(self, kind: str, own: Sequence[SegmentColumns] = ()) -> tuple[str, ...]:
        """The names for one kind of potential: those of lone segments have no choice, one's own are all chosen."""
        if kind == "unary":
            return (*self.unary, *(name for part in own for name in part.columns))
        chosen: tuple[str, ...] = {"pairwise": self.pairwise}.get(kind, COLUMNS[kind])
        return chosen


def without_stability(columns: tuple[str, ...]) -> tuple[str, ...]:
    """The columns that boxes give without asking what stands."""
    return tuple(name for name in columns if not name.startswith(_STABILITY))


PAPER = FeatureSet(UNARY_COLUMNS, PAIRWISE_COLUMNS)
FEATURE_SETS = {
    "paper": PAPER,
    "paper_without_stability": FeatureSet(
        without_stability(UNARY_COLUMNS), without_stability(PAIRWISE_COLUMNS)
    ),
    "all": FeatureSet(SEGMENT_COLUMNS, PAIRWISE_COLUMNS),
    "without_stability": FeatureSet(without_stability(SEGMENT_COLUMNS), without_stability(PAIRWISE_COLUMNS)),
}


def feature_set(name: str) -> FeatureSet:
    """The set of that name: Table 1's (`paper`), or all; or either without what stability adds (the paper's S/P).

    Raises:
        ValueError: if there is none.
    """
    if name not in FEATURE_SETS:
        raise ValueError(f"There is no feature set {name!r}; choose from: {', '.join(FEATURE_SETS)}.")
    return FEATURE_SETS[name]
