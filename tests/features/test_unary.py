"""The 30 features of a segment, against values worked by hand."""

from __future__ import annotations

import math

import pytest
import torch

from blockstab.features.unary import UNARY_COLUMNS, unary_features
from blockstab.scene.types import Scene
from blockstab.testing import worlds
from blockstab.testing.worlds import Block
from tests.box_scene import FIT_MEAN, FIT_VARIANCE, VISIBLE, scene_of, scene_of_boxes
from tests.tolerance import EXACT

VOLUME = 0.2 * 0.1 * 0.1


def row(scene: Scene, segment: int) -> dict[str, float]:
    return dict(zip(UNARY_COLUMNS, unary_features(scene)[segment].tolist(), strict=True))


def corners(scene: Scene, segment: int, ending: str = "") -> list[float]:
    values = row(scene, segment)
    return [values[f"offset_from_corner_{k}{ending}"] for k in range(8)]


def test_there_are_30_columns_each_with_its_own_name():
    assert unary_features(scene_of(*worlds.STACK)).shape == (2, 30)
    assert len(set(UNARY_COLUMNS)) == 30


def test_what_is_known_of_the_fit_is_divided_by_the_volume_of_the_box():
    values = row(scene_of(*worlds.STACK, pixels=(400, 100)), 0)
    assert values["surface_distance_mean"] == FIT_MEAN
    assert values["surface_distance_variance"] == FIT_VARIANCE
    assert values["surface_distance_mean_relative"] == pytest.approx(FIT_MEAN / VOLUME)
    assert values["surface_distance_variance_relative"] == pytest.approx(FIT_VARIANCE / VOLUME)
    assert values["density"] == pytest.approx(400 / VOLUME)
    assert values["visible_share"] == VISIBLE


def test_a_straight_stack_is_stable_and_centred():
    for segment in (0, 1):
        values = row(scene_of(*worlds.STACK), segment)
        for name in ("orientation", "intersections", "overlap", "offset_from_support"):
            assert values[name] == pytest.approx(0.0, abs=EXACT), name
        assert values["stable"] == values["stable_alone"] == 1.0


def test_offsets_are_those_of_the_box_with_all_that_rests_on_it():
    # The upper block stands 4 cm to the side: both together are 2 cm off the middle of the lower one.
    scene = scene_of(Block(0, 0, 0.2, 0.1), Block(0.04, 0.1, 0.2, 0.1))
    near, far = math.hypot(0.08, 0.05), math.hypot(0.12, 0.05)
    assert corners(scene, 0) == pytest.approx([near] * 4 + [far] * 4)
    assert corners(scene, 0, "_relative") == pytest.approx([near / VOLUME] * 4 + [far / VOLUME] * 4)
    for segment in (0, 1):  # the upper one is 2 cm off the middle of what it has under it
        values = row(scene, segment)
        assert values["offset_from_support"] == pytest.approx(0.02)
        assert values["offset_from_support_relative"] == pytest.approx(0.02 / VOLUME)


def test_a_block_may_be_stable_alone_and_topple_under_its_load():
    scene = scene_of(*worlds.FINE_LOCALLY_FALLS_GLOBALLY)
    assert [row(scene, 1)[name] for name in ("stable", "stable_alone")] == [0.0, 1.0]


@pytest.mark.parametrize(("depth", "count"), [(0.03, 1), (0.005, 0), (0.0, 0), (-0.01, 0)])
def test_a_box_intersects_what_it_overlaps_by_more_than_the_noise(depth, count):
    scene = scene_of(Block(0, 0, 0.2, 0.1), Block(0.2 - depth, 0, 0.2, 0.1))
    for segment in (0, 1):
        values = row(scene, segment)
        assert values["intersections"] == count
        assert values["overlap"] == pytest.approx(max(depth, 0.0), abs=EXACT)
        assert values["overlap_relative"] == pytest.approx(max(depth, 0.0) / VOLUME, abs=1e-6)


def test_the_overlap_is_the_mean_over_what_is_overlapped():
    blocks = Block(0, 0, 0.2, 0.1), Block(0.18, 0, 0.2, 0.1), Block(-0.16, 0, 0.2, 0.1), Block(1, 0, 0.2, 0.1)
    values = row(scene_of(*blocks), 0)
    assert values["intersections"] == 2
    assert values["overlap"] == pytest.approx(0.03)


def test_background_is_no_intersection():
    values = row(scene_of(Block(0, 0, 0.2, 0.1), Block(0, -0.02, 2.0, 0.1, d=2.0, fixed=True)), 0)
    assert values["intersections"] == values["overlap"] == 0.0


@pytest.mark.parametrize("tilt", [10.0, -40.0])
def test_orientation_is_the_angle_of_the_steepest_axis_to_the_vertical(tilt):
    values = row(scene_of(Block(0, 0, 0.1, 0.3, tilt_deg=tilt)), 0)
    assert values["orientation"] == pytest.approx(math.radians(abs(tilt)))


@pytest.mark.parametrize(
    "blocks",
    [
        (Block(0, 1.0, 0.2, 0.1),),  # hangs in the air
        (Block(0, 0, 0.01, 0.01, d=0.01),),  # as small as a box can be
        (Block(0, 0, 0.2, 0.1, fixed=True),),  # background alone
        worlds.TENT,
        worlds.LEANING_PLANK,
        worlds.BRIDGE,
    ],
)
def test_features_are_finite(blocks):
    assert bool(unary_features(scene_of(*blocks)).isfinite().all())


def test_what_nothing_supports_is_a_metre_from_its_support():
    assert row(scene_of(Block(0, 1.0, 0.2, 0.1)), 0)["offset_from_support"] == 1.0


@pytest.mark.parametrize("blocks", [worlds.BRIDGE, worlds.COUNTERWEIGHT, worlds.LEANING_PLANK])
@pytest.mark.parametrize("degrees", [37.0, 90.0, 211.0])
def test_turning_the_world_about_the_vertical_changes_no_feature(blocks, degrees):
    boxes, movable = worlds.build(*blocks)
    cos, sin = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    turn = torch.tensor([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]], dtype=torch.float64)
    before = unary_features(scene_of_boxes(boxes, movable))
    after = unary_features(scene_of_boxes(boxes.rotated(turn), movable))
    # The angle of an upright box to the vertical is an arc cosine at one, where rounding has a root's effect.
    torch.testing.assert_close(after[:, 1:], before[:, 1:], rtol=EXACT, atol=EXACT)
    torch.testing.assert_close(after[:, 0], before[:, 0], rtol=0.0, atol=1e-7)


def test_renumbering_the_segments_permutes_the_rows():
    blocks, order = (*worlds.COUNTERWEIGHT, *worlds.overhang(0.3)[:1]), torch.tensor([2, 0, 3, 1])
    pixels = [100, 140, 120, 160]
    rows = unary_features(scene_of(*blocks, pixels=pixels))
    renumbered = scene_of(*(blocks[k] for k in order), pixels=[pixels[k] for k in order])
    torch.testing.assert_close(unary_features(renumbered), rows[order], rtol=EXACT, atol=EXACT)
