"""What every search must keep to."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import chain, pairwise

import pytest
import torch

from blockstab.proposals.watershed import Watershed
from blockstab.search import Search, SearchResult, rank
from blockstab.search.best_cut import BestCut
from blockstab.search.greedy import Greedy
from blockstab.search.moves.every import EVERY
from blockstab.search.moves.merge import Merge
from blockstab.search.moves.split import Split
from blockstab.search.none import NoSearch
from blockstab.search.rsamp import RSamp
from blockstab.search.truth import Truth
from blockstab.testing.photographs import photograph
from blockstab.testing.worlds import Block
from tests.search.watched import Watched, blocks_view, seeded, watched
from tests.synthetic import over_split, view_of
from tests.tolerance import COMPANY

PAPER = RSamp((Split(), Merge()), 5, 5, 3, 5, (Greedy(),))
SEARCHES: dict[str, Search] = {
    "none": NoSearch(),
    "greedy": Greedy(),
    "best cut": BestCut(),
    "truth": Truth(),
    "rsamp": RSamp(rounds=2),
    "rsamp of the paper": PAPER,
    "rsamp alone": replace(PAPER, first=(NoSearch(),)),
}
everyone = pytest.mark.parametrize("name", SEARCHES)
# The others end at what they are made for, whatever its energy.
lowering = pytest.mark.parametrize("name", [name for name in SEARCHES if name not in ("best cut", "truth")])
# It has moves that may touch background.
keeping_background = pytest.mark.parametrize("name", [name for name in SEARCHES if name != "rsamp"])


def outcome(name: str, seed: int = 0) -> tuple[SearchResult, Watched]:
    """Search on the blocks, from a start with every block in two pieces."""
    account = watched(blocks_view())
    return SEARCHES[name](over_split(blocks_view()), account.problem, seeded(seed)), account


known = cache(outcome)  # for the tests that only look at it


@everyone
def test_the_result_divides_the_same_atoms(name):
    segments = known(name)[0].best.scene.segmentation.segments
    assert sorted(chain(*segments)) == list(range(len(blocks_view().atoms)))
    assert all(segments)


@keeping_background
def test_background_is_neither_split_nor_joined_with_an_object(name):
    table = blocks_view().start.segments[0]
    found, account = known(name)
    assert found.best.scene.background.tolist() == [True] + [False] * (len(found.best.scene) - 1)
    for segmentation in chain(*account.interpreted):
        assert segmentation.segments[0] == table


@everyone
def test_the_same_seed_finds_the_same(name):
    (one, _), (two, _) = known(name), outcome(name)
    assert one.best.scene.segmentation == two.best.scene.segmentation
    assert torch.equal(one.best.energy, two.best.energy)
    assert one.trace == two.trace
    assert one.bests == two.bests


@everyone
def test_a_search_draws_from_its_generator_alone(name):
    problem, start = watched(blocks_view()).problem, over_split(blocks_view())
    before = torch.get_rng_state()
    SEARCHES[name](start, problem, seeded(0))
    assert torch.equal(torch.get_rng_state(), before)


@everyone
def test_the_trace_is_the_energy_of_the_best_after_each_step_and_ends_at_the_result(name):
    found, _ = known(name)
    ratings = watched(blocks_view()).problem.rate(found.bests)
    assert found.trace == pytest.approx([float(rating.energy) for rating in ratings], abs=COMPANY)
    assert found.bests[-1] == found.best.scene.segmentation
    assert found.trace[-1] == rank(found.best)


@lowering
def test_the_energy_never_rises_from_one_step_to_the_next(name):
    found, _ = known(name)
    assert all(after <= before for before, after in pairwise(found.trace))


@lowering
def test_the_result_is_no_worse_than_the_start(name):
    found, _ = known(name)
    assert found.trace[-1] <= known("none")[0].trace[0]


@everyone
def test_where_nothing_can_move_the_start_is_the_result(name):
    search_input = view_of(photograph(Block(0, 0, 0.01, 0.01, d=0.01)), Watershed(least_px=1000))
    assert len(search_input.start) == 1  # the table alone
    found = SEARCHES[name](search_input.start, watched(search_input).problem, seeded(0))
    assert found.best.scene.segmentation == search_input.start
    assert found.best.scene.background.tolist() == [True]


def test_different_seeds_take_different_ways():
    tried = [outcome("rsamp alone", seed)[1].interpreted[1] for seed in range(3)]
    assert len({frozenset(segmentations) for segmentations in tried}) == 3


def test_every_kind_of_move_is_tried_unless_a_search_is_told_otherwise():
    assert RSamp().moves == EVERY
    assert len({type(move) for move in EVERY}) == len(EVERY) == 8
