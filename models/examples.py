"""Training rows: true segmentations, spoilt at random, and labelled by how much they still overlap the truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import torch
from torch import Tensor

from blockstab.boundaries.combination import Combination, FixedWeights
from blockstab.energy import Appearance
from blockstab.features.appearances import Appearances
from blockstab.features.merging import MERGE_COLUMNS
from blockstab.features.pairwise import PAIRWISE_COLUMNS, boundaries, pairs_of, pairwise_features
from blockstab.features.unary import UNARY_COLUMNS, unary_features
from blockstab.interpretation import Interpreter
from blockstab.percept import estimated_ground, perceive
from blockstab.proposals import Proposal
from blockstab.proposals.files import LabelFile
from blockstab.reasoning import Rules
from blockstab.rgbd.frame import Frame
from blockstab.scene import Scene
from blockstab.search.greedy import merge_rows
from blockstab.segments.hierarchy import build_hierarchy, split
from blockstab.view import View, make_view
from models.overlap import Overlap
from models.spoiling import spoil

GOOD_OVERLAP = 0.9  # "a positive training sample if score(s) >= 90%"
MERGES_JUDGED = 24  # pairs of one segmentation that are tried as merges
COLUMNS = {"unary": UNARY_COLUMNS, "pairwise": PAIRWISE_COLUMNS, "merge": MERGE_COLUMNS}


class Rows(NamedTuple):
    """Features (N, F) float64, and their targets (N,) float64: 0 is good, 1 is bad."""

    features: Tensor
    target: Tensor


class Examples(NamedTuple):
    """Rows for each potential."""

    unary: Rows
    pairwise: Rows
    merge: Rows


def joined(parts: Sequence[Examples]) -> Examples:
    """The rows of all parts, in order."""
    return Examples(
        *(
            Rows(torch.cat([r.features for r in rows]), torch.cat([r.target for r in rows]))
            for rows in zip(*parts, strict=True)
        )
    )


@dataclass(frozen=True)
class ExampleMaker:
    """Makes the examples of one image (paper, section 7.1).

    Both the true segmentation and that of a proposal are spoilt by random splits, by random merges, and by both. A
    segment is good if it overlaps a true object by 90 % (Eq. 5); a boundary, if both its segments are good; a
    merge, if both segments belong to one object.

    Args:
        proposal: segmentations as they come in practice.
        rules: how a segmentation is understood.
        variants: spoilt segmentations of each kind.
        boundaries: weighs the signs of an edge between two objects.
    """

    proposal: Proposal
    rules: Rules = field(default_factory=Rules)
    variants: int = 5
    boundaries: Combination = field(default_factory=FixedWeights)

    def __call__(self, frame: Frame, generator: torch.Generator) -> Examples:
        """Examples from one image.

        Raises:
            ValueError: if the image has no labels.
        """
        if frame.label is None:
            raise ValueError(f"{frame.name} has no label.png; training needs the true segments.")
        percept = perceive(frame, estimated_ground, self.boundaries)
        views = [make_view(percept, proposal) for proposal in (LabelFile(), self.proposal)]
        return joined([self._of_view(view, frame.label, generator) for view in views])

    def _of_view(self, view: View, label: Tensor, generator: torch.Generator) -> Examples:
        hierarchy = build_hierarchy(view.atoms)
        overlap = Overlap(view.atoms, label)
        percept, appearance = view.percept, Appearances(view.percept, view.atoms)
        interpret = Interpreter(percept.cloud, view.sight, percept.ground, view.atoms, self.rules, view.known)
        (start,) = interpret([view.start])
        background = zip(view.start.segments, start.background.tolist(), strict=True)
        objects = frozenset(atom for segment, apart in background if not apart for atom in segment)
        spoilt = [
            spoil(
                view.start, objects, kinds, lambda s: split(s, view.atoms, hierarchy), view.atoms, generator
            )
            for kinds in (("split",), ("merge",), ("split", "merge"))
            for _ in range(self.variants)
        ]
        scenes = interpret(list(dict.fromkeys([view.start, *spoilt])))
        parts = [_rows_of(scene, overlap, appearance) for scene in scenes]
        # Greedy merging starts from too many segments: from the start, and from what splits alone make of it.
        few = [scene for scene in scenes if len(scene) >= len(start)][: 1 + self.variants // 2]
        problem_rows = [self._merges(scene, overlap, interpret, appearance, generator) for scene in few]
        return joined([*parts, *problem_rows])

    def _merges(
        self,
        scene: Scene,
        overlap: Overlap,
        interpret: Interpreter,
        appearance: Appearance,
        generator: torch.Generator,
    ) -> Examples:
        pairs = pairs_of(scene)
        chosen = torch.randperm(len(pairs), generator=generator)[:MERGES_JUDGED].sort().values.tolist()
        pairs = [pairs[k] for k in chosen]
        if not pairs:
            return Examples(_no_rows("unary"), _no_rows("pairwise"), _no_rows("merge"))
        apart = [float(overlap.owner(a) != overlap.owner(b)) for a, b in pairs]
        features = merge_rows(scene, pairs, interpret, appearance)
        rows = Rows(features, torch.tensor(apart, dtype=torch.float64))
        return Examples(_no_rows("unary"), _no_rows("pairwise"), rows)


def _rows_of(scene: Scene, overlap: Overlap, appearance: Appearance) -> Examples:
    objects = ~scene.background
    bad = (overlap.best(scene.segmentation) < GOOD_OVERLAP).to(torch.float64)
    first, second = boundaries(scene)
    return Examples(
        Rows(unary_features(scene)[objects], bad[objects]),
        Rows(pairwise_features(scene, appearance(pairs_of(scene))), torch.maximum(bad[first], bad[second])),
        _no_rows("merge"),
    )


def _no_rows(kind: str) -> Rows:
    return Rows(torch.empty(0, len(COLUMNS[kind]), dtype=torch.float64), torch.empty(0, dtype=torch.float64))
