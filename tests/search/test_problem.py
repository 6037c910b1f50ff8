"""What a search may ask of an image: each thing is worked out once, and too small parts are no segments."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from blockstab.features.columns import LONE_COLUMNS
from blockstab.proposals.pool import Regions
from blockstab.proposals.watershed import Watershed
from blockstab.search.problem import MIN_SEGMENT_PX, Problem
from blockstab.segments.hierarchy import nodes, split
from tests.search.watched import blocks_view, watched
from tests.synthetic import over_split
from tests.tolerance import EXACT
from tests.toy_potentials import toy_potentials


def problem() -> Problem:
    return watched(blocks_view()).problem


def test_a_segment_by_itself_loses_by_its_pixels_what_the_potential_says_of_it():
    now, segments = problem(), over_split(blocks_view()).segments
    large = [s for s in segments if now.pixel_count(s) >= MIN_SEGMENT_PX]
    share = toy_potentials().alone(now.describe.lone(large)).clamp(0, 1)
    expected = share * torch.tensor([now.pixel_count(s) for s in large])
    assert now.losses(large) == pytest.approx(expected.tolist(), rel=EXACT)
    assert 0.0 < float(share.amin()) < 1.0


def test_the_potential_is_asked_once_of_each_segment_that_is_large_enough():
    asked: list[int] = []

    def counting(rows: torch.Tensor) -> torch.Tensor:
        assert rows.shape[1] == len(LONE_COLUMNS)
        asked.append(len(rows))
        return torch.zeros(len(rows), dtype=torch.float64)

    now, segments = replace(problem(), alone=counting), blocks_view().start.segments
    now.losses(segments)
    now.losses([*segments, *segments])
    now.losses(over_split(blocks_view()).segments)
    new = set(over_split(blocks_view()).segments) - set(segments)
    # What is too small is lost whole, whatever the potential would say.
    large = [[s for s in some if now.pixel_count(s) >= MIN_SEGMENT_PX] for some in (segments, new)]
    assert asked == list(map(len, large))
    assert len(large[1]) > 0


def test_pixels_of_a_segment_are_those_of_the_image():
    now, label = problem(), blocks_view().start.labels(blocks_view().atoms)
    for number, segment in enumerate(blocks_view().start.segments, start=1):
        assert now.pixel_count(segment) == int((label == number).sum())


def test_a_segment_falls_in_two_as_the_hierarchy_says_unless_a_part_is_too_small():
    now = problem()
    for segment in nodes(now.hierarchy):
        parts = split(segment, now.search_input.atoms, now.hierarchy)
        small = parts is None or min(map(now.pixel_count, parts)) < MIN_SEGMENT_PX
        assert now.split(segment) == (None if small else parts)
    assert {now.split(s) is None for s in nodes(now.hierarchy) if len(s) > 1} == {True, False}


def test_the_pool_is_what_was_offered_and_the_nodes_each_once_and_large_enough():
    now = watched(blocks_view(), pool=Regions((Watershed(threshold=0.3), Watershed(threshold=0.3)))).problem
    offered = set(Regions((Watershed(threshold=0.3),))(blocks_view()))
    everything = offered | set(nodes(now.hierarchy))
    assert len(set(now.masks)) == len(now.masks)
    assert set(now.masks) == {s for s in everything if now.pixel_count(s) >= MIN_SEGMENT_PX}
    assert set(now.masks) > set(now.nodes)
    assert set(problem().masks) == set(now.nodes)


def test_nodes_in_a_segment_are_proper_parts_of_it_that_leave_enough():
    now = problem()
    whole = max(now.nodes, key=len)
    parts = {(n, whole - n) for n in now.nodes if n < whole and now.pixel_count(whole - n) >= MIN_SEGMENT_PX}
    assert set(now.nodes_in(whole)) == parts
    assert len(now.nodes_in(whole)) == len(parts) > 1


def test_masks_in_a_segment_are_those_that_cut_it_with_what_they_leave():
    now = problem()
    for segment in over_split(blocks_view()).segments:
        assert now.masks_in(segment) == {m: segment - m for m in now.masks if m & segment}


def test_what_is_made_once_is_not_made_again():
    now, made = problem(), list[int]()
    assert [now.once(key, lambda: made.append(0) or len(made)) for key in "aba"] == [1, 2, 1]


def test_atoms_touch_those_that_they_share_a_border_with():
    now, atoms = problem(), blocks_view().atoms
    pairs = set(zip(atoms.first.tolist(), atoms.second.tolist(), strict=True))
    touching = {(min(a, b), max(a, b)) for a, row in now.touching.items() for b in row}
    assert touching == pairs


@pytest.mark.parametrize("count", [0, 1, 4])
def test_segmentations_are_rated_in_order(count):
    some = [over_split(blocks_view(), rounds) for rounds in range(count)]
    rated = problem().rate(some)
    assert [rating.scene.segmentation for rating in rated] == some
