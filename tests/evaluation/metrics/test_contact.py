"""Objects that touch, and those that only overlap in the picture."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor

from blockstab.evaluation.metrics import touching
from tests.evaluation.metrics.label_images import two_squares

LEFT, RIGHT = 3, 8


def depth_of(label: Tensor, behind_m: float) -> Tensor:
    """One metre, but for the right square, which lies further back."""
    return torch.where(label == RIGHT, 1.0 + behind_m, 1.0).double()


@pytest.mark.parametrize(("behind_m", "met"), [(0.0, True), (0.019, True), (0.021, False), (-0.021, False)])
def test_squares_side_by_side_touch_if_they_are_equally_far(behind_m: float, met: bool) -> None:
    label = two_squares()
    assert touching(label, depth_of(label, behind_m), (LEFT, RIGHT), least_px=4) is met


def test_a_pair_needs_as_many_places_as_asked_for() -> None:
    label = two_squares()
    assert touching(label, depth_of(label, 0.0), (LEFT, RIGHT), least_px=4)
    assert not touching(label, depth_of(label, 0.0), (LEFT, RIGHT), least_px=5)


def test_places_of_different_pairs_do_not_add_up() -> None:
    label = torch.tensor([[1, 2], [1, 2], [3, 4], [3, 4]])
    depth = torch.ones(4, 2).double()
    assert touching(label, depth, (1, 2, 3, 4), least_px=2)
    assert not touching(label, depth, (1, 2, 3, 4), least_px=3)


def test_what_is_no_object_touches_nothing() -> None:
    label = two_squares()
    assert not touching(label, depth_of(label, 0.0), (LEFT,), least_px=1)
    assert not touching(label, depth_of(label, 0.0), (), least_px=1)


def test_where_depth_is_missing_nobody_sees_a_contact() -> None:
    label = two_squares()
    assert not touching(label, torch.zeros(label.shape).double(), (LEFT, RIGHT), least_px=1)


def test_stacked_is_like_side_by_side() -> None:
    label = two_squares()
    assert touching(label.T, depth_of(label, 0.0).T, (LEFT, RIGHT), least_px=4)
