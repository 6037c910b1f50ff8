"""Algorithm 2: its constants, its pool, and that a step costs what is new."""

from __future__ import annotations

from itertools import chain, pairwise

from blockstab.search.greedy import Greedy
from blockstab.search.rsamp import RSamp
from blockstab.search.stay import Stay
from tests.search.watched import blocks_view, seeded, watched
from tests.synthetic import over_split

FROM_START = RSamp(first=Stay())


def test_the_constants_are_those_of_the_paper():
    assert (RSamp().moves_per_kind, RSamp().pool_size, RSamp().rounds) == (5, 5, 15)


def test_it_starts_where_greedy_merging_ends():
    view = blocks_view()
    start = over_split(view)
    first = Greedy()(start, watched(view).problem, seeded(0))
    found = RSamp(rounds=2)(start, watched(view).problem, seeded(0))
    assert RSamp().first == Greedy()
    assert found.trace[: len(first.trace)] == first.trace
    assert found.best.energy <= first.best.energy


def test_the_lowest_energy_never_rises():
    found = FROM_START(over_split(blocks_view()), watched(blocks_view()).problem, seeded(1))
    assert all(after <= before for before, after in pairwise(found.trace))
    assert found.trace[-1] < found.trace[0]


def test_a_first_round_tries_at_most_5_splits_and_5_merges_and_later_ones_from_5_particles():
    account = watched(blocks_view())
    RSamp(rounds=3, first=Stay())(over_split(blocks_view()), account.problem, seeded(0))
    start, first, *later = [len(call) for call in account.interpreted]
    assert start == 1
    assert first <= 10
    assert all(10 < proposed <= 50 for proposed in later)


def test_no_segmentation_is_understood_twice():
    account = watched(blocks_view())
    FROM_START(over_split(blocks_view()), account.problem, seeded(0))
    everything = list(chain(*account.interpreted))
    assert len(everything) == len(set(everything))


def test_every_move_changes_one_segment_or_one_pair():
    account = watched(blocks_view())
    start = over_split(blocks_view())
    RSamp(rounds=1, first=Stay())(start, account.problem, seeded(0))
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
    assert sum(account.fitter.free) + sum(account.fitter.refits) == len(account.interpreter.catalogue)


def test_a_move_costs_one_or_two_new_boxes():
    account = watched(blocks_view())
    RSamp(rounds=4, first=Stay())(over_split(blocks_view()), account.problem, seeded(0))
    for call, fitted in zip(account.interpreted[1:], account.fitter.free[1:], strict=True):
        assert fitted <= 2 * len(call)


def test_it_stops_when_the_best_has_not_changed_for_the_rounds_of_its_patience():
    # The truth is the best there is, so every round is in vain.
    found = RSamp(patience=2, first=Stay())(blocks_view().start, watched(blocks_view()).problem, seeded(0))
    assert found.trace == (found.best.energy,) * 3
    assert found.best.scene.segmentation == blocks_view().start


def test_without_rounds_the_result_is_the_first_particle():
    found = RSamp(rounds=0, first=Stay())(
        over_split(blocks_view()), watched(blocks_view()).problem, seeded(0)
    )
    assert found.best.scene.segmentation == over_split(blocks_view())


def test_a_search_of_the_users_own_can_go_first():
    class Nowhere:
        def __call__(self, start, problem, generator):
            return Stay()(blocks_view().start, problem, generator)

    found = RSamp(rounds=0, first=Nowhere())(
        over_split(blocks_view()), watched(blocks_view()).problem, seeded(0)
    )
    assert found.best.scene.segmentation == blocks_view().start
