"""What every search must keep to."""

from __future__ import annotations

from functools import cache
from itertools import chain

import pytest
import torch

from blockstab.energy import NEUTRAL
from blockstab.proposals.watershed import Watershed
from blockstab.search import Found, Search
from blockstab.search.greedy import Greedy
from blockstab.search.rsamp import RSamp
from blockstab.search.stay import Stay
from tests.search.watched import Watched, blocks_view, seeded, watched
from tests.synthetic import over_split, photograph, view_of
from tests.worlds import Block

SEARCHES = [Stay(), Greedy(), RSamp(rounds=3), RSamp(rounds=3, first=Stay())]
everyone = pytest.mark.parametrize("search", SEARCHES, ids=["stay", "greedy", "rsamp", "rsamp-alone"])


def outcome(search: Search, seed: int = 0) -> tuple[Found, Watched]:
    """Search on the blocks, from a start with every block in two pieces."""
    account = watched(blocks_view())
    return search(over_split(blocks_view()), account.problem, seeded(seed)), account


known = cache(outcome)  # for the tests that only look at it


@everyone
def test_the_result_divides_the_same_atoms(search):
    segments = known(search)[0].best.scene.segmentation.segments
    assert sorted(chain(*segments)) == list(range(len(blocks_view().atoms)))
    assert all(segments)


@everyone
def test_background_is_neither_split_nor_joined_with_an_object(search):
    table = blocks_view().start.segments[0]
    found, account = known(search)
    assert found.best.scene.background.tolist() == [True] + [False] * (len(found.best.scene) - 1)
    for segmentation in chain(*account.interpreted):
        assert segmentation.segments[0] == table


@everyone
def test_the_same_seed_finds_the_same(search):
    (one, _), (two, _) = known(search), outcome(search)
    assert one.best.scene.segmentation == two.best.scene.segmentation
    assert one.best.energy == two.best.energy
    assert one.trace == two.trace


@everyone
def test_a_search_draws_from_its_generator_alone(search):
    problem, start = watched(blocks_view()).problem, over_split(blocks_view())
    before = torch.get_rng_state()
    search(start, problem, seeded(0))
    assert torch.equal(torch.get_rng_state(), before)


@everyone
def test_the_energy_is_that_of_the_result(search):
    found, _ = known(search)
    problem = watched(blocks_view()).problem
    (rating,) = problem.energy(problem.interpret([found.best.scene.segmentation]))
    assert found.best.energy == rating.energy == found.trace[-1]


@everyone
def test_the_result_is_no_worse_than_the_start(search):
    found, _ = known(search)
    assert found.best.energy <= found.trace[0] == known(Stay())[0].best.energy


@everyone
def test_where_nothing_can_move_the_start_is_the_result(search):
    view = view_of(photograph(Block(0, 0, 0.01, 0.01, d=0.01)), Watershed(least_px=1000))
    found = search(view.start, watched(view).problem, seeded(0))
    assert len(view.start) == 1  # the table alone
    assert found.best.scene.segmentation == view.start
    assert found.best.energy == 2 * NEUTRAL


def test_different_seeds_take_different_ways():
    tried = [outcome(RSamp(rounds=1, first=Stay()), seed)[1].interpreted[1] for seed in range(3)]
    assert len({frozenset(segmentations) for segmentations in tried}) == 3
