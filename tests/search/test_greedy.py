"""Greedy merging: it takes what lowers the energy most, and ends where nothing does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest
import torch

from blockstab.energy import Rating
from blockstab.energy.overlap import expected_overlap
from blockstab.energy.paper import paper_energy
from blockstab.energy.truth import true_overlap
from blockstab.features.pairwise import pairs_of
from blockstab.search import rank
from blockstab.search.greedy import Greedy
from blockstab.search.problem import Problem
from blockstab.segments.segmentation import Segmentation
from tests.search.watched import blocks_view, in_scene, seeded, watched
from tests.synthetic import over_split, variants

energies = pytest.mark.parametrize("energy", [expected_overlap, true_overlap, paper_energy])


def merges(segmentation: Segmentation, problem: Problem) -> list[Segmentation]:
    """The segmentation after each merge of two neighbouring objects."""
    (rating,) = problem.rate([segmentation])
    place = segmentation.segments.index
    return [segmentation.merge(place(one), place(other)) for one, other in pairs_of(rating.scene)]


@energies
@pytest.mark.parametrize("start", variants(blocks_view(), 8)[1:], ids=lambda start: f"{len(start)} segments")
def test_merging_lowers_the_energy_at_every_step_and_ends_where_no_merge_does(energy, start):
    problem = watched(blocks_view(), energy).problem
    found = Greedy()(start, problem, seeded(0))
    assert list(found.trace) == sorted(set(found.trace), reverse=True)
    after = [rank(rating) for rating in problem.rate(merges(found.best.scene.segmentation, problem))]
    assert all(found.trace[-1] <= energy for energy in after)


@pytest.mark.parametrize("energy", [in_scene, true_overlap])
@pytest.mark.parametrize("rounds", [1, 2])
def test_pieces_of_blocks_become_blocks_again(rounds, energy):
    found = Greedy()(over_split(blocks_view(), rounds), watched(blocks_view(), energy).problem, seeded(0))
    assert found.best.scene.segmentation.segments == blocks_view().start.segments


def test_the_pair_whose_merge_lowers_the_energy_most_goes_first():
    account, start = watched(blocks_view()), over_split(blocks_view())
    tried = merges(start, account.problem)
    best = min(account.problem.rate(tried), key=rank)
    account.interpreted.clear()
    found = Greedy()(start, account.problem, seeded(0))
    assert found.bests[:2] == (start, best.scene.segmentation)
    assert account.interpreted[1] == tried  # all of them in one batch


def test_a_pair_is_judged_again_only_where_its_surroundings_changed():
    account, start = watched(blocks_view()), over_split(blocks_view(), 2)
    Greedy()(start, account.problem, seeded(0))
    _, first, _, second, *_ = account.interpreted
    assert len(first) == len(merges(start, account.problem))
    assert 0 < len(second) < len(first) - 1


def test_an_energy_that_finds_every_merge_worse_leaves_the_start_and_one_that_finds_it_better_one_object():
    def counting(sign: float, problem: Problem) -> Problem:
        def energy(scenes: Sequence[object]) -> list[Rating]:
            return [replace(r, energy=torch.tensor(sign * len(r.scene))) for r in problem.energy(scenes)]

        return replace(problem, energy=energy)

    start, problem = over_split(blocks_view()), watched(blocks_view()).problem
    assert Greedy()(start, counting(-1.0, problem), seeded(0)).bests == (start,)
    everything = Greedy()(start, counting(1.0, problem), seeded(0)).best.scene
    assert pairs_of(everything) == []
    assert len(everything) < len(blocks_view().start)


def test_the_larger_segment_of_a_pair_comes_first():
    account = watched(blocks_view())
    (scene,) = account.problem.build([over_split(blocks_view())])
    size = dict(zip(scene.segmentation.segments, scene.pixel_count.tolist(), strict=True))
    assert all(size[first] >= size[second] for first, second in pairs_of(scene))


def test_background_is_in_no_pair():
    account = watched(blocks_view())
    (scene,) = account.problem.build([over_split(blocks_view())])
    table = blocks_view().start.segments[0]
    assert all(table not in pair for pair in pairs_of(scene))
    everything = replace(scene, background=torch.ones_like(scene.background))
    assert pairs_of(everything) == []
