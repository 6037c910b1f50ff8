"""Planes taken away, and clusters of what is left."""

from __future__ import annotations

from blockstab.proposals.plane_dbscan import PlaneDBSCAN
from tests.block_scene import APART, TABLE, picture


def test_the_table_is_the_plane_and_blocks_apart_are_clusters_of_their_own() -> None:
    scene = picture(APART)
    # The fronts of the blocks are larger than a tenth of what is seen: with one plane, that of the table.
    proposed = PlaneDBSCAN(planes=1)(scene.observation)
    assert proposed.is_background == {1: True}
    table = (scene.frame.label == TABLE) & scene.cloud.valid
    assert float((proposed.label[table] == 1).double().mean()) > 0.99
    found = [proposed.label[scene.frame.label == block].mode().values for block in (2, 3)]
    assert len({1, *map(int, found)}) == 3


def test_no_plane_is_taken_that_holds_too_little() -> None:
    proposed = PlaneDBSCAN(least_share=1.1)(picture(APART).observation)
    assert proposed.is_background == {}
    assert not bool((proposed.label == 1).any())
