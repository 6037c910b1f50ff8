"""Overlap of segments with true regions, against values worked by hand and against counting pixels."""

from __future__ import annotations

import math
from itertools import product

import pytest
import torch
from torch import Tensor

from blockstab.evaluation.metrics import intersection_over_union, overlap_score
from blockstab.evaluation.metrics.overlap import contingency
from tests.evaluation.metrics.label_images import patches, scattered, two_squares
from tests.tolerance import EXACT


def test_the_truth_itself_scores_1():
    assert overlap_score(two_squares(), two_squares(), (3, 8)) == 1.0


def test_ids_carry_no_order():
    assert overlap_score(two_squares(), torch.where(two_squares() == 3, 900, two_squares()), (3, 8)) == 1.0


def test_two_equal_objects_seen_as_one_score_a_half():
    assert overlap_score(two_squares(), (two_squares() > 0).long(), (3, 8)) == 0.5


def test_one_object_seen_as_two_halves_scores_a_half():
    assert overlap_score((two_squares() > 0).long(), two_squares(), (1,)) == 0.5


@pytest.mark.parametrize(("unlabelled", "score"), [("penalise", 0.5), ("mask", 1.0)])
def test_a_segment_that_lies_half_on_unlabelled_pixels_scores_a_half_unless_these_are_masked(
    unlabelled, score
):
    truth = torch.where(two_squares() == 3, 3, 0)
    assert overlap_score(truth, (two_squares() > 0).long(), (3,), unlabelled=unlabelled) == score


def test_true_pixels_that_nothing_was_found_on_count_even_if_unlabelled_ones_are_masked():
    found = torch.where(two_squares() == 3, 1, 0)
    assert overlap_score((two_squares() > 0).long(), found, unlabelled="mask") == 0.5


@pytest.mark.parametrize(("weighting", "score"), [("area", 0.8), ("region", 0.5)])
def test_objects_count_by_their_area_or_each_alike(weighting, score):
    truth = torch.zeros(1, 10, dtype=torch.long)
    truth[0, :8], truth[0, 8:] = 1, 2
    found = torch.where(truth == 1, 5, 0)  # the smaller one is missed
    assert overlap_score(truth, found, (1, 2), weighting) == pytest.approx(score)
    assert overlap_score(truth, found, (1,), weighting) == 1.0
    assert overlap_score(truth, found, (2,), weighting) == 0.0


def test_all_regions_are_scored_where_none_are_named():
    found = torch.where(two_squares() == 3, 5, 0)
    assert overlap_score(two_squares(), found) == 0.5


def test_background_that_is_not_scored_still_takes_pixels_from_segments():
    truth = torch.where(two_squares() == 8, 1, two_squares())  # 1 is the table
    assert overlap_score(truth, (truth > 0).long(), (3,), unlabelled="mask") == 0.5


def test_where_nothing_is_found_the_score_is_0():
    assert overlap_score(two_squares(), torch.zeros_like(two_squares()), (3, 8)) == 0.0


@pytest.mark.parametrize("objects", [(), (77,)])
def test_without_objects_there_is_no_score(objects):
    assert math.isnan(overlap_score(two_squares(), two_squares(), objects))


def test_images_of_different_sizes_are_refused():
    with pytest.raises(ValueError, match=r"truth has \(6, 10\), the prediction \(5, 10\)"):
        overlap_score(two_squares(), two_squares()[1:], (3,))


@pytest.mark.parametrize("choice", [{"weighting": "pixel"}, {"unlabelled": "ignore"}])
def test_a_choice_that_is_none_is_refused(choice):
    with pytest.raises(ValueError, match="Weighting must be area or region"):
        overlap_score(two_squares(), two_squares(), **choice)


def counted(truth: Tensor, found: Tensor, regions: list[int], weighting: str, unlabelled: str) -> float:
    """The score by masks, region by region, as it is written down."""
    best, weight = [], []
    for region in regions:
        mask = truth == region
        ious = [0.0]
        for segment in found.unique().tolist():
            if segment > 0:
                seen = (found == segment) & ((truth > 0) if unlabelled == "mask" else torch.tensor(True))
                ious.append(int((mask & seen).sum()) / int((mask | seen).sum()))
        best.append(max(ious))
        weight.append(int(mask.sum()) if weighting == "area" else 1)
    return sum(w * b for w, b in zip(weight, best, strict=True)) / sum(weight)


@pytest.mark.parametrize(("weighting", "unlabelled"), list(product(("area", "region"), ("penalise", "mask"))))
def test_the_score_is_that_of_comparing_masks(weighting, unlabelled, generator):
    for _ in range(10):
        truth, found = patches((9, 4, 70, 5), generator), patches((1, 2, 3, 8, 11), generator)
        regions = [region for region in truth.unique().tolist() if region in (4, 5, 9)]
        expected = counted(truth, found, regions, weighting, unlabelled)
        assert overlap_score(truth, found, regions, weighting, unlabelled) == pytest.approx(
            expected, abs=EXACT
        )


def test_intersection_over_union_is_that_of_counting_pixels(generator):
    truth, found = scattered((0, 4, 7, 300), generator), scattered((0, 2, 3, 9, 11), generator)
    table, ids = intersection_over_union(truth, found)
    assert ids.tolist() == [4, 7, 300]
    for (g, true_id), (s, found_id) in product(enumerate((4, 7, 300)), enumerate((2, 3, 9, 11))):
        both, either = (truth == true_id) & (found == found_id), (truth == true_id) | (found == found_id)
        assert float(table[g, s]) == int(both.sum()) / int(either.sum())


def test_a_table_has_no_row_or_column_for_what_has_no_label():
    nothing = torch.zeros(4, 4, dtype=torch.long)
    table, ids = intersection_over_union(nothing, nothing + 1)
    assert table.shape == (0, 1)
    assert len(ids) == 0


def test_areas_are_those_of_the_whole_regions():
    truth = torch.tensor([[0, 0, 5, 5, 6]])
    found = torch.tensor([[2, 2, 2, 0, 0]])
    table = contingency(truth, found)
    assert table.pixels.tolist() == [[1], [0]]
    assert (table.true_px.tolist(), table.found_px.tolist()) == ([2, 1], [3])
