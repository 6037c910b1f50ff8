"""Precision and recall of objects, against values worked by hand and against trying all matches."""

from __future__ import annotations

import math
from itertools import permutations

import pytest
import torch
from torch import Tensor

from blockstab.evaluation.metrics import PrecisionRecall, object_scores
from tests.evaluation.metrics.label_images import patches, two_squares
from tests.tolerance import EXACT

NOTHING = torch.zeros(6, 10, dtype=torch.int64)


def bar(start: int, stop: int, identity: int = 1) -> Tensor:
    """An object from one column of 40 up to another, over rows 5 to 14 of 20."""
    label = torch.zeros(20, 40, dtype=torch.int64)
    label[5:15, start:stop] = identity
    return label


def test_the_truth_itself_is_perfect():
    scores = object_scores(two_squares(), two_squares() * 7)
    assert scores.overlap == scores.boundary == (1.0, 1.0)
    assert scores.detected == 1.0


@pytest.mark.parametrize(
    ("truth", "found", "expected", "detected"),
    [
        (two_squares(), NOTHING, (1.0, 0.0), 0.0),
        (NOTHING, two_squares(), (0.0, 1.0), 0.0),
        (NOTHING, NOTHING, (1.0, 1.0), 1.0),
    ],
)
def test_of_nothing_no_share_is_wrong(truth, found, expected, detected):
    scores = object_scores(truth, found)
    assert scores.overlap == scores.boundary == expected
    assert scores.detected == detected


def test_one_region_over_two_objects_is_matched_with_one_of_them():
    scores = object_scores(two_squares(), (two_squares() > 0).long())
    assert scores.overlap == (0.5, 0.5)
    assert scores.detected == 0.0  # F is 2/3


def test_of_an_object_in_two_halves_one_counts():
    scores = object_scores((two_squares() > 0).long(), two_squares())
    assert scores.overlap == (0.5, 0.5)


def test_a_part_has_full_precision_and_its_share_of_recall():
    scores = object_scores(bar(10, 20), bar(10, 16))
    assert scores.overlap == (1.0, pytest.approx(0.6))
    assert scores.overlap.f_measure == pytest.approx(0.75)
    assert scores.detected == 1.0  # 0.75 itself is enough


def test_the_matches_have_the_greatest_sum_not_each_the_greatest_f():
    truth = torch.tensor([[1] * 10 + [2] * 6])
    found = torch.tensor([[4] * 4 + [3] * 6 + [3] * 6])
    # F of 3: 12/22 with 1, 12/18 with 2; of 4: 8/14 with 1. Greedy and best agree: 3 with 2, 4 with 1.
    assert object_scores(truth, found).overlap == (10 / 16, 10 / 16)
    found = torch.tensor([[3] * 7 + [4] * 3 + [3] * 5 + [0]])
    # F: 3 with 1 14/22, 3 with 2 10/18, 4 with 1 6/13: the greatest one, 3 with 1, would leave 4 alone.
    assert object_scores(truth, found).overlap == (8 / 15, 8 / 16)


@pytest.mark.parametrize(("off", "recall"), [(3, 1.0), (4, 0.5)])
def test_outlines_agree_up_to_the_tolerance(off, recall):
    # A bar of full height: its outline is two columns.
    truth, found = (torch.zeros(20, 60, dtype=torch.int64) for _ in range(2))
    truth[:, 10:30], found[:, 10 : 30 + off] = 1, 1
    scores = object_scores(truth, found)
    assert scores.boundary == (recall, recall)
    assert scores.overlap.recall == 1.0


def test_only_the_outline_of_the_match_counts():
    truth, found = bar(10, 20, 1) + bar(20, 30, 2), bar(10, 20, 5)
    scores = object_scores(truth, found)
    # The side that both true objects share is recalled once, for the first.
    assert scores.boundary.precision == 1.0
    assert scores.boundary.recall == pytest.approx(0.5)


def test_background_is_no_object_in_either():
    truth, found = torch.where(two_squares() == 0, 1, two_squares()), two_squares() + 1
    scores = object_scores(truth, found, true_background=(1,), found_background=(1,))
    assert scores.overlap == (1.0, 1.0)
    assert object_scores(truth, found).overlap == (1.0, 1.0)
    assert object_scores(truth, found, true_background=(1, 8)).overlap == (16 / 60, 1.0)


def test_objects_that_share_no_pixel_are_no_match():
    scores = object_scores(bar(5, 10), bar(11, 16))
    assert scores.overlap == scores.boundary == (0.0, 0.0)


def test_f_is_0_where_both_are():
    assert PrecisionRecall(0.0, 0.0).f_measure == 0.0
    assert PrecisionRecall(0.5, 1.0).f_measure == pytest.approx(2 / 3)


def test_sizes_must_agree():
    with pytest.raises(ValueError, match="of one size"):
        object_scores(NOTHING, NOTHING[1:])


def outline(mask: Tensor) -> list[tuple[int, int]]:
    """Pixels that differ from the one right, below or below right of them."""
    right, down = (torch.cat([mask, mask.narrow(d, mask.shape[d] - 1, 1)], d) for d in (1, 0))
    both = torch.cat([down, down[:, -1:]], 1)[1:, 1:]
    on = (mask ^ right[:, 1:]) | (mask ^ down[1:]) | (mask ^ both)
    return [(r, c) for r, c in on.nonzero().tolist()]


def brute_force(truth: Tensor, found: Tensor, tolerance: float) -> tuple[float, ...]:
    """The scores from masks, of the best of all matches."""
    true = [truth == i for i in truth.unique().tolist() if i > 0]
    seen = [found == i for i in found.unique().tolist() if i > 0]
    size = max(len(true), len(seen))
    f = [
        [
            2 * int((t & s).sum()) / int(t.sum() + s.sum())
            for s in seen + [torch.zeros_like(truth, dtype=torch.bool)] * (size - len(seen))
        ]
        for t in true
    ]
    order = max(permutations(range(size)), key=lambda o: sum(f[g][o[g]] for g in range(len(true))))
    pairs = [(g, order[g]) for g in range(len(true)) if f[g][order[g]] > 0]
    shared = sum(int((true[g] & seen[s]).sum()) for g, s in pairs)
    near_found = near_true = 0
    for g, s in pairs:
        a, b = outline(true[g]), outline(seen[s])
        near_true += sum(any(math.dist(p, q) <= tolerance for q in b) for p in a)
        near_found += sum(any(math.dist(p, q) <= tolerance for q in a) for p in b)
    return (
        shared / sum(int(s.sum()) for s in seen),
        shared / sum(int(t.sum()) for t in true),
        near_found / sum(len(outline(s)) for s in seen),
        near_true / sum(len(outline(t)) for t in true),
        sum(f[g][s] >= 0.75 for g, s in pairs) / len(true),
    )


def test_scores_are_those_of_trying_all_matches(generator):
    for tolerance in (0.0, 1.0, 1.5, 3.0) * 2:
        truth, found = patches((9, 4, 70), generator), patches((1, 2, 3, 8), generator)
        scores = object_scores(truth, found, tolerance_px=tolerance)
        got = (*scores.overlap, *scores.boundary, scores.detected)
        assert got == pytest.approx(brute_force(truth, found, tolerance), abs=EXACT)
        swapped = object_scores(found, truth, tolerance_px=tolerance)
        assert swapped.overlap == pytest.approx(scores.overlap[::-1], abs=EXACT)
        assert swapped.boundary == pytest.approx(scores.boundary[::-1], abs=EXACT)


def test_a_nearly_right_guess_is_detected(generator):
    truth = patches((1, 2, 3), generator)
    found = torch.where(torch.rand(truth.shape, generator=generator) < 0.1, 0, truth)
    scores = object_scores(truth, found)
    assert scores.detected == 1.0
    assert scores.overlap.precision == 1.0
    assert scores.overlap.recall == int((found > 0).sum()) / int((truth > 0).sum())
