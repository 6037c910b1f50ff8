"""The best cut of the merge tree: as good as the best of all cuts, tried one by one."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import chain, product

import pytest
import torch

from blockstab.search.best_cut import BestCut
from blockstab.search.problem import MIN_SEGMENT_PX, Problem
from blockstab.segments.hierarchy import nodes
from blockstab.segments.segmentation import Segment, Segmentation
from blockstab.testing.photographs import BLOCKS, photograph
from blockstab.testing.worlds import Block
from tests.search.watched import blocks_view, seeded, watched
from tests.synthetic import over_split, view_of

SMALL = view_of(photograph(*BLOCKS[:2]))
TINY = view_of(photograph(Block(0, 0, 0.05, 0.05, d=0.05), BLOCKS[0]))
problems = pytest.mark.parametrize("search_input", [SMALL, TINY], ids=["tower", "two"])


def cuts(node: Segment, parts: dict[Segment, tuple[Segment, Segment]]) -> list[frozenset[Segment]]:
    """Every way to cut what a node was made from."""
    whole = [frozenset({node})]
    if node not in parts:
        return whole
    apart = product(*(cuts(part, parts) for part in parts[node]))
    return whole + [one | other for one, other in apart]


def made_from(problem: Problem) -> tuple[list[Segment], dict[Segment, tuple[Segment, Segment]]]:
    """The nodes that no other is made from; and what each node was made from."""
    found, hierarchy = nodes(problem.hierarchy), problem.hierarchy
    now = {atom: frozenset({atom}) for atom in range(len(problem.search_input.atoms))}
    parts = {}
    for kept, gone in zip(hierarchy.first.tolist(), hierarchy.second.tolist(), strict=True):
        whole = now[kept] | now[gone]
        parts[whole] = (now[kept], now.pop(gone))
        now[kept] = whole
    assert set(found) == set(parts) | {frozenset({a}) for a in range(len(problem.search_input.atoms))}
    return list(now.values()), parts


def loss(problem: Problem, segments: frozenset[Segment]) -> float:
    return math.fsum(problem.losses(list(segments)))


def all_cuts(problem: Problem, free: Segment) -> set[frozenset[Segment]]:
    """Every cut of the hierarchy, of each of its segments that part which is free."""
    roots, parts = made_from(problem)
    whole = (frozenset().union(*one) for one in product(*(cuts(root, parts) for root in roots)))
    return {frozenset(s & free for s in cut if s & free) for cut in whole}


@problems
def test_no_cut_of_the_hierarchy_loses_less(search_input):
    problem = watched(search_input).problem
    found = BestCut()(search_input.start, problem, seeded(0)).best.scene.segmentation
    (scene,) = problem.build([search_input.start])
    kept = {s for s, b in zip(search_input.start.segments, scene.background.tolist(), strict=True) if b}
    free = frozenset(chain(*(s for s in search_input.start.segments if s not in kept)))
    every = all_cuts(problem, free)
    assert len(every) > 5
    objects = frozenset(found.segments) - kept
    assert objects in every
    least = min(loss(problem, cut) for cut in every)
    assert loss(problem, objects) == pytest.approx(least, rel=1e-12)


@problems
def test_where_all_is_free_it_is_the_best_cut_of_all(search_input):
    problem = watched(search_input).problem
    nothing = Segmentation(search_input.start.segments).telling(
        dict.fromkeys(search_input.start.segments, False)
    )
    found = BestCut()(nothing, problem, seeded(0)).best.scene.segmentation
    every = all_cuts(problem, frozenset(range(len(search_input.atoms))))
    assert loss(problem, frozenset(found.segments)) == pytest.approx(
        min(loss(problem, cut) for cut in every), rel=1e-12
    )


@pytest.mark.parametrize("seed", range(8))
def test_it_is_so_whatever_segments_lose(seed):
    drawn = seeded(seed)
    problem = replace(
        watched(SMALL).problem, alone=lambda rows: torch.rand(len(rows), generator=drawn, dtype=torch.float64)
    )
    told = Segmentation(SMALL.start.segments).telling(dict.fromkeys(SMALL.start.segments, False))
    found = BestCut()(told, problem, seeded(0)).best.scene.segmentation
    least = min(loss(problem, cut) for cut in all_cuts(problem, frozenset(range(len(SMALL.atoms)))))
    assert loss(problem, frozenset(found.segments)) == pytest.approx(least, rel=1e-12)


def test_background_stays_as_the_start_has_it_and_is_told():
    search_input = blocks_view()
    start = over_split(search_input)
    wall = start.segments[2]
    found = BestCut()(start.telling({wall: True}), watched(search_input).problem, seeded(0)).best.scene
    background = {s for s, b in zip(found.segmentation.segments, found.background.tolist(), strict=True) if b}
    assert background == {start.segments[0], wall}
    assert dict(found.segmentation.background) == dict.fromkeys(background, True)


def test_a_part_is_kept_whole_where_it_loses_no_more_than_its_parts():
    problem = watched(SMALL).problem
    even = replace(problem, alone=lambda rows: torch.ones(len(rows), dtype=torch.float64))
    found = BestCut()(SMALL.start, even, seeded(0)).best.scene.segmentation
    objects = frozenset().union(*SMALL.start.segments[1:])
    roots = {node for node in nodes(problem.hierarchy) if objects <= node}
    assert roots
    assert found.segments == (SMALL.start.segments[0], objects)


def test_too_small_a_part_loses_all_of_itself():
    problem = watched(SMALL).problem
    small = [s for s in nodes(problem.hierarchy) if problem.pixel_count(s) < MIN_SEGMENT_PX]
    assert small
    assert problem.losses(small) == [problem.pixel_count(s) for s in small]
