"""What falls if a thing is taken away: as a parse says it, and as simpler guesses do, against what the engine saw."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping

import torch

from blockstab.datasets.truth import Truth
from blockstab.evaluation.metrics import intersection_over_union
from blockstab.evaluation.scoring.prediction import Prediction, Score, seen
from blockstab.rgbd.frame import Frame

Fallen = Mapping[int, set[int]]  # by id, the ids of what falls without it
Guess = Callable[[Prediction], Fallen]
Alike = Callable[[set[int], set[int]], bool]  # of what falls in truth, and as it was told
_MATCHED = 0.5  # intersection over union of a segment that stands for a thing


def falls(prediction: Prediction) -> Fallen:
    """What the parse says."""
    return {int(taken): set(fallen) for taken, fallen in prediction.record["falls_if_removed"].items()}


def reachable(prediction: Prediction) -> Fallen:
    """All that rests or leans on a thing, or on something that does: a search in the graph of supports."""
    edges = [(edge["supporter"], edge["supported"]) for edge in prediction.record["supports"]]
    return {s["id"]: reached(s["id"], edges) for s in prediction.record["segments"]}


def reached(start: int, edges: list[tuple[int, int]]) -> set[int]:
    """All ends of paths along edges from one id."""
    found, new = set[int](), {start}
    while new:
        new = {b for a, b in edges if a in new} - found - {start}
        found |= new
    return found


def nothing(prediction: Prediction) -> Fallen:
    """Nothing falls, which is so of most things."""
    return {}


def agreement(guess: Guess, alike: Alike) -> Callable[[Prediction, Frame, Truth], Score]:
    """The score of a guess at what falls without each thing."""

    def score(prediction: Prediction, frame: Frame, truth: Truth) -> Score:
        return agreed(_asked(guess(prediction), prediction, frame, truth), alike)

    return score


def agreed(asked: Iterable[tuple[set[int], set[int]]], alike: Alike) -> Score:
    """Of pairs of what falls in truth and as it was told, those that are alike."""
    right = [alike(true, told) for true, told in asked]
    return Score(float(sum(right)), len(right))


def any_falls(true: set[int], told: set[int]) -> bool:
    """Whether it was told right if anything falls."""
    return bool(true) == bool(told)


def exact_set(true: set[int], told: set[int]) -> bool:
    """Whether it was told right just what falls."""
    return true == told


def _asked(
    fallen: Fallen, prediction: Prediction, frame: Frame, truth: Truth
) -> Iterator[tuple[set[int], set[int]]]:
    """What falls without each thing that can be seen, of what can be seen: in truth, and as it was told.

    A segment stands for the thing with which it shares half of the pixels of either; of a thing that no segment
    stands for, nothing is told.
    """
    scored = [o for o in seen(frame, truth) if o.falls_if_removed is not None]
    name = _names(prediction, frame)
    told = {
        name[taken]: {name[i] for i in some if i in name} for taken, some in fallen.items() if taken in name
    }
    ids = {o.id for o in scored}
    for o in scored:
        yield set(o.falls_if_removed or ()) & ids, told.get(o.id, set()) & ids


def _names(prediction: Prediction, frame: Frame) -> dict[int, int]:
    """By id of a segment, that of the thing for which it stands."""
    assert frame.label is not None
    shared, true = intersection_over_union(frame.label, prediction.label)
    found = torch.unique(prediction.label[prediction.label > 0])
    matched = (shared >= _MATCHED).nonzero().tolist()
    return {int(found[segment]): int(true[thing]) for thing, segment in matched}
