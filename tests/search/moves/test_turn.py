"""Turning: an object becomes background, or background an object."""

from __future__ import annotations

from collections import Counter

from blockstab.search.moves.turn import Turn
from tests.search.moves.starts import STARTS, problem, rating
from tests.search.watched import seeded


def test_one_segment_changes_sides_and_nothing_else_does():
    for start in STARTS:
        scene = rating(start).scene
        results = Turn()(rating(start), problem(), 300, seeded(0))
        assert len(results) == len(scene)  # every segment, each once
        for result, now in zip(results, problem().build(results), strict=True):
            assert result.segments == scene.segmentation.segments
            assert int((now.background != scene.background).sum()) == 1


def test_what_is_told_is_turned_and_what_was_found_out_is_told():
    table = STARTS["truth"].segments[0]
    results = Turn()(rating("truth"), problem(), 300, seeded(0))
    assert sorted(len(result.background) for result in results) == [len(STARTS["truth"])] * len(results)
    assert any(result.background[table] is False for result in results)
    untold = Turn()(rating("untold"), problem(), 300, seeded(0))
    assert {tuple(result.background.values()) for result in untold} == {(True,), (False,)}
    assert [result.background[table] for result in untold if table in result.background] == [False]


def test_an_object_on_the_ground_is_turned_more_often_than_a_good_one():
    table = STARTS["truth"].segments[0]
    ground = max((mask for mask in problem().masks if mask < table), key=problem().pixel_count)
    (now,) = problem().rate([STARTS["truth"].carve(ground)])
    drawn = Counter(
        next(s for s in now.scene.segmentation.segments if result.background[s] != told[s])
        for told in [now.scene.segmentation.background]
        for seed in range(200)
        for result in Turn()(now, problem(), 1, seeded(seed))
    )
    assert drawn[ground] > 3 * max(n for s, n in drawn.items() if s != ground)
