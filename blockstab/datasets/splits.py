"""Splits of a set into scenes for training and for testing: drawn once, kept in a file, and named in results."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from reprlib import repr as shown
from typing import Protocol

import numpy as np

from blockstab.datasets.sets import SceneSet
from blockstab.output.export import write_whole
from blockstab.rgbd.reading import FrameError, read_meta

Parts = Mapping[str, Sequence[str]]

_LONGEST_NAME = 160  # bytes of a file's name; file systems take 255, and a temporary name is longer


class Split(Protocol):
    """A way to part a set. A class with its settings, whose `name` tells them all."""

    @property
    def name(self) -> str:
        """Of the split, fit to be part of a file's name."""

    def __call__(self, data: SceneSet) -> Parts:
        """Names of scenes by part."""


@dataclass(frozen=True)
class Whole:
    """One part, `all`."""

    name: str = "whole"

    def __call__(self, data: SceneSet) -> Parts:
        """Every scene."""
        return {"all": data.scenes()}


@dataclass(frozen=True)
class Official:
    """The split that came with the set."""

    name: str = "official"

    def __call__(self, data: SceneSet) -> Parts:
        """Parts as their authors call them, most often `train` and `test`.

        Raises:
            ValueError: no split came with the set.
        """
        parts = data.official()
        if not parts:
            raise ValueError(f"No split came with {data.name}; choose split=halves or split=folds.")
        return parts


@dataclass(frozen=True)
class Halves:
    """`train` and `test`, half of the scenes each, drawn at random as in the paper (section 8).

    Args:
        seed: of the draw.
        together: so many scenes that follow each other in the set, which may be nearly alike, go one way.
    """

    seed: int = 0
    together: int = 1

    @property
    def name(self) -> str:
        """Tells seed and `together`."""
        return f"halves_seed{self.seed}_together{self.together}"

    def __call__(self, data: SceneSet) -> Parts:
        """The two halves; the first has one run of scenes more where their number is odd."""
        train, test = _dealt(data, 2, self.seed, self.together)
        return {"train": train, "test": test}


@dataclass(frozen=True)
class Folds:
    """`train0`, `test0`, `train1`, ...: each scene is tested in one of `count` folds, and trains in the others.

    Args:
        count: number of folds.
        seed, together: as in `Halves`.
    """

    count: int = 4
    seed: int = 0
    together: int = 1

    @property
    def name(self) -> str:
        """Tells count, seed and `together`."""
        return f"folds{self.count}_seed{self.seed}_together{self.together}"

    def __call__(self, data: SceneSet) -> Parts:
        """Two parts for each fold."""
        folds = _dealt(data, self.count, self.seed, self.together)
        parts: dict[str, list[str]] = {}
        for i, fold in enumerate(folds):
            parts[f"train{i}"] = [scene for scene in data.scenes() if scene not in set(fold)]
            parts[f"test{i}"] = fold
        return parts


def scenes_of(data: SceneSet, split: Split, part: str, kept: Path) -> list[str]:
    """The scenes of one part of a split, in the order of the set.

    The split is read from `kept/<set>_<split>.json`, shortened where that is too long for a file. It is written, the
    folder too, when it is first asked for.

    Raises:
        ValueError: there is no such part, or it is empty.
        FrameError: the file that keeps the split is damaged, or names scenes that the set has not.
    """
    file = kept / _file_name(f"{data.name}_{split.name}")
    if not file.exists():
        drawn = {name: list(scenes) for name, scenes in split(data).items()}
        kept.mkdir(parents=True, exist_ok=True)
        write_whole(
            file, (json.dumps({"set": data.name, "split": split.name, "parts": drawn}, indent=1)).encode()
        )
    parts = _parts_in(file)
    if not parts.get(part):
        raise ValueError(f"{file}: there are no scenes in part {part!r}; choose from {shown(list(parts))}.")
    known = data.scenes()
    strangers = sorted(set(parts[part]) - set(known))
    if strangers:
        raise FrameError(
            f"{file}: it must name scenes of {data.name}, but {shown(strangers[0])} is none; remove the file to "
            "draw anew."
        )
    chosen = set(parts[part])
    return [scene for scene in known if scene in chosen]


def _file_name(name: str) -> str:
    """A file's name, which says the whole where a file system takes that, and else the beginning and a digest."""
    name = name.replace("/", "-").replace(" ", "_")
    if len(name.encode()) <= _LONGEST_NAME:
        return f"{name}.json"
    return f"{name[: _LONGEST_NAME // 4]}_{hashlib.sha256(name.encode()).hexdigest()[:16]}.json"


def _parts_in(file: Path) -> dict[str, list[str]]:
    parts = read_meta(file).values.get("parts")
    names = isinstance(parts, dict) and all(
        isinstance(scenes, list) and all(isinstance(s, str) for s in scenes) for scenes in parts.values()
    )
    if not names:
        raise FrameError(f"{file}: parts must hold lists of scene names; remove the file to draw anew.")
    return dict(parts)  # type: ignore[arg-type]


def _dealt(data: SceneSet, hands: int, seed: int, together: int) -> list[list[str]]:
    """The scenes dealt out in runs; each hand is in the order of the set."""
    scenes = data.scenes()
    runs = [scenes[i : i + together] for i in range(0, len(scenes), max(together, 1))]
    if together < 1 or hands < 2 or len(runs) < hands:
        raise ValueError(
            f"{data.name} has {len(scenes)} scenes, which {hands} parts cannot share in runs of {together}; "
            "ask for fewer parts or shorter runs."
        )
    order = np.random.default_rng(seed).permutation(len(runs))
    return [[s for i in sorted(order[hand::hands]) for s in runs[i]] for hand in range(hands)]
