"""Eq. 5: how well segments cover true objects."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor

from blockstab.segments.atoms import Atoms, make_atoms
from blockstab.segments.segmentation import Segmentation
from models.overlap import Overlap

SIDE = 6


def grid() -> Atoms:
    """Eight atoms of 36 pixels in two rows of four."""
    label = (1 + torch.arange(8).view(2, 4)).repeat_interleave(SIDE, dim=0).repeat_interleave(SIDE, dim=1)
    return make_atoms(label, torch.zeros(label.shape, dtype=torch.float64))


def truth(*ids: int) -> Tensor:
    """The true id of each atom as a label image."""
    return torch.tensor(ids).view(2, 4).repeat_interleave(SIDE, dim=0).repeat_interleave(SIDE, dim=1)


def segmentation(*segments: set[int]) -> Segmentation:
    return Segmentation(tuple(frozenset(s) for s in segments))


def test_a_segment_that_is_an_object_scores_1():
    overlap = Overlap(grid(), truth(7, 7, 9, 9, 7, 7, 9, 9))
    assert overlap.best(segmentation({0, 1, 4, 5}, {2, 3, 6, 7})).tolist() == [1.0, 1.0]


@pytest.mark.parametrize(
    ("segment", "score"),
    [
        ({0, 1, 4}, 3 / 4),  # a part of the object
        ({0, 1, 2, 4, 5}, 4 / 5),  # the object and some of its neighbour
        ({0, 1, 2, 3, 4, 5, 6, 7}, 1 / 2),
        ({0, 2}, 1 / 5),
    ],
)
def test_the_score_is_intersection_over_union_with_the_best_object(segment, score):
    overlap = Overlap(grid(), truth(7, 7, 9, 9, 7, 7, 9, 9))
    assert overlap.best(segmentation(segment)).tolist() == [pytest.approx(score)]


def test_unlabelled_pixels_of_a_segment_do_not_count():
    overlap = Overlap(grid(), truth(7, 7, 0, 0, 7, 7, 9, 9))
    assert overlap.best(segmentation({0, 1, 2, 3, 4, 5})).tolist() == [1.0]
    assert overlap.best(segmentation({2, 3})).tolist() == [0.0]


def test_what_an_object_shows_outside_all_atoms_counts_against_the_segment():
    label = truth(7, 7, 9, 9, 7, 7, 9, 9)
    atoms = grid()
    hole = make_atoms(
        torch.where(atoms.label == 8, 0, atoms.label), torch.zeros(label.shape, dtype=torch.float64)
    )
    assert Overlap(hole, label).best(segmentation({2, 3, 6})).tolist() == [3 / 4]


@pytest.mark.parametrize(("segment", "owner"), [({0, 1, 2}, 7), ({1, 2, 3}, 9), ({4}, 0), ({3, 4}, 9)])
def test_the_owner_is_the_object_with_most_pixels(segment, owner):
    overlap = Overlap(grid(), truth(7, 7, 9, 9, 0, 7, 9, 9))
    assert overlap.owner(frozenset(segment)) == owner


def test_an_image_without_labels_owns_nothing():
    overlap = Overlap(grid(), truth(*[0] * 8))
    assert overlap.best(segmentation({0}, {1, 2})).tolist() == [0.0, 0.0]
    assert overlap.owner(frozenset({1, 2})) == 0
