"""What every move must keep to."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from functools import cache
from itertools import chain

import pytest
import torch
from torch import Tensor

from blockstab.search.moves import Move
from blockstab.search.moves.carve import Carve
from blockstab.search.moves.every import EVERY
from blockstab.search.moves.turn import Turn
from blockstab.segments.segmentation import Segmentation
from tests.search.moves.starts import STARTS, problem, rating
from tests.search.watched import blocks_view, seeded

every_move = pytest.mark.parametrize("move", EVERY, ids=lambda move: type(move).__name__)
every_start = pytest.mark.parametrize("start", STARTS)
# What these are for is to take from background, and to turn it.
keeping_background = pytest.mark.parametrize(
    "move", [m for m in EVERY if not isinstance(m, Carve | Turn)], ids=lambda move: type(move).__name__
)
MANY = 200


def proposed(move: Move, start: str, seed: int = 0, count: int = MANY) -> list[Segmentation]:
    return move(rating(start), problem(), count, seeded(seed))


known = cache(proposed)  # for the tests that only look at it


@every_move
def test_a_move_is_possible_from_some_of_the_starts(move):
    assert any(known(move, start) for start in STARTS)


@every_move
@every_start
def test_every_result_divides_the_same_atoms(move, start):
    for result in known(move, start):
        assert sorted(chain(*result.segments)) == list(range(len(blocks_view().atoms)))
        assert all(result.segments)
        assert list(result.segments) == sorted(result.segments, key=min)


@every_move
@every_start
def test_every_result_differs_from_the_start(move, start):
    assert STARTS[start] not in known(move, start)
    outcomes = {(s.segments, rated_background(s)) for s in known(move, start)}
    assert (STARTS[start].segments, rated_background(STARTS[start])) not in outcomes


@every_move
@every_start
@pytest.mark.parametrize("count", [1, 3])
def test_no_more_results_come_than_were_asked_for(move, start, count):
    assert len(proposed(move, start, count=count)) <= count


@every_move
@every_start
def test_the_same_seed_gives_the_same_results(move, start):
    assert proposed(move, start, seed=3, count=3) == proposed(move, start, seed=3, count=3)


@every_move
def test_some_seeds_give_other_results(move):
    assert any(len({tuple(proposed(move, start, k, 1)) for k in range(12)}) > 1 for start in STARTS)


@every_move
@every_start
def test_a_move_draws_from_its_generator_alone(move, start):
    before = torch.get_rng_state()
    proposed(move, start)
    assert torch.equal(torch.get_rng_state(), before)


@every_move
@every_start
def test_a_move_changes_nothing_that_it_is_given(move, start):
    before = [tensor.clone() for tensor in tensors(rating(start))]
    segmentation, masks = rating(start).scene.segmentation, problem().masks
    copy = (tuple(map(frozenset, segmentation.segments)), frozenset(segmentation.told))
    proposed(move, start)
    for tensor, was in zip(tensors(rating(start)), before, strict=True):
        torch.testing.assert_close(tensor, was, rtol=0.0, atol=0.0, equal_nan=True)
    assert rating(start).scene.segmentation is segmentation
    assert (segmentation.segments, segmentation.told) == copy
    assert problem().masks is masks


@keeping_background
@every_start
def test_background_is_neither_split_nor_joined(move, start):
    scene = rating(start).scene
    background = {
        s for s, apart in zip(scene.segmentation.segments, scene.background.tolist(), strict=True) if apart
    }
    assert background
    for result in known(move, start):
        assert background <= set(result.segments)
        assert all(result.background.get(s) == scene.segmentation.background.get(s) for s in background)


@every_move
@every_start
def test_what_is_told_is_told_of_segments_that_are_there(move, start):
    for result in known(move, start):
        assert set(result.background) <= set(result.segments)


@every_move
def test_a_move_that_finds_nothing_to_do_proposes_nothing(move):
    alone = Segmentation((frozenset(range(len(blocks_view().atoms))),))
    (table,) = problem().rate([alone.telling({alone.segments[0]: True})])
    results = move(table, problem(), 5, seeded(0))
    assert bool(results) == isinstance(move, Carve | Turn)


def rated_background(segmentation: Segmentation) -> tuple[bool, ...]:
    """Which segments count as background."""
    return tuple(problem().build([segmentation])[0].background.tolist())


def tensors(value: object) -> list[Tensor]:
    if isinstance(value, Tensor):
        return [value]
    if is_dataclass(value):
        return list(chain(*(tensors(getattr(value, field.name)) for field in fields(value))))
    return []
