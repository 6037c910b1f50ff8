"""How moves are drawn: what promises more comes more often, by no more than what segments lose by themselves."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import partial
from types import SimpleNamespace
from typing import cast

import pytest
import torch

from blockstab.energy import Rating
from blockstab.search.moves.drawing import Change, MostPromising, draw
from blockstab.search.problem import Problem
from blockstab.segments.segmentation import Segment
from tests.search.moves.row import PAIRS, halves, rated

DRAWS = 3000
RATING = rated([0.5] * 4, [0.5] * 3)
TABLE, *BLOCKS = PAIRS


@dataclass(frozen=True)
class Given(MostPromising):
    """Makes the changes that it is given."""

    given: tuple[Change, ...]

    def changes(self, rating: Rating, problem: Problem) -> tuple[Change, ...]:
        return self.given


def judging(loss: dict[Segment, float], lost: float = 0.0) -> Problem:
    """A problem in which segments lose so many pixels by themselves, and others none; background, a share."""

    def losses(segments: list[Segment]) -> list[float]:
        return [loss.get(s, 0.0) for s in segments]

    describe = SimpleNamespace(lost=lambda scene: torch.full((len(scene),), lost, dtype=torch.float64))
    return cast(Problem, SimpleNamespace(losses=losses, describe=describe, once=lambda key, make: make()))


def split(k: int) -> Change:
    """The change that takes block k in two."""
    start, index = RATING.scene.segmentation, PAIRS.index(BLOCKS[k])
    return Change((BLOCKS[k],), halves(BLOCKS[k]), partial(start.replace, index, halves(BLOCKS[k])))


CHANGES = [split(k) for k in range(3)]


def counted(problem: Problem, changes: list[Change], generator: torch.Generator, count: int = 1) -> list[int]:
    drawn = Counter(
        result for _ in range(DRAWS) for result in Given(tuple(changes))(RATING, problem, count, generator)
    )
    return [drawn[change.result()] for change in changes]


def test_indices_are_drawn_in_proportion_to_what_lies_above_the_least(generator):
    potential, possible = torch.tensor([9.0, 1.0, 2.0, 3.0]), torch.tensor([False, True, True, True])
    drawn = Counter(draw(potential, possible, 20 * DRAWS, generator))
    assert [drawn[k] / (20 * DRAWS) for k in range(4)] == pytest.approx(
        [0.0, 0.05 / 1.65, 0.55 / 1.65, 1.05 / 1.65], abs=0.01
    )


def test_differences_past_the_ninth_digit_do_not_turn_a_draw():
    potential, possible = torch.rand(30, generator=torch.Generator().manual_seed(1)).double(), torch.ones(30)
    shaken = potential.round(decimals=9) + 1e-10 * torch.linspace(-1, 1, 30).double()
    one, other = (
        draw(p, possible, 50, torch.Generator().manual_seed(0)) for p in (potential.round(decimals=9), shaken)
    )
    assert one == other


def test_where_nothing_is_possible_nothing_is_drawn(generator):
    assert draw(torch.zeros(3), torch.zeros(3, dtype=torch.bool), 5, generator) == []
    assert Given(())(RATING, judging({}), 5, generator) == []


def test_a_change_of_middling_promise_is_drawn_a_sixteenth_as_often_as_the_best(generator):
    best, middle, _ = counted(judging({BLOCKS[0]: 200.0, BLOCKS[1]: 100.0}), CHANGES, generator)
    assert best / middle == pytest.approx(16.0, rel=0.3)


def test_equal_promises_are_drawn_equally(generator):
    found = counted(judging(dict.fromkeys(BLOCKS, 50.0)), CHANGES, generator)
    assert [n / DRAWS for n in found] == pytest.approx([1 / 3] * 3, abs=0.03)


def test_what_the_new_segments_lose_counts_against_a_change(generator):
    loss = {**dict.fromkeys(BLOCKS, 100.0), **dict.fromkeys(halves(BLOCKS[1]), 50.0)}
    one, other, third = counted(judging(loss), CHANGES, generator)
    assert other < 0.2 * min(one, third)


def test_background_loses_the_things_in_it_and_not_what_it_would_lose_as_an_object(generator):
    table = RATING.scene.segmentation
    taken = Change((TABLE,), halves(TABLE), partial(table.replace, PAIRS.index(TABLE), halves(TABLE)))
    pixels = float(RATING.scene.pixel_count[0])
    as_object = judging({TABLE: 1000.0, BLOCKS[0]: pixels, BLOCKS[1]: pixels})
    assert counted(as_object, [*CHANGES[:2], taken], generator)[2] < 0.2 * DRAWS
    full_of_things = judging({BLOCKS[0]: 0.0}, lost=1.0)
    assert counted(full_of_things, [*CHANGES[:2], taken], generator)[2] > 0.8 * DRAWS


def test_no_change_is_drawn_twice(generator):
    problem = judging({BLOCKS[0]: 200.0})
    for _ in range(50):
        results = Given((*CHANGES, *CHANGES))(RATING, problem, 5, generator)
        assert sorted(results, key=hash) == sorted((change.result() for change in CHANGES), key=hash)
