"""Eq. 5: how well segments cover true objects."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor

from blockstab.segments.atoms import Atoms, make_atoms
from blockstab.segments.overlap import Overlap
from blockstab.segments.segmentation import Segment

SIDE = 6


def grid() -> Atoms:
    """Eight atoms of 36 pixels in two rows of four."""
    label = (1 + torch.arange(8).view(2, 4)).repeat_interleave(SIDE, dim=0).repeat_interleave(SIDE, dim=1)
    return make_atoms(label, torch.zeros(label.shape, dtype=torch.float64))


def truth(*ids: int) -> Tensor:
    """The true id of each atom as a label image."""
    return torch.tensor(ids).view(2, 4).repeat_interleave(SIDE, dim=0).repeat_interleave(SIDE, dim=1)


def segments(*atoms: set[int]) -> list[Segment]:
    return [frozenset(some) for some in atoms]


def test_a_segment_that_is_an_object_scores_1():
    overlap = Overlap(grid(), truth(7, 7, 9, 9, 7, 7, 9, 9))
    assert overlap.best(segments({0, 1, 4, 5}, {2, 3, 6, 7})).tolist() == [1.0, 1.0]


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
    assert overlap.best(segments(segment)).tolist() == [pytest.approx(score)]


def test_unlabelled_pixels_of_a_segment_do_not_count():
    overlap = Overlap(grid(), truth(7, 7, 0, 0, 7, 7, 9, 9))
    assert overlap.best(segments({0, 1, 2, 3, 4, 5})).tolist() == [1.0]
    assert overlap.best(segments({2, 3})).tolist() == [0.0]


def test_what_an_object_shows_outside_all_atoms_counts_against_the_segment():
    label = truth(7, 7, 9, 9, 7, 7, 9, 9)
    atoms = grid()
    hole = make_atoms(
        torch.where(atoms.label == 8, 0, atoms.label), torch.zeros(label.shape, dtype=torch.float64)
    )
    assert Overlap(hole, label).best(segments({2, 3, 6})).tolist() == [3 / 4]


def test_background_is_no_object_that_a_segment_could_cover():
    overlap = Overlap(grid(), truth(1, 1, 9, 9, 1, 1, 9, 9), background=(1,))
    assert overlap.best(segments({0, 1, 4, 5}, {2, 3, 6, 7})).tolist() == [0.0, 1.0]
    # A table in a segment of an object makes it larger than the object.
    assert overlap.best(segments({1, 2, 3, 6, 7})).tolist() == [pytest.approx(4 / 5)]


def test_the_share_of_things_is_that_of_the_pixels_on_true_objects():
    overlap = Overlap(grid(), truth(1, 1, 9, 9, 0, 0, 9, 9), background=(1,))
    shares = overlap.thing_share(segments({0, 1}, {1, 2}, {2, 3}, {2, 3, 4}, {4, 5}))
    assert shares.tolist() == [0.0, pytest.approx(1 / 2), 1.0, pytest.approx(2 / 3), 0.0]


def test_an_image_without_labels_has_no_object_to_cover():
    overlap = Overlap(grid(), truth(*[0] * 8))
    assert overlap.best(segments({0}, {1, 2})).tolist() == [0.0, 0.0]
    assert overlap.thing_share(segments({0}, {1, 2})).tolist() == [0.0, 0.0]
