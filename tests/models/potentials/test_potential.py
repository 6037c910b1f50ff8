"""Fitting: the optimum, the convention, the calibration, and the choice of C."""

from __future__ import annotations

from contextlib import contextmanager
from functools import partial

import numpy as np
import pytest
import torch
from sklearn.svm import LinearSVR

from models.potentials.heads import HEADS, LinearHead, MLPHead, Potential
from models.potentials.losses import balanced_weights, svr_objective
from models.potentials.potential import choose_c, cross_fit, fold_of

COLUMNS = ("volume", "tilt", "density", "constant")


def fit_potential(*given, **settings) -> Potential:
    """The calibrated potential of all rows."""
    return cross_fit(*given, **settings).potential


every_head = pytest.mark.parametrize("head", list(HEADS.values()), ids=list(HEADS))


def rows(generator: torch.Generator, count: int = 600) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Features of different scales, a noisy badness that is a linear rule on them, ten images."""
    standard = torch.randn(count, 3, generator=generator, dtype=torch.float64)
    noise = 0.5 * torch.randn(count, generator=generator, dtype=torch.float64)
    bad = standard[:, 0] - 2 * standard[:, 1] + noise > 1
    scaled = standard * torch.tensor([1e-3, 1.0, 1e4]) + torch.tensor([0.0, 5.0, -1e5])
    constant = torch.full((count, 1), 0.7, dtype=torch.float64)
    return torch.cat([scaled, constant], dim=1), bad.double(), torch.arange(count) % 10


def balanced_accuracy(potentials: torch.Tensor, target: torch.Tensor) -> float:
    right = (potentials > 0.5) == (target > 0.5)
    return float((right[target == 0].double().mean() + right[target == 1].double().mean()) / 2)


@every_head
def test_convention_lower_potential_is_better(head, generator):
    features, target, groups = rows(generator)
    fitted = fit_potential(features, target, groups, COLUMNS, head, c=0.1, folds=3)
    unseen, truth, _ = rows(generator)
    potentials, badness = fitted(unseen), fitted.badness(unseen)
    assert float(potentials[truth == 0].mean()) + 0.4 < float(potentials[truth == 1].mean())
    assert float(badness[truth == 0].mean()) + 0.4 < float(badness[truth == 1].mean())
    assert balanced_accuracy(potentials, truth) > 0.85


@pytest.mark.parametrize("c", [1e-3, 1e-1, 10.0])
def test_the_linear_head_reaches_the_optimum_of_support_vector_regression(c, generator):
    features, target, groups = rows(generator)
    fitted = fit_potential(features, target, groups, COLUMNS, LinearHead, c=c)
    standard, weight = fitted.standardised(features), balanced_weights(target)
    reference = LinearSVR(
        loss="squared_epsilon_insensitive", epsilon=0.1, C=c, dual=False, tol=1e-8, max_iter=10000
    ).fit(standard.numpy(), target.numpy(), sample_weight=weight.numpy())
    unseen = fitted.standardised(rows(generator)[0])
    theirs, ours = torch.from_numpy(reference.predict(unseen.numpy())), fitted.head(unseen)
    assert float(torch.corrcoef(torch.stack([ours, theirs]))[0, 1]) > 0.99999
    torch.testing.assert_close(ours, theirs, rtol=0, atol=1e-4)

    def objective(potentials: torch.Tensor, parameters: list[torch.Tensor]) -> float:
        return float(svr_objective(potentials, target, weight, parameters, c))

    optimum = objective(
        torch.from_numpy(reference.predict(standard.numpy())),
        [torch.from_numpy(reference.coef_), torch.from_numpy(np.atleast_1d(reference.intercept_))],
    )
    assert objective(fitted(features), list(fitted.head.parameters())) == pytest.approx(optimum, rel=1e-4)


def test_the_network_learns_what_no_linear_rule_can(generator):
    features = torch.randn(1500, 2, generator=generator, dtype=torch.float64)
    target = (features[:, 0] * features[:, 1] > 0).double()
    groups = torch.arange(1500) % 5
    accuracy = {
        head: balanced_accuracy(
            fit_potential(features[:1000], target[:1000], groups[:1000], ("x", "y"), head, c=0.1, folds=2)(
                features[1000:]
            ),
            target[1000:],
        )
        for head in (LinearHead, MLPHead)
    }
    assert accuracy[LinearHead] < 0.6
    assert accuracy[MLPHead] > 0.9


@every_head
def test_the_same_seed_gives_the_same_bits_whatever_the_global_one(head, generator, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    features, target, groups = rows(generator, 200)
    states = []
    for global_seed in (1, 2):
        torch.manual_seed(global_seed)
        states.append(
            fit_potential(features, target, groups, COLUMNS, head, c=0.1, folds=2, seed=3).state_dict()
        )
    assert all(torch.equal(states[0][key], states[1][key]) for key in states[0])
    assert list(tmp_path.iterdir()) == []  # Lightning leaves no files behind


def test_neither_fits_side_by_side_nor_threads_change_a_bit(generator):
    features, target, groups = rows(generator, 3000)
    states = []
    for jobs, threads in ((1, 1), (2, 1), (1, 4)):
        with using_threads(threads):
            fitted = fit_potential(features, target, groups, COLUMNS, MLPHead, c=0.1, folds=2, jobs=jobs)
        states.append(fitted.state_dict())
    assert all(torch.equal(states[0][key], state[key]) for state in states[1:] for key in state)


@contextmanager
def using_threads(count):
    before = torch.get_num_threads()
    torch.set_num_threads(count)
    yield
    torch.set_num_threads(before)


def test_badness_is_the_share_of_bad_rows_not_of_balanced_ones(generator):
    features, target, groups = rows(generator, 4000)
    rare = (target == 0) | (torch.rand(4000, generator=generator) < 0.2)
    half = torch.arange(int(rare.sum())) % 2 == 0
    features, target, groups = features[rare], target[rare], groups[rare]
    fitted = fit_potential(features[half], target[half], groups[half], COLUMNS, LinearHead, c=0.1)
    share = float(target[~half].mean())
    assert share < 0.15
    assert float(fitted.badness(features[~half]).mean()) == pytest.approx(share, abs=0.02)


def test_calibration_is_not_fooled_by_a_head_that_learns_its_rows_by_heart(generator):
    features = torch.randn(150, 30, generator=generator, dtype=torch.float64)
    target = (torch.rand(150, generator=generator) > 0.5).double()  # chance
    groups = torch.arange(150) % 5
    names = [f"column {i}" for i in range(30)]
    fitted = fit_potential(features, target, groups, names, MLPHead, c=100.0, folds=2)
    assert balanced_accuracy(fitted(features), target) > 0.95
    assert float((fitted.badness(features) - 0.5).abs().max()) < 0.35


def test_what_judges_an_image_has_learned_from_the_others_alone(generator):
    features, target, groups = rows(generator, 300)
    found = cross_fit(features, target, groups, COLUMNS, LinearHead, c=0.1, folds=3)
    strange = torch.where((fold_of(groups, 3) == 1)[:, None], features * 100 + 7, features)
    other = cross_fit(strange, target, groups, COLUMNS, LinearHead, c=0.1, folds=3)
    same = [
        torch.equal(one(features), two(features)) for one, two in zip(found.unseen, other.unseen, strict=True)
    ]
    assert same == [False, True, False]
    for k, potential in enumerate(found.unseen):
        fold = fold_of(groups, 3) == k
        assert torch.equal(found.held_out[fold], potential(features[fold]))


def test_the_folds_share_out_sets_that_follow_each_other():
    preset = torch.arange(24) // 12
    counts = [torch.bincount(preset[fold_of(torch.arange(24), 4) == k]).tolist() for k in range(4)]
    assert counts == [[3, 3]] * 4


def test_the_chosen_c_has_the_least_held_out_loss(generator):
    features, target, groups = rows(generator, 200)
    chosen = choose_c(features, target, groups, COLUMNS, LinearHead, grid=(10.0, 1e-5, 0.1))
    assert list(chosen.held_out_loss) == [1e-5, 0.1, 10.0]
    assert chosen.held_out_loss[chosen.c] == min(chosen.held_out_loss.values())
    assert chosen.c != 1e-5  # it leaves nearly nothing of the weights


def test_rows_of_one_image_never_sit_on_both_sides_of_a_fold(generator):
    # The features name the image and the badness is the image's: to see it is to know the answer.
    groups = torch.arange(400) % 20
    names = torch.nn.functional.one_hot(groups).double()
    target = (torch.rand(20, generator=generator) > 0.5).double()[groups]
    columns = [f"image {i}" for i in range(20)]
    chosen = choose_c(names, target, groups, columns, LinearHead, grid=(1.0, 10.0))
    assert chosen.held_out_loss[10.0] > 0.1


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"columns": ("volume",)}, r"features \(N, 1\)"),
        ({"groups": torch.arange(5)}, r"\(60, 4\), \(60,\) and \(5,\)"),
        ({"features": torch.full((60, 4), torch.nan)}, "volume of row 0 is nan"),
        ({"target": torch.zeros(60)}, "both kinds occur"),
        ({"folds": 11}, "2 to 10 folds, but folds is 11"),
        ({"folds": 1}, "folds is 1"),
    ],
)
@pytest.mark.parametrize("train", [choose_c, partial(cross_fit, c=1.0)], ids=["choose_c", "cross_fit"])
def test_rows_that_cannot_train_are_refused(train, change, message, generator):
    features, target, groups = rows(generator, 60)
    given = {"features": features, "target": target, "groups": groups, "columns": COLUMNS, "head": LinearHead}
    with pytest.raises(ValueError, match=message):
        train(**(given | change))
