"""Algorithm 2: its constants, its pool, and that a step costs what is new."""

from __future__ import annotations

from dataclasses import replace
from itertools import chain, pairwise

from hydra.utils import instantiate

from blockstab.energy.truth import true_overlap
from blockstab.search import rank
from blockstab.search.greedy import Greedy
from blockstab.search.moves.merge import Merge
from blockstab.search.moves.split import Split
from blockstab.search.none import NoSearch
from blockstab.search.rsamp import RSamp
from tests.docs.pages import composed
from tests.search.watched import blocks_view, seeded, watched
from tests.synthetic import over_split

PAPER = RSamp(
    (Split(), Merge()), moves_per_kind=5, pool_size=5, rounds=15, patience=5, at_once=1, first=(Greedy(),)
)
FROM_START = replace(PAPER, first=(NoSearch(),))


def configured(name: str) -> RSamp:
    """The search of a configuration; lists in it are tuples in the class."""
    search = instantiate(composed("evaluate", [f"search={name}"]).search)
    return replace(search, moves=tuple(search.moves), first=tuple(search.first))


def test_the_search_of_the_paper_is_its_two_moves_with_its_constants_from_where_greedy_merging_ends():
    assert configured("paper") == PAPER


def test_the_configuration_of_the_default_search_says_what_the_class_does():
    assert configured("rsamp") == RSamp()


def test_it_starts_where_the_searches_that_go_first_end():
    search_input = blocks_view()
    start = over_split(search_input)
    first = Greedy()(start, watched(search_input).problem, seeded(0))
    found = replace(PAPER, rounds=2)(start, watched(search_input).problem, seeded(0))
    assert found.bests[0] == first.bests[-1]
    assert found.trace[0] == first.trace[-1] >= rank(found.best)


def test_the_best_of_several_first_searches_is_the_first_best():
    start = over_split(blocks_view())
    problem = watched(blocks_view()).problem
    stay, greedy = (rank(search(start, problem, seeded(0)).best) for search in (NoSearch(), Greedy()))
    found = RSamp(rounds=0, first=(NoSearch(), Greedy()))(start, problem, seeded(0))
    assert greedy < stay
    assert found.trace == (greedy,)


def test_the_lowest_energy_never_rises():
    found = FROM_START(over_split(blocks_view()), watched(blocks_view()).problem, seeded(1))
    assert all(after <= before for before, after in pairwise(found.trace))
    assert found.trace[-1] < found.trace[0]


def test_with_the_truth_as_energy_it_finds_the_truth():
    problem = watched(blocks_view(), true_overlap).problem
    found = RSamp()(over_split(blocks_view()), problem, seeded(0))
    assert found.best.scene.segmentation.segments == blocks_view().start.segments
    assert found.trace[-1] == 0.0


def test_a_first_round_tries_at_most_5_splits_and_5_merges_and_later_ones_from_5_particles():
    account = watched(blocks_view())
    replace(FROM_START, rounds=3)(over_split(blocks_view(), 2), account.problem, seeded(0))
    start, first, *later = [len(call) for call in account.interpreted]
    assert start == 1
    assert first <= 10
    assert all(10 < proposed <= 50 for proposed in later)


def test_no_segmentation_is_understood_twice():
    account = watched(blocks_view())
    FROM_START(over_split(blocks_view()), account.problem, seeded(0))
    everything = list(chain(*account.interpreted))
    assert len(everything) == len(set(everything))


def test_every_move_of_the_paper_changes_one_segment_or_one_pair():
    account = watched(blocks_view())
    start = over_split(blocks_view())
    replace(FROM_START, rounds=1)(start, account.problem, seeded(0))
    for proposed in account.interpreted[1]:
        gone, new = set(start.segments) - set(proposed.segments), set(proposed.segments) - set(start.segments)
        assert sorted([len(gone), len(new)]) == [1, 2]
        assert frozenset().union(*gone) == frozenset().union(*new)


def test_boxes_are_fitted_once_and_those_of_a_round_in_one_batch():
    account = watched(blocks_view())
    FROM_START(over_split(blocks_view()), account.problem, seeded(0))
    segments = {s for call in account.interpreted for one in call for s in one.segments}
    assert sum(account.fitter.free) == len(segments)
    assert len(account.fitter.free) <= len(account.interpreted)
    assert sum(account.fitter.free) + sum(account.fitter.refits) == len(account.builder.box_cache)


def test_a_move_costs_one_or_two_new_boxes():
    account = watched(blocks_view())
    replace(FROM_START, rounds=4)(over_split(blocks_view()), account.problem, seeded(0))
    # The first boxes are those of the image's start, which the energy is told of; then come those of this search's.
    for call, fitted in zip(account.interpreted[1:], account.fitter.free[2:], strict=True):
        assert fitted <= 2 * len(call)


def test_it_stops_when_the_best_has_not_changed_for_the_rounds_of_its_patience():
    # The truth is the best there is, so every round is in vain.
    problem = watched(blocks_view(), true_overlap).problem
    found = replace(FROM_START, patience=2)(blocks_view().start, problem, seeded(0))
    assert found.trace == (0.0,) * 3
    assert found.best.scene.segmentation == blocks_view().start


def test_without_rounds_the_result_is_the_first_particle():
    start = over_split(blocks_view())
    found = replace(FROM_START, rounds=0)(start, watched(blocks_view()).problem, seeded(0))
    assert found.best.scene.segmentation == start


def test_a_search_and_a_move_of_the_users_own_can_take_part():
    class Nowhere:
        def __call__(self, start, problem, generator):
            return NoSearch()(over_split(blocks_view()), problem, generator)

    class Home:
        def __call__(self, rating, problem, count, generator):
            return [blocks_view().start]

    problem = watched(blocks_view(), true_overlap).problem
    search = RSamp((Home(),), rounds=1, first=(Nowhere(),))
    assert search(blocks_view().start, problem, seeded(0)).bests == (
        over_split(blocks_view()),
        blocks_view().start,
    )
