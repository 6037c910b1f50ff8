"""Which columns describe segments, pairs and lone segments, and the sets of them that training may choose."""

from __future__ import annotations

from dataclasses import dataclass

from blockstab.features.box_shape import BOX_SHAPE_COLUMNS
from blockstab.features.contour import CONTOUR_COLUMNS
from blockstab.features.pairwise import PAIRWISE_COLUMNS
from blockstab.features.surface import SURFACE_COLUMNS
from blockstab.features.unary import UNARY_COLUMNS

LONE_COLUMNS = (*CONTOUR_COLUMNS, *SURFACE_COLUMNS)
SEGMENT_COLUMNS = (*UNARY_COLUMNS, *BOX_SHAPE_COLUMNS, *LONE_COLUMNS)
COLUMNS = {
    "unary": SEGMENT_COLUMNS,
    "pairwise": PAIRWISE_COLUMNS,
    "alone": LONE_COLUMNS,
    "background": LONE_COLUMNS,
}
"""All columns that are computed for each kind of potential."""

_STABILITY = ("stable", "stable_alone", "offset_from_", "support", "stable_larger", "stable_smaller")


@dataclass(frozen=True)
class FeatureSet:
    """The columns that the potentials of segments and of pairs see.

    Args:
        unary, pairwise: names, in the order of `COLUMNS`.
    """

    unary: tuple[str, ...]
    pairwise: tuple[str, ...]

    def of(self, kind: str) -> tuple[str, ...]:
        """The names for one kind of potential; those of lone segments have no choice."""
        chosen: tuple[str, ...] = {"unary": self.unary, "pairwise": self.pairwise}.get(kind, COLUMNS[kind])
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
