"""Carving: a mask of the pool becomes an object, whatever it lay in."""

from __future__ import annotations

from blockstab.search.moves.carve import Carve
from blockstab.segments.segmentation import Segmentation
from tests.search.moves.starts import STARTS, problem, rating
from tests.search.watched import seeded

ALL = 10**6  # more than there are


def carved(start: str) -> list[Segmentation]:
    return Carve()(rating(start), problem(), ALL, seeded(0))


def test_every_mask_of_the_pool_that_is_no_object_yet_can_be_carved():
    for start, segmentation in STARTS.items():
        scene = rating(start).scene
        objects = {s for s, b in zip(segmentation.segments, scene.background.tolist(), strict=True) if not b}
        expected = {segmentation.carve(mask) for mask in problem().masks if mask not in objects}
        assert set(carved(start)) == expected


def test_out_of_told_background_comes_an_object_and_the_rest_stays_background():
    table, results = STARTS["truth"].segments[0], carved("truth")
    inside = [mask for mask in problem().masks if mask < table]
    assert inside
    for mask in inside:
        (result,) = (one for one in results if one.background.get(mask) is False)
        (scene,) = problem().build([result])
        assert result.background[table - mask] is True
        assert scene.background.tolist() == [s == table - mask for s in result.segments]


def test_a_mask_over_several_objects_takes_from_all_of_them():
    blocks = STARTS["truth"].segments[1:]
    over = [
        mask
        for mask in problem().masks
        if sum(not mask.isdisjoint(b) for b in blocks) > 1 and mask not in STARTS["truth"].segments
    ]
    assert over
    results = carved("truth")
    for mask in over:
        (result,) = (one for one in results if mask in one.segments)
        assert all(s == mask or s.isdisjoint(mask) for s in result.segments)


def test_background_itself_becomes_an_object_where_the_pool_has_it_as_a_mask():
    wall = next(s for s, apart in STARTS["wall"].background.items() if apart and len(s) < 10)
    turned = [result for result in carved("wall") if result.segments == STARTS["wall"].segments]
    assert (wall in problem().masks) == bool(turned)
    assert all(result.background[wall] is False for result in turned)
