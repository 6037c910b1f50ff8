"""Scores of boxes and supports, against values worked by hand."""

from __future__ import annotations

import math
from itertools import permutations, product

import pytest
import torch
from torch import Tensor

from blockstab.evaluation.metrics import axis_error_deg, support_accuracy
from tests.tolerance import EXACT


def turned(degrees: float, axis: int) -> Tensor:
    """The axes of a box after a turn about one of them."""
    cos, sin = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    rotation = torch.eye(3, dtype=torch.float64)
    a, b = (k for k in range(3) if k != axis)
    rotation[a, a] = rotation[b, b] = cos
    rotation[a, b], rotation[b, a] = -sin, sin
    return rotation[None]


def random_rotations(n: int, generator: torch.Generator) -> Tensor:
    q, r = torch.linalg.qr(torch.randn(n, 3, 3, generator=generator, dtype=torch.float64))
    q = q * r.diagonal(dim1=1, dim2=2).sign()[:, None]
    return q * torch.linalg.det(q)[:, None, None]


def test_axes_that_are_the_same_have_no_error(generator):
    rotation = random_rotations(20, generator)
    # The arc cosine at one takes the root of what rounding leaves.
    assert float(axis_error_deg(rotation, rotation).amax()) < 1e-5


def test_axes_have_neither_sign_nor_order(generator):
    rotation, truth = random_rotations(20, generator), random_rotations(20, generator)
    expected = axis_error_deg(rotation, truth)
    for order in permutations(range(3)):
        for signs in product((-1.0, 1.0), repeat=3):
            renamed = rotation[..., list(order)] * torch.tensor(signs, dtype=torch.float64)
            torch.testing.assert_close(axis_error_deg(renamed, truth), expected, rtol=0.0, atol=1e-5)


def test_turning_the_world_changes_no_error(generator):
    rotation, truth, turn = (random_rotations(20, generator) for _ in range(3))
    moved = axis_error_deg(turn @ rotation, turn @ truth)
    torch.testing.assert_close(moved, axis_error_deg(rotation, truth), rtol=0.0, atol=1e-5)


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize(
    ("degrees", "error"), [(9.0, 6.0), (45.0, 30.0), (60.0, 20.0), (90.0, 0.0), (-30.0, 20.0)]
)
def test_a_turn_about_one_axis_turns_the_two_others(degrees, axis, error):
    # Two axes of three move; beyond 45 degrees the next axis is nearer.
    found = axis_error_deg(turned(degrees, axis), torch.eye(3, dtype=torch.float64)[None])
    assert float(found) == pytest.approx(error, abs=1e-5)


def test_45_degrees_is_the_worst_turn_about_one_axis():
    errors = [float(axis_error_deg(turned(d, 1), turned(0.0, 1))) for d in range(0, 91, 5)]
    assert max(errors) == errors[9] == pytest.approx(30.0)


def test_the_match_of_least_sum_counts_not_that_of_each_axis():
    # The third axis lies midway between two; each axis for itself would take the same partner twice.
    rotation = turned(44.0, 0) @ turned(44.0, 1)
    truth = torch.eye(3, dtype=torch.float64)[None]
    cosine = (rotation.transpose(1, 2) @ truth)[0].abs().clamp(max=1.0)
    angle = torch.rad2deg(torch.acos(cosine)).tolist()
    sums = [sum(angle[order[k]][k] for k in range(3)) / 3 for order in permutations(range(3))]
    assert float(axis_error_deg(rotation, truth)) == pytest.approx(min(sums), abs=EXACT)
    assert min(sums) > sum(min(row[k] for row in angle) for k in range(3)) / 3


@pytest.mark.parametrize(
    ("predicted", "share"),
    [
        ({2: {1}, 3: {2}, 4: {2, 3}}, 1.0),
        ({2: {1}, 3: {2}, 4: {2}}, 2 / 3),  # one of two supporters is missed
        ({2: {1}, 3: {2, 1}, 4: {2, 3}}, 2 / 3),  # one too many
        ({2: {1}}, 1 / 3),  # nothing found for the others
        ({2: {1}, 3: {2}, 4: {2, 3}, 9: {1}}, 1.0),  # what is not scored does not count
        ({}, 0.0),
    ],
)
def test_an_object_counts_if_its_supporters_are_exactly_the_true_ones(predicted, share):
    assert support_accuracy({2: {1}, 3: {2}, 4: {2, 3}}, predicted) == pytest.approx(share)


def test_an_object_that_nothing_supports_is_right_if_nothing_was_found():
    assert support_accuracy({2: set()}, {}) == 1.0


def test_without_objects_there_is_no_accuracy():
    assert math.isnan(support_accuracy({}, {2: {1}}))
