"""How sure a mean is, and how sure a step from one method to another."""

from __future__ import annotations

import pytest

from blockstab.evaluation.scoring import Score
from blockstab.evaluation.scoring.bootstrap import interval, pooled, step
from tests.tolerance import EXACT

HARD_AND_EASY = {"hard": Score(0.2, 1), "middle": Score(0.5, 1), "easy": Score(0.9, 1)}


def raised(by: float) -> dict[str, Score]:
    return {scene: Score(total + by, things) for scene, (total, things) in HARD_AND_EASY.items()}


def test_a_mean_counts_things_and_not_images():
    assert pooled([Score(1.0, 1), Score(1.0, 3)]) == pytest.approx(0.5, abs=EXACT)
    assert pooled([Score(0.0, 0)]) is None


def test_the_interval_of_two_images_worked_by_hand():
    # Of the four draws one is all the worse image, one all the better: a quarter each, far more than the tails.
    assert interval([Score(0.0, 1), Score(1.0, 1)], seed=0) == [0.0, 1.0]
    assert interval([Score(0.0, 0), Score(3.0, 4)], seed=0) == [0.75, 0.75]
    assert interval([], seed=0) is None


def test_a_step_that_every_image_takes_is_sure_however_much_images_differ():
    found = step(HARD_AND_EASY, raised(0.1), seed=0)
    assert found is not None
    assert found.mean == pytest.approx(0.1, abs=EXACT)
    assert found.ci95 == pytest.approx([0.1, 0.1], abs=EXACT)
    low, high = interval(list(HARD_AND_EASY.values()), seed=0)
    assert high - low > 0.3


def test_a_step_worked_by_hand():
    # One image gains 0.4, the other loses 0.2: the mean gains 0.1, and a quarter of all draws shows either alone.
    found = step({"a": Score(0.5, 1), "b": Score(0.5, 1)}, {"a": Score(0.9, 1), "b": Score(0.3, 1)}, seed=0)
    assert found is not None
    assert found.mean == pytest.approx(0.1, abs=EXACT)
    assert found.ci95 == pytest.approx([-0.2, 0.4], abs=EXACT)


def test_a_step_counts_things_and_not_images():
    above, row = {"a": Score(0.0, 1), "b": Score(0.0, 3)}, {"a": Score(1.0, 1), "b": Score(0.0, 3)}
    found = step(above, row, seed=0)
    assert found is not None
    assert found.mean == pytest.approx(0.25, abs=EXACT)


def test_only_scenes_that_both_methods_were_scored_in_count():
    above = {**HARD_AND_EASY, "alone": Score(0.0, 1), "nothing": Score(0.0, 0)}
    found = step(above, {**raised(0.1), "nothing": Score(1.0, 1)}, seed=0)
    assert found is not None
    assert found.mean == pytest.approx(0.1, abs=EXACT)
    assert step(above, {"other": Score(1.0, 1)}, seed=0) is None


def test_the_seed_decides_the_draws():
    parts = [Score(k / 9, 1) for k in range(10)]
    assert interval(parts, seed=1) == interval(parts, seed=1)
    assert interval(parts, seed=1) != interval(parts, seed=2)
