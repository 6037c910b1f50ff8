import pytest
import torch

from blockstab.stability.refit import refit_axes
from blockstab.stability.support import GROUND, SupportType
from blockstab.testing import worlds
from blockstab.testing.worlds import TABLE, Block, judge


@pytest.mark.parametrize("gap", [0.0, 0.015, -0.01])  # exact contact, almost touching, sunk in
def test_a_stack_rests_by_surface_on_the_block_below(gap):
    verdict = judge(Block(0, 0, 0.2, 0.1), Block(0, 0.1 + gap, 0.2, 0.1))
    assert verdict.supporters(1) == {(0, "surface")}


def test_blocks_further_apart_than_the_touching_distance_do_not_support_each_other():
    verdict = judge(Block(0, 0, 0.2, 0.1), Block(0, 0.125, 0.2, 0.1))
    assert verdict.supporters(1) == set()


def test_a_box_tilted_by_noise_still_rests_by_surface():
    assert judge(Block(0, 0, 0.2, 0.1, tilt_deg=4.0)).supporters(0) == {TABLE}


def test_a_box_tilted_more_than_twenty_degrees_touches_the_ground_with_an_edge():
    verdict = judge(Block(0, 0, 0.2, 0.1, tilt_deg=25.0))
    assert verdict.supporters(0) == {(GROUND, "partial")}
    assert int(verdict.supports.area.count[0]) == 2


def test_a_box_that_leans_on_another_from_above_is_a_partial_support():
    verdict = judge(Block(0, 0, 0.3, 0.1), Block(0, 0.1, 0.2, 0.05, tilt_deg=30.0))
    assert ("partial") in {kind for _, kind in verdict.supporters(1)}


def test_the_lower_of_two_supports_the_higher():
    verdict = judge(*worlds.STACK)
    assert (0, 1) not in zip(
        verdict.candidates.supported.tolist(), verdict.candidates.supporter.tolist(), strict=True
    )


def test_a_box_cannot_be_held_from_the_side_by_one_that_rests_on_it():
    # The upper block hangs over and touches the flank of a third that stands on the lower one.
    verdict = judge(Block(0, 0, 0.4, 0.1), Block(-0.1, 0.1, 0.1, 0.1), Block(0.005, 0.1, 0.1, 0.2))
    side = verdict.candidates.type == SupportType.SIDE
    assert 0 not in verdict.candidates.supported[side].tolist()


def test_a_rigid_turn_about_the_vertical_changes_no_relation():
    boxes, _ = worlds.build(*worlds.STACK)
    assert len(boxes) == 2
    for blocks in (worlds.STACK, worlds.TENT, worlds.LEANING_PLANK, worlds.BRIDGE):
        plain = judge(*blocks)
        turned = worlds.judge_boxes(*_turned(*worlds.build(*blocks)))
        assert _relations(plain) == _relations(turned)


def _turned(boxes, movable):
    angle = torch.tensor(0.7, dtype=torch.float64)
    c, s = torch.cos(angle), torch.sin(angle)
    zero, one = torch.zeros_like(c), torch.ones_like(c)
    turn = torch.stack([c, zero, s, zero, one, zero, -s, zero, c]).view(3, 3)
    return boxes.rotated(turn), movable


def _relations(verdict):
    found = verdict.supports
    return set(zip(found.supporter.tolist(), found.supported.tolist(), found.type.tolist(), strict=True))


def test_the_refit_makes_a_box_tilted_by_noise_flat_and_leaves_a_leaning_one_alone():
    noisy = judge(Block(0, 0, 0.2, 0.1, tilt_deg=4.0))
    axes = refit_axes(noisy.boxes, noisy.supports, noisy.balance.stable)
    assert axes.tolist() == [[0.0, 1.0, 0.0]]
    leaning = judge(*worlds.LEANING_PLANK)
    axes = refit_axes(leaning.boxes, leaning.supports, leaning.balance.stable & leaning.movable)
    assert axes.isnan().all()


def test_a_tower_follows_the_surface_it_stands_on_all_the_way_up():
    tilted = judge(Block(0, 0, 0.3, 0.1, tilt_deg=3.0), Block(0, 0.105, 0.2, 0.1), Block(0, 0.205, 0.2, 0.1))
    axes = refit_axes(tilted.boxes, tilted.supports, tilted.balance.stable)
    assert axes.tolist() == [[0.0, 1.0, 0.0]] * 3
