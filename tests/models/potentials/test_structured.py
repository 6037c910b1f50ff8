"""The weight of boundaries, and learning from whole segmentations."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
import torch

from blockstab.energy.overlap import Parts
from blockstab.features.columns import LONE_COLUMNS, SEGMENT_COLUMNS
from models.potentials.heads import LinearHead, Potential, TreesHead
from models.potentials.rows import States
from models.potentials.structured import fit_structured, held_out_weight, margin_loss

LONE = SEGMENT_COLUMNS.index(LONE_COLUMNS[0])
BOTH = (torch.tensor([0]), torch.tensor([0]))


def identity() -> Potential:
    """A potential that is its only column."""
    head = LinearHead(1)
    potential = Potential(("x",), head, torch.zeros(1), torch.ones(1)).requires_grad_(False)
    for parameter in head.parameters():
        parameter.fill_(1.0 if parameter.ndim > 1 else 0.0)
    return potential


# Both judges of segments say what stands in their first column.
JUDGE = SimpleNamespace(
    unary=lambda rows: rows[:, LONE].double(), alone=lambda rows: rows[:, 0].double(), pairwise=identity()
)


def states(phi: list[float], psi: list[float], error: list[float]) -> States:
    """Segmentations of one segment and one boundary each, of 100 pixels and 50."""
    count = len(error)
    which = torch.arange(count)
    area = torch.full((count,), 100.0, dtype=torch.float64)
    parts = Parts(
        area, torch.zeros(count, dtype=torch.bool), torch.zeros(count), area / 2, which, which, count
    )
    segments = torch.tensor(phi, dtype=torch.float32)[:, None].expand(-1, len(SEGMENT_COLUMNS))
    boundaries = torch.tensor(psi, dtype=torch.float32)[:, None]
    return States(segments, boundaries, torch.tensor(error).double(), torch.tensor(error).double(), parts)


def test_the_weight_is_that_with_which_the_energy_follows_the_error():
    phi, psi = [0.1, 0.4, 0.3, 0.6], [0.0, 0.2, 0.6, 0.4]
    for weight in (0.0, 0.3, 2.0):
        error = [0.7 * (a + weight * 0.5 * b) + 0.05 for a, b in zip(phi, psi, strict=True)]
        found = held_out_weight([JUDGE], [states(phi, psi, error)])
        assert found == pytest.approx(weight, abs=1e-5)


def test_what_all_segmentations_of_an_image_have_in_common_says_nothing_of_the_weight():
    phi, psi = [0.1, 0.4, 0.3, 0.6], [0.0, 0.2, 0.6, 0.4]
    images = []
    for shift in (0.0, 0.3):
        error = [a + 0.2 * 0.5 * b + shift for a, b in zip(phi, psi, strict=True)]
        images.append(states(phi, psi, error))
    assert held_out_weight([JUDGE] * 2, images) == pytest.approx(0.2, abs=1e-5)


def test_boundaries_that_mislead_weigh_nothing():
    phi, psi = [0.1, 0.4, 0.3, 0.6], [0.6, 0.2, 0.3, 0.1]
    error = [a - 0.25 * b for a, b in zip(phi, psi, strict=True)]
    assert held_out_weight([JUDGE], [states(phi, psi, error)]) == 0.0


def test_the_margin_grows_with_the_error_and_a_truth_that_is_far_below_costs_nothing():
    energy = torch.tensor([0.1, 0.3, 0.5], dtype=torch.float64)
    assert float(margin_loss(energy, torch.tensor([0.0, 0.2, 0.4]))) == pytest.approx(0.0, abs=1e-7)
    assert float(margin_loss(energy, torch.tensor([0.0, 0.4, 0.4]))) == pytest.approx(0.1)


def test_the_structured_loss_brings_the_truth_below_what_was_visited():
    phi, psi, error = [0.5, 0.4, 0.3], [0.2, 0.1, 0.3], [0.0, 0.3, 0.6]
    unary, pairwise = identity(), identity()
    before = unary(torch.tensor([[0.5], [0.3]]))
    some = [states(phi, psi, error)] * 40
    assert fit_structured(unary, pairwise, BOTH, some, 0.1, 0) > 0.0
    after = unary(torch.tensor([[0.5], [0.3]]))
    assert float(before[0] - before[1]) > float(after[0] - after[1])
    assert not any(p.requires_grad for p in unary.parameters())


def test_trees_and_their_weight_stay_as_they_are():
    unary, pairwise = (
        Potential(("x",), TreesHead(1), torch.zeros(1), torch.ones(1)).requires_grad_(False) for _ in range(2)
    )
    some = [states([0.5, 0.4], [0.1, 0.2], [0.0, 0.3])]
    assert fit_structured(unary, pairwise, BOTH, some, 0.37, 0) == 0.37
