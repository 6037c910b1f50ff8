"""The objective: worked by hand, and against LIBLINEAR's."""

from __future__ import annotations

import pytest
import torch

from models.potentials.losses import balanced_weights, squared_epsilon_insensitive, svr_objective
from tests.tolerance import EXACT


def test_errors_inside_the_tube_cost_nothing():
    target = torch.tensor([0.0, 1.0, 1.0], dtype=torch.float64)
    potentials = torch.tensor([0.1, 0.9, 1.05], dtype=torch.float64)
    assert squared_epsilon_insensitive(potentials, target, torch.ones(3)) < EXACT


def test_the_loss_is_the_weighted_mean_of_the_squared_excess():
    target = torch.tensor([0.0, 1.0], dtype=torch.float64)
    potentials = torch.tensor([0.6, 1.3], dtype=torch.float64)  # beyond the tube by 0.5 and 0.2
    weight = torch.tensor([3.0, 1.0], dtype=torch.float64)
    loss = squared_epsilon_insensitive(potentials, target, weight)
    assert float(loss) == pytest.approx((3 * 0.25 + 0.04) / 4, abs=EXACT)


def test_the_gradient_of_the_loss_is_that_of_its_values(generator):
    potentials = torch.randn(9, generator=generator, dtype=torch.float64, requires_grad=True)
    target = (torch.rand(9, generator=generator) > 0.5).double()
    weight = torch.rand(9, generator=generator, dtype=torch.float64)
    assert torch.autograd.gradcheck(lambda p: squared_epsilon_insensitive(p, target, weight), potentials)


def test_the_objective_is_that_of_liblinear_over_c_and_the_weights(generator):
    potentials = torch.randn(6, generator=generator, dtype=torch.float64)
    target = torch.tensor([0, 1, 1, 0, 1, 1], dtype=torch.float64)
    weight, parameters, c = balanced_weights(target), [torch.tensor([[3.0, -1.0]]), torch.tensor([0.5])], 0.2
    excess = ((target - potentials).abs() - 0.1).clamp(min=0)
    liblinear = 0.5 * (9 + 1 + 0.25) + c * (weight * excess**2).sum()
    ours = svr_objective(potentials, target, weight, parameters, c)
    assert float(ours) == pytest.approx(float(liblinear) / (c * 6), abs=EXACT)


def test_good_and_bad_rows_weigh_the_same():
    target = torch.tensor([1, 0, 1, 1, 1, 1], dtype=torch.float64)
    weight = balanced_weights(target)
    assert float(weight[target == 0].sum()) == pytest.approx(float(weight[target == 1].sum()), abs=EXACT)
    assert float(weight.mean()) == pytest.approx(1, abs=EXACT)


def test_what_is_good_enough_counts_as_good_and_half_bad_as_bad():
    target = torch.tensor([0.0, 0.1, 0.4, 0.9], dtype=torch.float64)
    assert balanced_weights(target, good=0.1).tolist() == [1.0] * 4
    assert balanced_weights(target, good=0.0).tolist() == pytest.approx([2.0, *[2 / 3] * 3])


@pytest.mark.parametrize("target", [[], [1.0, 1.0], [0.0, 0.0], [0.0, 0.4, 1.1], [-1.0, 1.0]])
def test_targets_beyond_good_and_bad_or_of_one_kind_are_refused(target):
    with pytest.raises(ValueError, match=r"between 0 \(good\) and 1 \(bad\), and both kinds occur"):
        balanced_weights(torch.tensor(target))
