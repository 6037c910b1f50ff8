"""Greedy merging: what it judges, in which order it merges, and when it stops."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from blockstab.features.merging import MERGE_COLUMNS, merge_features
from blockstab.features.pairwise import pairs_of
from blockstab.features.unary import unary_features
from blockstab.search.greedy import Greedy, merge_rows
from tests.search.watched import blocks_view, seeded, watched
from tests.synthetic import over_split


@pytest.mark.parametrize("rounds", [1, 2])
def test_pieces_of_blocks_become_blocks_again(rounds):
    found = Greedy()(over_split(blocks_view(), rounds), watched(blocks_view()).problem, seeded(0))
    assert found.best.scene.segmentation == blocks_view().start


def test_merging_goes_on_until_no_pair_is_below_the_threshold():
    start, account = over_split(blocks_view()), watched(blocks_view())
    assert len(Greedy(threshold=-10.0)(start, account.problem, seeded(0)).best.scene) == len(start)
    everything = Greedy(threshold=10.0)(start, account.problem, seeded(0)).best.scene
    assert pairs_of(everything) == []
    assert len(everything) < len(blocks_view().start)


def test_the_pair_that_most_looks_like_one_object_goes_first():
    account, start = watched(blocks_view()), over_split(blocks_view())
    (scene,) = account.problem.interpret([start])
    pairs = pairs_of(scene)
    appearance = account.problem.energy.appearance
    badness = account.problem.merge(merge_rows(scene, pairs, account.problem.interpret, appearance))
    first, second = pairs[int(badness.argmin())]
    account.interpreted.clear()
    Greedy()(start, account.problem, seeded(0))
    _, tried, (after_first,), *_ = account.interpreted
    assert len(tried) == len(pairs)
    assert first | second in after_first.segments
    assert len(after_first) == len(start) - 1


def test_a_pair_is_judged_again_only_where_its_surroundings_changed():
    account, start = watched(blocks_view()), over_split(blocks_view(), 2)
    Greedy()(start, account.problem, seeded(0))
    _, _, (after_first,), *_ = account.interpreted
    before, after = account.problem.interpret([start, after_first])
    assert account.judged[0] == len(pairs_of(before))
    assert account.judged[1] < len(pairs_of(after))


def test_every_merge_is_understood_in_the_whole_scene():
    account, start = watched(blocks_view()), over_split(blocks_view())
    (scene,) = account.problem.interpret([start])
    pairs = pairs_of(scene)
    appearance = account.problem.energy.appearance
    rows = merge_rows(scene, pairs, account.problem.interpret, appearance)
    assert rows.shape == (len(pairs), len(MERGE_COLUMNS))
    assert len(account.interpreted[-1]) == len(pairs)  # all of them in one batch
    first, second = pairs[1]
    a, b = start.segments.index(first), start.segments.index(second)
    (after,) = account.problem.interpret([start.merge(a, b)])
    merged = unary_features(after)[after.segmentation.segments.index(first | second)]
    larger, smaller = torch.tensor([a]), torch.tensor([b])
    expected = merge_features(
        unary_features(scene), larger, smaller, merged[None], appearance([(first, second)])
    )
    assert torch.equal(rows[1:2], expected)


def test_the_larger_segment_of_a_pair_comes_first():
    account = watched(blocks_view())
    (scene,) = account.problem.interpret([over_split(blocks_view())])
    size = dict(zip(scene.segmentation.segments, scene.pixels.tolist(), strict=True))
    assert all(size[first] >= size[second] for first, second in pairs_of(scene))


def test_background_is_in_no_pair():
    account = watched(blocks_view())
    (scene,) = account.problem.interpret([over_split(blocks_view())])
    table = blocks_view().start.segments[0]
    assert all(table not in pair for pair in pairs_of(scene))
    everything = replace(scene, background=torch.ones_like(scene.background))
    assert pairs_of(everything) == []
