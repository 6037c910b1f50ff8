"""Greedy merging, the paper's Stability row (section 6.1)."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.energy import Appearance
from blockstab.features.merging import merge_features
from blockstab.features.pairwise import pairs_of
from blockstab.features.unary import unary_features
from blockstab.interpretation import Interpreter
from blockstab.scene import Scene
from blockstab.search import Found, Problem
from blockstab.segments.segmentation import Pair, Segment, Segmentation


@dataclass(frozen=True)
class Greedy:
    """Merge the pair that most looks like one object, until none does.

    Args:
        threshold: pairs whose predicted badness of merging is below it are merged.
    """

    threshold: float = 0.5

    def __call__(self, start: Segmentation, problem: Problem, generator: torch.Generator) -> Found:
        """Merge from `start`; nothing is drawn at random."""
        (rating,) = problem.energy(problem.interpret([start]))
        trace, known = [rating.energy], dict[Pair, float]()
        while True:
            scene = rating.scene
            pairs = pairs_of(scene)
            _judge(scene, [pair for pair in pairs if pair not in known], problem, known)
            best = min(pairs, key=lambda pair: known[pair], default=None)
            if best is None or known[best] >= self.threshold:
                return Found(rating, tuple(trace))
            changed = set(best) | _neighbours(pairs, best)
            known = {pair: bad for pair, bad in known.items() if not changed & set(pair)}
            (rating,) = problem.energy(problem.interpret([_merged(scene.segmentation, best)]))
            trace.append(rating.energy)


def merge_rows(scene: Scene, pairs: list[Pair], interpret: Interpreter, appearance: Appearance) -> Tensor:
    """Features of merging each pair, (K, 121): every merge is understood in the whole scene, all in one batch."""
    merged = [_merged(scene.segmentation, pair) for pair in pairs]
    after = [
        unary_features(outcome)[outcome.segmentation.segments.index(first | second)]
        for outcome, (first, second) in zip(interpret(merged), pairs, strict=True)
    ]
    index = {segment: i for i, segment in enumerate(scene.segmentation.segments)}
    larger = torch.tensor([index[first] for first, _ in pairs], dtype=torch.long)
    smaller = torch.tensor([index[second] for _, second in pairs], dtype=torch.long)
    return merge_features(unary_features(scene), larger, smaller, torch.stack(after), appearance(pairs))


def _judge(scene: Scene, pairs: list[Pair], problem: Problem, known: dict[Pair, float]) -> None:
    """Add the predicted badness of merging each pair to `known`."""
    if pairs:
        rows = merge_rows(scene, pairs, problem.interpret, problem.energy.appearance)
        known.update(zip(pairs, problem.merge(rows).tolist(), strict=True))


def _neighbours(pairs: list[Pair], chosen: Pair) -> set[Segment]:
    return {segment for pair in pairs if set(chosen) & set(pair) for segment in pair}


def _merged(segmentation: Segmentation, pair: Pair) -> Segmentation:
    return segmentation.merge(segmentation.segments.index(pair[0]), segmentation.segments.index(pair[1]))
