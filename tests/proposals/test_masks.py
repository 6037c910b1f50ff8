"""Masks that overlap, and which of them a pixel goes to."""

from __future__ import annotations

from itertools import permutations
from pathlib import Path

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from blockstab.proposals.masks import MOST_MASKS, Mask, check_count, painted
from blockstab.rgbd.reading import FrameError


def bars(*spans: tuple[int, int], width: int = 10) -> list[NDArray[np.bool_]]:
    """Masks of one row, from one column up to another."""
    columns = np.arange(width)
    return [((start <= columns) & (columns < stop))[None] for start, stop in spans]


def owners(*masks: Mask) -> list[int]:
    (row,) = painted(masks, *masks[0].inside.shape).label.tolist()
    return row


def test_a_part_lies_over_its_whole_whatever_the_order_and_the_scores() -> None:
    whole, part, inner = bars((0, 9), (2, 6), (3, 5))
    masks = [Mask(1, whole, 0.99), Mask(2, part, 0.5), Mask(3, inner)]
    for order in permutations(masks):
        assert owners(*order) == [1, 1, 2, 3, 3, 2, 1, 1, 1, 0]


def test_a_whole_that_its_parts_cover_keeps_nothing() -> None:
    whole, left, right = bars((0, 8), (0, 5), (5, 8))
    assert owners(Mask(1, left), Mask(2, right), Mask(3, whole)) == [1] * 5 + [2] * 3 + [0] * 2


@pytest.mark.parametrize(
    ("first", "second", "owner"),
    [(0.4, 0.6, 2), (0.6, 0.4, 1), (0.5, 0.5, 1), (None, 0.1, 2), (None, None, 1)],
)
def test_of_two_of_one_size_the_surer_one_counts_then_the_earlier(
    first: float | None, second: float | None, owner: int
) -> None:
    one, other = bars((0, 4), (2, 6))
    assert owners(Mask(1, one, first), Mask(2, other, second))[2:4] == [owner, owner]


def test_an_empty_mask_takes_nothing() -> None:
    one, nothing = bars((0, 4), (0, 0))
    assert owners(Mask(1, nothing), Mask(2, one)) == [2] * 4 + [0] * 6


def test_without_masks_no_pixel_has_a_region() -> None:
    made = painted([], 3, 4)
    assert torch.equal(made.label, torch.zeros(3, 4, dtype=torch.int64))
    assert made.scores == {}


def test_numbers_and_scores_are_kept() -> None:
    one, other = bars((0, 4), (6, 9))
    made = painted([Mask(7, one, 0.25), Mask(300, other)], 1, 10)
    assert made.label.tolist() == [[7] * 4 + [0, 0] + [300] * 3 + [0]]
    assert made.scores == {7: 0.25}


def test_pixels_go_to_the_smallest_mask_that_holds_them() -> None:
    random = np.random.default_rng(5)
    masks = [random.random((20, 30)) < share for share in (0.1, 0.7, 0.4, 0.9, 0.2)]
    label = painted([Mask(i, m) for i, m in enumerate(masks, 1)], 20, 30).label
    for row in range(20):
        for column in range(30):
            holders = [(int(m.sum()), i) for i, m in enumerate(masks, 1) if m[row, column]]
            assert int(label[row, column]) == (min(holders)[1] if holders else 0)


def test_more_masks_than_are_worth_the_time_are_refused() -> None:
    path = Path("many.json")
    check_count(path, MOST_MASKS, 480, 512)
    with pytest.raises(FrameError, match=r"many\.json: must hold at most 4096 masks of 640 x 400"):
        check_count(path, MOST_MASKS + 1, 400, 640)
    with pytest.raises(FrameError, match="at most 16 masks of 8000 x 8000 pixels, but holds 17"):
        check_count(path, 17, 8000, 8000)
