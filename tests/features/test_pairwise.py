"""The features of two neighbours: those of their boxes against values worked by hand, then those of how they look."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
import torch

from blockstab.features.appearance.pair_columns import APPEARANCE_COLUMNS
from blockstab.features.pairwise import (
    BOX_COLUMNS,
    PAIRWISE_COLUMNS,
    box_features,
    neighbour_pairs,
    pairs_of,
    pairwise_features,
)
from blockstab.scene.types import Scene
from blockstab.testing import worlds
from blockstab.testing.worlds import Block
from tests.box_scene import alike, scene_of, scene_of_boxes
from tests.tolerance import EXACT

VOLUME = 0.2 * 0.1 * 0.1


def rows(scene: Scene) -> list[dict[str, float]]:
    return [dict(zip(BOX_COLUMNS, values, strict=True)) for values in box_features(scene).tolist()]


def judged(scene: Scene) -> list[tuple[int, int]]:
    first, second = neighbour_pairs(scene)
    return list(zip(first.tolist(), second.tolist(), strict=True))


def test_there_are_63_columns_each_with_its_own_name():
    # 12 of boxes, the type of support in three of them, and 51 of how the two look.
    scene = scene_of(*worlds.STACK)
    assert pairwise_features(scene, alike(pairs_of(scene))).shape == (1, 63)
    assert len(set(PAIRWISE_COLUMNS)) == len(PAIRWISE_COLUMNS) == 63
    assert [len(BOX_COLUMNS), len(APPEARANCE_COLUMNS)] == [12, 51]


def test_how_a_pair_looks_follows_what_its_boxes_say(generator):
    scene = scene_of(*worlds.STACK, Block(1, 0, 0.1, 0.1))
    looks = torch.rand(3, 51, dtype=torch.float64, generator=generator)
    features = pairwise_features(scene, looks)
    assert torch.equal(features[:, :12], box_features(scene))
    assert torch.equal(features[:, 12:], looks)


def test_pairs_are_named_by_their_segments():
    scene = scene_of(*worlds.STACK, pixels=(100, 200))
    assert pairs_of(scene) == [(frozenset({1}), frozenset({0}))]


@pytest.mark.parametrize(
    ("pixels", "order"), [((200, 100), (0, 1)), ((100, 200), (1, 0)), ((100, 100), (0, 1))]
)
def test_the_larger_segment_comes_first_and_of_equals_the_first(pixels, order):
    assert judged(scene_of(*worlds.STACK, pixels=pixels)) == [order]


def test_only_objects_that_share_a_border_are_judged():
    scene = scene_of(*worlds.STACK, Block(1, 0, 0.1, 0.1), Block(2, 0, 0.1, 3, fixed=True))
    far = replace(scene, pairs=replace(scene.pairs, neighbours=scene.pairs.second != 2))
    assert judged(scene) == [(1, 0), (2, 0), (2, 1)]
    assert judged(far) == [(1, 0)]


@pytest.mark.parametrize("blocks", [(Block(0, 0, 0.1, 0.1),), (Block(0, 0, 0.1, 0.1, fixed=True),) * 2])
def test_a_scene_without_pairs_has_no_rows(blocks):
    assert box_features(scene_of(*blocks)).shape == (0, 12)


def test_a_block_on_a_block_is_supported_by_its_surface():
    # The upper block stands 4 cm to the side, and 2 cm off the middle of what it has under it.
    for pixels in ((200, 100), (100, 200)):
        (values,) = rows(scene_of(Block(0, 0, 0.2, 0.1), Block(0.04, 0.1, 0.2, 0.1), pixels=pixels))
        assert [values[f"support_{kind}"] for kind in ("surface", "partial", "side")] == [1, 0, 0]
        assert values["supporting"] == values["stable_larger"] == values["stable_smaller"] == 1.0
        assert values["center_distance"] == pytest.approx(math.hypot(0.04, 0.1))
        assert values["offset_from_support"] == pytest.approx(0.02)


def test_a_tent_is_held_from_the_side():
    (values,) = rows(scene_of(*worlds.TENT))
    assert [values[f"support_{kind}"] for kind in ("surface", "partial", "side")] == [0, 0, 1]
    assert values["supporting"] == 1.0


def test_blocks_beside_each_other_support_nothing():
    (values,) = rows(scene_of(*worlds.TOUCHING_NEIGHBOURS))
    names = ("support_surface", "support_partial", "support_side", "supporting", "offset_from_support")
    assert [values[name] for name in names] == [0.0] * 5


def test_overlap_is_divided_by_the_volume_of_either_box():
    blocks = Block(0, 0, 0.2, 0.1), Block(0.12, 0, 0.1, 0.05), Block(-0.19, 0, 0.2, 0.1)
    by_pair = dict(zip(judged(scene_of(*blocks)), rows(scene_of(*blocks)), strict=True))
    values = by_pair[1, 0]  # the second has more pixels; they overlap by 3 cm
    assert values["overlap_relative_larger"] == pytest.approx(0.03 / (0.1 * 0.05 * 0.1))
    assert values["overlap_relative_smaller"] == pytest.approx(0.03 / VOLUME)
    assert (values["intersections_larger"], values["intersections_smaller"]) == (1, 1)
    assert by_pair[2, 0]["overlap_relative_larger"] == pytest.approx(0.01 / VOLUME)


def test_stability_is_told_of_each():
    scene = scene_of(*worlds.overhang(0.02), pixels=(100, 200))
    (values,) = rows(scene)
    assert (values["stable_larger"], values["stable_smaller"]) == tuple(
        float(stable) for stable in scene.balance.stable[[1, 0]]
    )
    assert values["stable_larger"] == 0.0


@pytest.mark.parametrize("blocks", [worlds.LEANING_PLANK, worlds.TENT, (Block(0, 1, 0.1, 0.1),) * 2])
def test_features_are_finite(blocks):
    assert bool(box_features(scene_of(*blocks)).isfinite().all())


@pytest.mark.parametrize("degrees", [37.0, 211.0])
def test_turning_the_world_about_the_vertical_changes_no_feature(degrees):
    boxes, movable = worlds.build(*worlds.COUNTERWEIGHT)
    cos, sin = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    turn = torch.tensor([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]], dtype=torch.float64)
    before = box_features(scene_of_boxes(boxes, movable))
    after = box_features(scene_of_boxes(boxes.rotated(turn), movable))
    torch.testing.assert_close(after, before, rtol=EXACT, atol=EXACT)


def test_renumbering_the_segments_permutes_the_rows():
    blocks, pixels, order = worlds.COUNTERWEIGHT, (100, 140, 120), (2, 0, 1)
    scene = scene_of(*blocks, pixels=pixels)
    renumbered = scene_of(*(blocks[k] for k in order), pixels=[pixels[k] for k in order])
    before = dict(zip(judged(scene), box_features(scene), strict=True))
    after = dict(zip(judged(renumbered), box_features(renumbered), strict=True))
    assert {(order[a], order[b]) for a, b in after} == before.keys()
    for (a, b), values in after.items():
        torch.testing.assert_close(values, before[order[a], order[b]], rtol=EXACT, atol=EXACT)
