"""The truth, drawn on the atoms: the best that any search over them could find."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from scipy.ndimage import distance_transform_edt
from torch import Tensor

from blockstab.search import SearchResult
from blockstab.search.problem import Problem
from blockstab.segments.segmentation import Segmentation

NEAR_PX = 12  # pixels so near to labelled ones, as in the shadow of an object, count as these


@dataclass(frozen=True)
class Truth:
    """Takes each atom to the true object that most of its pixels have. For ceilings and for training."""

    def __call__(self, start: Segmentation, problem: Problem, generator: torch.Generator) -> SearchResult:
        """Rate the start, then the truth; ValueError if the image has no labels."""
        return SearchResult.of(problem.rate([start, true_segmentation(problem)]))


def true_segmentation(problem: Problem) -> Segmentation:
    """The true segments, told which are background.

    Pixels beside labelled ones, as in the shadow of an object, count as these. Atoms further off, of which the labels
    say nothing, stay together as the start of the problem has them.
    """
    search_input = problem.search_input
    frame, atoms = search_input.observation.frame, search_input.atoms
    if frame.label is None:
        raise ValueError(f"{frame.name} has no label.png; the truth needs one.")
    near = _near_labels(frame.label)
    truth = Segmentation.from_labels(atoms, near)
    label, told = truth.labels(atoms), {}
    for number, segment in enumerate(truth.segments, start=1):
        ids = near[label == number]
        told[segment] = int(ids[ids > 0].mode().values) in frame.background_ids
    labelled = frozenset().union(*truth.segments)
    rest = {s - labelled: s for s in search_input.start.segments if s - labelled}
    told.update(
        {r: search_input.start.background[s] for r, s in rest.items() if s in search_input.start.background}
    )
    return Segmentation(tuple(sorted([*truth.segments, *rest], key=min))).telling(told)


def _near_labels(label: Tensor) -> Tensor:
    """(H, W) the labels, and within `NEAR_PX` of them that of the nearest pixel that has one."""
    if not bool((label > 0).any()):
        return label
    away, (row, column) = distance_transform_edt((label == 0).numpy(), return_indices=True)
    nearest = label[torch.from_numpy(row).long(), torch.from_numpy(column).long()]
    return torch.where(torch.from_numpy(away) <= NEAR_PX, nearest, 0)
