"""What is asked of an over-segmentation, in images small enough to count."""

from __future__ import annotations

import math

import pytest
import torch

from blockstab.evaluation.metrics import boundary_recall, inner_border, undersegmentation_error
from tests.evaluation.metrics.label_images import patches, two_squares

HALVES = torch.tensor([[1] * 5 + [2] * 5] * 4)  # 40 pixels


def test_atoms_within_the_regions_leak_nothing():
    atoms = torch.arange(40).view(4, 10) + 1
    assert undersegmentation_error(HALVES, atoms) == 0.0


def test_an_atom_leaks_its_smaller_part_in_both_regions_that_it_meets():
    atoms = torch.tensor([[1] * 6 + [2] * 4] * 4)  # one column, 4 pixels, reaches across
    assert undersegmentation_error(HALVES, atoms) == pytest.approx(2 * 4 / 40)


def test_pixels_without_label_in_either_do_not_count():
    atoms = torch.tensor([[1] * 6 + [2] * 4] * 4)
    atoms[0, 5] = 0  # three leak, of 36 pixels
    truth = HALVES.clone()
    truth[1:, 9] = 0
    assert undersegmentation_error(truth, atoms) == pytest.approx(2 * 3 / 36)


def test_without_pixels_there_is_no_leak_to_measure():
    assert math.isnan(undersegmentation_error(torch.zeros_like(HALVES), HALVES))


def test_leaks_are_those_of_counting_masks(generator):
    truth, atoms = patches((1, 2, 3), generator), patches(range(1, 9), generator)
    both = (truth > 0) & (atoms > 0)
    leaks = 0
    for region in truth[both].unique():
        for atom in atoms[both].unique():
            mask = both & (atoms == atom)
            inside = int((mask & (truth == region)).sum())
            leaks += min(inside, int(mask.sum()) - inside)
    assert undersegmentation_error(truth, atoms) == pytest.approx(leaks / int(both.sum()))


def test_a_border_that_is_followed_is_recalled():
    assert boundary_recall(inner_border(two_squares(), (3, 8)), two_squares(), 0.0) == 1.0


@pytest.mark.parametrize(("off", "recall"), [(2, 1.0), (3, 1.0), (4, 0.5), (5, 0.0)])
def test_a_border_counts_up_to_the_tolerance(off, recall):
    # The border's two pixels are 5 and 6 of 20; those of the atoms lie `off` further right.
    truth = torch.tensor([[1] * 6 + [2] * 14] * 3)
    atoms = torch.tensor([[1] * (6 + off) + [2] * (14 - off)] * 3)
    assert boundary_recall(inner_border(truth, (1, 2)), atoms, 3.0) == recall


def test_without_a_boundary_there_is_no_recall():
    assert math.isnan(boundary_recall(torch.zeros(4, 10, dtype=torch.bool), HALVES))


def test_sizes_must_agree():
    with pytest.raises(ValueError, match="of one size"):
        boundary_recall(torch.zeros(3, 10, dtype=torch.bool), HALVES)
    with pytest.raises(ValueError, match="of one size"):
        undersegmentation_error(HALVES[1:], HALVES)
