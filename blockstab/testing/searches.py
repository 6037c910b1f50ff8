"""Contracts of moves, searches and energies."""

from __future__ import annotations

from functools import cache
from itertools import chain, pairwise

import torch
from torch import Tensor

from blockstab.energy import Energy, Potential, Rating
from blockstab.energy.overlap import expected_overlap
from blockstab.observation import given_ground, observe
from blockstab.proposals.pool import Regions
from blockstab.proposals.search_input import SearchInput, make_search_input
from blockstab.proposals.watershed import Watershed
from blockstab.scene.inference import Rules
from blockstab.search import Search, SearchResult, rank
from blockstab.search.moves import Move
from blockstab.search.problem import EnergyFactory, Problem, problem_of
from blockstab.segments.segmentation import Segment, Segmentation
from blockstab.testing.photographs import BLOCKS, photograph

WITHIN = 1e-9  # what the company that a number is computed in may change of it
_MANY = 50


class PlainPotentials:
    """Potentials that say something of every row, and have learned nothing: for tests."""

    weight = 0.1

    @property
    def unary(self) -> Potential:
        """Between 0 and 1, of the row's numbers."""
        return _plain

    pairwise = alone = background = unary


class MoveContract:
    """Tests of a `Move`."""

    part: Move

    def test_it_is_possible_from_some_segmentation(self) -> None:
        """Of those that the tests start from."""
        assert any(self._made(start) for start in starts())

    def test_every_result_divides_the_same_atoms_in_order(self) -> None:
        """A partition comes out, and what is told is told of its segments."""
        atoms = list(range(len(search_input().atoms)))
        for start in starts():
            for result in self._made(start):
                assert sorted(chain(*result.segments)) == atoms
                assert all(result.segments)
                assert list(result.segments) == sorted(result.segments, key=min)
                assert set(result.background) <= set(result.segments)

    def test_every_result_differs_from_where_it_started(self) -> None:
        """In its segments, or in what is told of them."""
        for start in starts():
            assert start not in self._made(start)

    def test_no_more_results_come_than_were_asked_for(self) -> None:
        """However many there are."""
        for start in starts():
            for count in (1, 3):
                assert len(self._made(start, count=count)) <= count

    def test_it_draws_from_its_generator_alone(self) -> None:
        """The same seed gives the same results, and nobody else's draws change."""
        before = torch.get_rng_state()
        for start in starts():
            assert self._made(start, seed=3, count=3) == self._made(start, seed=3, count=3)
        assert torch.equal(torch.get_rng_state(), before)

    def _made(self, start: Segmentation, seed: int = 0, count: int = _MANY) -> list[Segmentation]:
        return self.part(rated(start), problem(), count, torch.Generator().manual_seed(seed))


class SearchContract:
    """Tests of a `Search`."""

    part: Search

    def test_the_result_divides_the_same_atoms(self) -> None:
        """Whatever the start."""
        for start in starts():
            segments = self._found(start).best.scene.segmentation.segments
            assert sorted(chain(*segments)) == list(range(len(search_input().atoms)))

    def test_the_trace_never_rises_and_ends_at_the_result(self) -> None:
        """Energies of the best after each step, the start's first."""
        for start in starts():
            found = self._found(start)
            assert all(after <= before for before, after in pairwise(found.trace))
            assert found.trace[-1] == rank(found.best)
            assert found.bests[-1] == found.best.scene.segmentation
            assert len(found.bests) == len(found.trace)

    def test_it_draws_from_its_generator_alone(self) -> None:
        """The same seed gives the same result, and nobody else's draws change."""
        before, start = torch.get_rng_state(), starts()[-1]
        one, other = self._found(start), self._found(start)
        assert one.best.scene.segmentation == other.best.scene.segmentation
        assert one.trace == other.trace
        assert torch.equal(torch.get_rng_state(), before)

    def _found(self, start: Segmentation, seed: int = 0) -> SearchResult:
        return self.part(start, problem(), torch.Generator().manual_seed(seed))


class EnergyContract:
    """Tests of an `EnergyFactory`."""

    part: EnergyFactory

    def test_an_energy_is_a_number_for_each_scene_with_potentials_of_all_segments(self) -> None:
        """Ratings of the scenes that were given, in their order."""
        described = problem().describe(problem().build(starts()))
        ratings = self._energy()(described)
        assert [r.scene for r in ratings] == [one.scene for one in described]
        for rating in ratings:
            assert rating.energy.shape == ()
            assert bool(rating.energy.isfinite())
            assert rating.unary.shape == (len(rating.scene),)

    def test_a_scene_is_rated_in_any_company_as_alone(self) -> None:
        """Within 1e-9."""
        described, energy = problem().describe(problem().build(starts())), self._energy()
        for one, together in zip(described, energy(described), strict=True):
            (alone,) = energy([one])
            torch.testing.assert_close(alone.energy, together.energy, rtol=0.0, atol=WITHIN)

    def _energy(self) -> Energy:
        # A function that is an attribute of a class would be taken for a method.
        factory: EnergyFactory = vars(type(self))["part"]
        return factory(PlainPotentials(), search_input())


@cache
def search_input() -> SearchInput:
    """Blocks on a table, over-segmented."""
    observation = observe(photograph(*BLOCKS).frame, given_ground)
    return make_search_input(observation, Watershed(threshold=0.2))


@cache
def problem() -> Problem:
    """The blocks, with the regions of another watershed to carve."""
    pool = Regions((Watershed(threshold=0.5),))
    return problem_of(search_input(), Rules(), PlainPotentials(), expected_overlap, pool)


@cache
def starts() -> tuple[Segmentation, ...]:
    """The start of the image; all things as one; a thing told to be background; and all things in pieces."""
    start = search_input().start
    things = [s for s in start.segments if start.background.get(s) is not True]
    heap = frozenset().union(*things)
    rest = [s for s in start.segments if s not in things]
    told = {pair for pair in start.told if pair[0] in rest}
    together = Segmentation(tuple(sorted([*rest, heap], key=min)), frozenset(told))
    wall = start.telling({max(things, key=problem().pixel_count): True})
    pieces = [part for s in things for part in _pieces(s)]
    apart = Segmentation(tuple(sorted([*rest, *pieces], key=min)), frozenset(told))
    return start, together, wall, apart


def _pieces(segment: Segment, rounds: int = 3) -> list[Segment]:
    parts = problem().split(segment) if rounds else None
    return [one for part in parts for one in _pieces(part, rounds - 1)] if parts else [segment]


def rated(start: Segmentation) -> Rating:
    """The rating of a start."""
    return problem().rate([start])[0]


def _plain(rows: Tensor) -> Tensor:
    return torch.sigmoid(rows.nan_to_num(0.0).clamp(-1.0, 1.0).mean(dim=1))
