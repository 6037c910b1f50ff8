"""Outlines and borders of regions, drawn by hand."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor

from blockstab.evaluation.metrics.borders import borders, inner_border, near, outlines
from tests.evaluation.metrics.label_images import patches, two_squares


def drawn(rows: list[str]) -> Tensor:
    return torch.tensor([[int(c) for c in row] for row in rows])


def test_the_outline_of_a_square_lies_half_a_pixel_up_and_left():
    label = drawn(["00000", "00770", "00770", "00000"])
    found = {(row, column) for _, row, column in outlines(label).tolist()}
    # 3 x 3 corners around and in the square, but for the pixel whose four neighbours all are in it.
    assert found == {(r, c) for r in (0, 1, 2) for c in (1, 2, 3)} - {(1, 2)}


def test_a_pixel_comes_once_for_each_region_that_meets_there():
    label = drawn(["12", "34"])
    at_the_corner = [row for row in outlines(label).tolist() if row[1:] == [0, 0]]
    assert sorted(at_the_corner) == [[1, 0, 0], [2, 0, 0], [3, 0, 0], [4, 0, 0]]


def test_the_rim_of_the_image_is_no_outline():
    assert len(outlines(torch.full((4, 5), 3))) == 0


def davis(mask: Tensor) -> set[tuple[int, int]]:
    """The outline as the DAVIS benchmark defines it, pixel by pixel."""
    height, width = mask.shape
    found = set()
    for r in range(height):
        for c in range(width):
            down, right = min(r + 1, height - 1), min(c + 1, width - 1)
            own = bool(mask[r, c])
            if any(bool(mask[i, j]) != own for i, j in ((r, right), (down, c), (down, right))):
                found.add((r, c))
    return found


def test_outlines_are_those_of_the_masks_one_by_one(generator):
    label = patches((3, 9, 4, 300), generator)
    got = outlines(label).tolist()
    assert len(got) == len({tuple(row) for row in got})
    for region in label.unique().tolist():
        if region > 0:
            assert {(r, c) for i, r, c in got if i == region} == davis(label == region)


def test_both_sides_of_a_border_are_on_it():
    assert borders(drawn(["1122", "1122", "3322"])).tolist() == [
        [False, True, True, False],
        [True, True, True, False],
        [True, True, True, False],
    ]


def test_the_inner_border_is_that_of_the_named_regions_alone():
    border = inner_border(two_squares(), (3,))
    expected = torch.zeros(6, 10, dtype=torch.bool)
    expected[1:5, 1:5] = True
    expected[2:4, 2:4] = False
    assert torch.equal(border, expected)


@pytest.mark.parametrize(("tolerance", "expected"), [(4.9, False), (5.0, True)])
def test_the_tolerance_itself_is_near(tolerance, expected):
    points, others = torch.tensor([[0, 0]]), torch.tensor([[3, 4], [40, 0]])
    assert near(points, others, tolerance).tolist() == [expected]


def test_nothing_is_near_to_nothing():
    some, none = torch.tensor([[1, 2]]), torch.zeros(0, 2, dtype=torch.int64)
    assert near(some, none, 3.0).tolist() == [False]
    assert near(none, some, 3.0).shape == (0,)
