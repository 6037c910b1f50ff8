"""Platt scaling, against scikit-learn's and against what a probability must do."""

from __future__ import annotations

import pytest
import torch
from sklearn.calibration import CalibratedClassifierCV
from sklearn.frozen import FrozenEstimator
from sklearn.linear_model import LogisticRegression

from models.potentials.calibration import platt

SOLVER = 1e-4  # scikit-learn's L-BFGS stops at a gradient of about 1e-6 a row


def sample(generator: torch.Generator, rows: int = 4000) -> tuple[torch.Tensor, torch.Tensor]:
    """Potentials whose badness is, by construction, sigmoid(3 * potential - 1)."""
    potentials = torch.randn(rows, generator=generator, dtype=torch.float64)
    chance = torch.rand(rows, generator=generator, dtype=torch.float64)
    return potentials, (chance < torch.sigmoid(3 * potentials - 1)).double()


@pytest.mark.filterwarnings("ignore:Since FrozenEstimator")  # the calibration alone is weighted, as here
@pytest.mark.parametrize("weighted", [False, True])
def test_the_probabilities_are_those_of_scikit_learn(weighted, generator):
    rows, target = sample(generator, 500)
    weights = torch.rand(500, generator=generator, dtype=torch.float64) if weighted else None
    column, given = rows[:, None].numpy(), None if weights is None else weights.numpy()
    frozen = FrozenEstimator(LogisticRegression().fit(column, target.numpy()))
    reference = CalibratedClassifierCV(frozen, method="sigmoid", ensemble=False)
    theirs = reference.fit(column, target.numpy(), sample_weight=given).predict_proba(column)[:, 1]
    potentials = torch.from_numpy(frozen.decision_function(column))
    a, b = platt(potentials, target, weights)
    ours = torch.sigmoid(a * potentials + b)
    torch.testing.assert_close(ours, torch.from_numpy(theirs), rtol=0, atol=SOLVER)


def test_the_slope_and_offset_that_made_the_targets_are_found(generator):
    a, b = platt(*sample(generator))
    assert a == pytest.approx(3, abs=0.3)
    assert b == pytest.approx(-1, abs=0.2)


def test_among_rows_called_bad_with_some_probability_that_share_is_bad(generator):
    a, b = platt(*sample(generator))
    potentials, target = sample(generator, 20000)
    badness = torch.sigmoid(a * potentials + b)
    for low in (0.0, 0.2, 0.4, 0.6, 0.8):
        inside = (badness >= low) & (badness < low + 0.2)
        assert float(badness[inside].mean()) == pytest.approx(float(target[inside].mean()), abs=0.04)


def test_separable_potentials_give_finite_numbers():
    a, b = platt(torch.tensor([-2.0, -1.0, 1.0, 2.0]), torch.tensor([0.0, 0.0, 1.0, 1.0]))
    badness = torch.sigmoid(a * torch.tensor([-2.0, 2.0]) + b)
    assert 0.05 < float(badness[0]) < 0.3
    assert 0.7 < float(badness[1]) < 0.95


def test_huge_and_offset_potentials_do_not_overflow(generator):
    potentials, target = sample(generator)
    a, b = platt(1e4 * potentials + 1e5, target)
    plain = platt(potentials, target)
    assert a * 1e4 == pytest.approx(plain[0], rel=1e-4)
    assert b + a * 1e5 == pytest.approx(plain[1], rel=1e-4)


def test_equal_potentials_give_everyone_the_smoothed_share():
    a, b = platt(torch.full((10,), 0.5), torch.tensor([1.0] * 3 + [0.0] * 7))
    # Three at 4/5 and seven at 1/9.
    assert float(torch.sigmoid(torch.tensor(0.5 * a + b))) == pytest.approx(
        (3 * 4 / 5 + 7 / 9) / 10, abs=1e-6
    )


def test_a_row_of_weight_two_counts_as_two_rows(generator):
    potentials, target = sample(generator, 50)
    twice = platt(potentials.repeat(2), target.repeat(2))
    assert platt(potentials, target, torch.full((50,), 2.0)) == pytest.approx(twice, rel=1e-6)


@pytest.mark.parametrize(("rows", "targets"), [(3, 2), (0, 0)])
def test_potentials_without_their_targets_are_refused(rows, targets):
    with pytest.raises(ValueError, match="one target for each of at least one potential"):
        platt(torch.zeros(rows), torch.zeros(targets))
