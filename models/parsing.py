"""Potentials that a parse can use: complete, and over the features of this version."""

from __future__ import annotations

from pathlib import Path
from typing import cast

from blockstab.features.merging import MERGE_COLUMNS
from blockstab.features.pairwise import PAIRWISE_COLUMNS
from blockstab.features.unary import UNARY_COLUMNS
from blockstab.parser import Potentials
from models.checkpoint import check_columns, load_potentials


def parsing_potentials(path: Path | str) -> Potentials:
    """Load potentials as `load_potentials` does.

    Raises:
        ValueError: also if they lack the merge potential, or speak of other features than the code computes.
    """
    found = load_potentials(path)
    if found.merge is None:
        raise ValueError(
            f"{path} holds no potential of merging, which a search starts with; train one with train.py."
        )
    check_columns(found.unary, UNARY_COLUMNS)
    check_columns(found.pairwise, PAIRWISE_COLUMNS)
    check_columns(found.merge, MERGE_COLUMNS)
    return cast(Potentials, found)  # its `merge` is there
