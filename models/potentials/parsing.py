"""Potentials that a parse can use: each picks its columns out of all that are computed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from torch import Tensor

from blockstab.features.columns import COLUMNS, SegmentColumns, computed
from models.potentials.checkpoint import Potentials, chosen_columns, load_potentials
from models.potentials.heads import HEADS, Potential


@dataclass(frozen=True)
class Choosing:
    """A potential of some of the columns.

    Args:
        potential: takes (N, F) features.
        columns: (F,) int64 where they stand among the columns it is given.
    """

    potential: Potential
    columns: Tensor

    def __call__(self, features: Tensor) -> Tensor:
        """Potentials (N,) of all columns (N, C)."""
        found: Tensor = self.potential(features[:, self.columns])
        return found

    def badness(self, features: Tensor) -> Tensor:
        """The probability, (N,) in [0, 1], that a segment or boundary is bad."""
        return self.potential.badness(features[:, self.columns])


@dataclass(frozen=True)
class ParsingPotentials:
    """Potentials as a parse uses them.

    Args:
        unary, pairwise, alone, background: over all columns of their kind.
        weight: of boundaries in the expected loss.
        name, sha256: as in `Potentials`.
    """

    unary: Choosing
    pairwise: Choosing
    alone: Choosing
    background: Choosing
    weight: float
    name: str
    sha256: str


def choosing(potentials: Potentials, columns: Sequence[SegmentColumns] = ()) -> ParsingPotentials:
    """The same potentials over all columns that are computed: those of this version, and some of one's own.

    Raises:
        CheckpointError: if they speak of other features.
    """
    kinds = {kind: getattr(potentials, kind) for kind in COLUMNS}
    all_columns = computed(columns)
    found = {
        kind: Choosing(potential, chosen_columns(potential, all_columns[kind]))
        for kind, potential in kinds.items()
    }
    return ParsingPotentials(
        **found, weight=potentials.weight, name=potentials.name, sha256=potentials.sha256
    )


def parsing_potentials(
    path: Path | str, heads: Mapping[str, type[Any]] = HEADS, columns: Sequence[SegmentColumns] = ()
) -> ParsingPotentials:
    """Load potentials as `load_potentials` does, ready for a parse."""
    return choosing(load_potentials(path, heads), columns)
