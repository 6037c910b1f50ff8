"""How well potentials judge, on rows whose answers are known."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
import torch

from models.potentials.judging import calibration_error, judged
from models.potentials.rows import Rows


def rows(features: list[float], bad: list[bool]) -> Rows:
    column, pixels = torch.tensor(features)[:, None], torch.ones(len(bad), dtype=torch.float64)
    return Rows(column, torch.tensor(bad).double(), torch.tensor(bad), pixels)


class Says:
    """A judge that says what its column does."""

    def __init__(self, sign: float) -> None:
        self.sign = sign

    def __call__(self, features):
        return self.sign * features[:, 0].double()

    def badness(self, features):
        return features[:, 0].double()


def potentials(sign: float) -> SimpleNamespace:
    return SimpleNamespace(unary=Says(sign), alone=Says(sign), name="mine")


IMAGES = [
    SimpleNamespace(unary=one, alone=one)
    for one in (rows([0.1, 0.9, 0.7], [False, True, True]), rows([0.6, 0.8, 0.2], [False, True, False]))
]


def test_a_judge_who_is_right_scores_1_and_one_who_says_the_opposite_0():
    right, wrong = judged({"right": potentials(1.0), "wrong": potentials(-1.0)}, IMAGES, 0)
    assert (right["method"], right["potential"], right["segments"]) == ("right", "mine", 6)
    assert right["scores"]["auc"] == right["scores"]["auc_alone"] == 1.0
    assert wrong["scores"]["auc"] == 0.0
    assert right["scores"]["rank_correlation"] == -wrong["scores"]["rank_correlation"] > 0.8
    for score, (low, high) in right["ci95"].items():
        assert low <= right["scores"][score] <= high


def test_the_same_seed_draws_the_same_images():
    assert judged({"a": potentials(1.0)}, IMAGES, 3) == judged({"a": potentials(1.0)}, IMAGES, 3)


@pytest.mark.parametrize(
    ("badness", "bad", "error"),
    [
        ([0.0, 1.0], [False, True], 0.0),
        ([1.0, 0.0], [False, True], 1.0),
        ([0.5, 0.5], [False, True], 0.0),
        ([0.3, 0.3, 0.3, 0.3], [True, False, False, True], 0.2),
        ([0.0, 0.0, 0.9, 0.9], [True, False, True, True], 0.3),
    ],
)
def test_the_calibration_error_is_how_far_shares_lie_from_probabilities(badness, bad, error):
    found = calibration_error(torch.tensor(badness).double(), torch.tensor(bad))
    assert found == pytest.approx(error)
