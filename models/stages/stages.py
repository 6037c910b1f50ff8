"""The learned stages of merging on disk: boosted trees in LightGBM's own text, within one JSON file."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, get_args

import torch
from torch import Tensor

from blockstab.features.appearance.pair_columns import APPEARANCE_COLUMNS, Variant
from blockstab.proposals.silberman import Silberman
from models.potentials.trees import booster
from models.shipped import read_learned, write_learned

FORMAT = 1
MAX_BYTES = 64 * 2**20


@dataclass(frozen=True)
class BoostedStage:
    """One stage's trees.

    Args:
        threshold: least confidence at which regions are merged.
        trees: LightGBM's text; its raw score is the log-odds that an edgelet lies within one object.
    """

    threshold: float
    trees: str

    def __call__(self, appearance: Tensor) -> Tensor:
        """Confidence (L,) from features (L, 51): the probability that the trees have learned.

        Silberman et al. sum halves of log-odds, and put the logistic function of that sum beside the thresholds.
        Their trees are added whole; these are shrunk as they are added, and with halves of their sum the same
        thresholds leave objects in pieces.
        """
        if not len(appearance):
            return appearance.new_zeros(0)
        return torch.from_numpy(self._read().predict(appearance.numpy(), num_threads=1))

    def check(self) -> None:
        """Raises ValueError, in one line, if the trees cannot be read."""
        self._read()

    def _read(self) -> Any:
        return booster(self.trees, len(APPEARANCE_COLUMNS))


@dataclass(frozen=True, repr=False)
class StagedMerging:
    """Stages as `load_stages` reads them.

    Args:
        variant: of the features.
        stages: in order.
        provenance: what their maker wrote down.
    """

    variant: Variant
    stages: tuple[BoostedStage, ...]
    provenance: dict[str, Any] = field(compare=False)

    def __repr__(self) -> str:
        """Tells stages apart in a few letters, where their trees would fill pages."""
        return f"StagedMerging({_digest(self.variant, self.stages)[:16]})"


def silberman(stages: Path | str = "silberman", **settings: Any) -> Silberman:
    """The proposal with stages of that name or path; `settings` are those of `Silberman`."""
    return Silberman(load_stages(stages), **settings)


def save_stages(path: Path, merging: StagedMerging) -> None:
    """Write a JSON file, whole or not at all."""
    record = {
        "format": FORMAT,
        "variant": merging.variant,
        "columns": list(APPEARANCE_COLUMNS),
        "sha256": _digest(merging.variant, merging.stages),
        "stages": [{"threshold": s.threshold, "trees": s.trees} for s in merging.stages],
        "provenance": merging.provenance,
    }
    write_learned(path, record)


def load_stages(path: Path | str) -> StagedMerging:
    """Read what `save_stages` wrote.

    Args:
        path: of the JSON file; or a name without folder and suffix, of stages that come with this package.

    Raises:
        CheckpointError: naming the file and what is wrong with it.
    """
    return read_learned(path, "stages", FORMAT, MAX_BYTES, _merging)


def _merging(record: dict[str, Any]) -> StagedMerging:
    if record["columns"] != list(APPEARANCE_COLUMNS) or record["variant"] not in get_args(Variant):
        raise ValueError("it speaks of other features than this version computes; train it anew.")
    stages = tuple(BoostedStage(float(s["threshold"]), str(s["trees"])) for s in record["stages"])
    if record["sha256"] != _digest(record["variant"], stages):
        raise ValueError("its checksum does not fit its trees; copy the file again.")
    if not isinstance(record["provenance"], dict):
        raise ValueError("provenance must be an object.")
    for stage in stages:
        stage.check()
    return StagedMerging(record["variant"], stages, record["provenance"])


def _digest(variant: str, stages: tuple[BoostedStage, ...]) -> str:
    said = json.dumps([variant, [[s.threshold, s.trees] for s in stages]])
    return hashlib.sha256(said.encode()).hexdigest()
