"""Ways to look for the segmentation of least energy. A search is any callable of the shape `Search`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import torch

from blockstab.energy import Energy, Potential, Rating
from blockstab.interpretation import Interpreter
from blockstab.segments.segmentation import Segment, Segmentation


@dataclass(frozen=True)
class Problem:
    """All that a search may ask.

    Args:
        interpret: understands segmentations of the image.
        energy: rates scenes; lower is better.
        merge: features of possible merges (K, 121) to (K,): 0 for pairs that should merge, else 1.
        split: the two parts that a segment falls into first, or None if it cannot be split.
    """

    interpret: Interpreter
    energy: Energy
    merge: Potential
    split: Callable[[Segment], tuple[Segment, Segment] | None]


@dataclass(frozen=True)
class Found:
    """What a search came to: its best scene, and the energy of the best it kept after each step."""

    best: Rating
    trace: tuple[float, ...]


class Search(Protocol):
    """From a segmentation to a better one."""

    def __call__(self, start: Segmentation, problem: Problem, generator: torch.Generator) -> Found: ...
