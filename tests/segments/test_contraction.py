"""Merging regions that border on each other."""

from __future__ import annotations

import pytest
import torch

from blockstab.segments.contraction import Borders, borders_between, contract, lowest_first, smallest_first
from tests.tolerance import EXACT


def triangle() -> Borders:
    """Three regions that all touch: lengths 2, 4, 6 and strengths 0.1, 0.4, 0.7."""
    first, second = torch.tensor([0, 0, 1]), torch.tensor([1, 2, 2])
    length = torch.tensor([2.0, 4.0, 6.0], dtype=torch.float64)
    return borders_between(3, first, second, length, torch.tensor([0.1, 0.4, 0.7], dtype=torch.float64))


def test_borders_to_a_common_neighbour_become_one() -> None:
    borders = triangle()
    contract(borders, 0, 1)
    assert set(borders) == {0, 2}
    assert borders[0][2] == pytest.approx((10.0, 4 * 0.4 + 6 * 0.7), abs=EXACT)
    assert borders[2][0] == borders[0][2]


def test_merging_across_the_weakest_border_uses_all_of_them_up() -> None:
    borders = triangle()
    merges = list(lowest_first(borders))
    assert [(kept, gone) for kept, gone, _ in merges] == [(0, 1), (0, 2)]
    assert [mean for *_, mean in merges] == pytest.approx([0.1, 5.8 / 10], abs=EXACT)
    assert borders == {0: {}}


@pytest.mark.parametrize(
    ("pixels", "owners"),
    [
        ([50, 50, 50], [0, 1, 2]),  # none is small
        ([50, 50, 9], [0, 1, 0]),  # the last joins across its weaker border
        ([9, 8, 50], [2, 2, 2]),  # the first two stay small together, and go on
        ([9, 9, 9], [1, 1, 1]),  # the first makes the second larger than the third
    ],
)
def test_small_regions_join_until_they_are_large_enough(pixels: list[int], owners: list[int]) -> None:
    assert smallest_first(triangle(), pixels, 20) == owners


def test_a_region_without_borders_stays_small() -> None:
    assert smallest_first({0: {}}, [3], 20) == [0]
