"""Static equilibrium, where the answer can be worked out by hand."""

from __future__ import annotations

import math

import pytest
import torch

from blockstab.boxes.box import Boxes
from blockstab.stability.equilibrium import moving
from blockstab.testing.worlds import BRIDGE, COUNTERWEIGHT, LEANING_PLANK, Block, build, overhang
from tests.stability.touching import touching

LENGTH, STEEP = 0.5, math.radians(25.0)  # of planks, metres; how far they lean


def moves(world: tuple[Block, ...], friction: float = 0.7) -> list[bool]:
    boxes, movable = build(*world)
    return moving(boxes, movable, touching(boxes, movable), friction).tolist()


def on_incline(degrees: float, friction: float) -> bool:
    """Whether a cube stays on a slope."""
    boxes, movable = build(Block(0, -0.1, 2.0, 0.1, fixed=True), Block(0, 0, 0.1, 0.1))
    angle = math.radians(degrees)
    turn = torch.tensor(
        [[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]],
        dtype=torch.float64,
    )
    sloping = boxes.rotated(turn)
    raised = Boxes(sloping.center + torch.tensor([0.0, 5.0, 0.0]), sloping.rotation, sloping.half_extent)
    return not bool(moving(raised, movable, touching(raised, movable), friction).any())


def arch() -> tuple[Block, ...]:
    """Two planks that lean inwards, and a cube that their upper edges hold between them."""
    foot = LENGTH * math.sin(STEEP) + 0.05
    height = LENGTH * math.cos(STEEP)
    return (
        Block(foot + 0.01, 0, 0.02, LENGTH, tilt_deg=25.0),
        Block(-foot - 0.01, 0, 0.02, LENGTH, tilt_deg=-25.0),
        Block(0, height - 0.05, 0.1, 0.1),
    )


def test_a_beam_on_two_pillars_stands():
    assert moves(BRIDGE) == [False, False, False]


def test_a_block_in_the_air_moves_and_background_does_not():
    assert moves((Block(0, 0.3, 0.1, 0.1), Block(1, 0.3, 0.1, 0.1, fixed=True))) == [True, False]


@pytest.mark.parametrize(("past_m", "falls"), [(-0.001, False), (0.001, True)])
def test_a_block_tips_where_its_middle_is_beyond_the_edge_below(past_m, falls):
    assert moves(overhang(past_m)) == [False, falls]


@pytest.mark.parametrize("count", range(2, 11))
def test_an_overhang_reaches_the_harmonic_sum_and_no_further(count):
    for share, stands in ((0.99, True), (1.01, False)):
        x, world = 0.0, [Block(0, 0.02 * (count - 1), 0.2, 0.02)]
        for k in range(1, count):  # from the top: the k blocks above weigh down at half a length over k
            x -= share * 0.2 / (2 * k)
            world.append(Block(x, 0.02 * (count - 1 - k), 0.2, 0.02))
        assert (not any(moves(tuple(world)))) == stands


def test_a_counterweight_holds_a_beam_that_falls_without_it():
    assert moves(COUNTERWEIGHT) == [False, False, False]
    assert moves(COUNTERWEIGHT[:2]) == [False, True]


@pytest.mark.parametrize("friction", [0.1, 0.3, 0.9])
def test_a_cube_stays_on_a_slope_up_to_the_angle_of_friction(friction):
    angle = math.degrees(math.atan(friction))
    assert on_incline(angle - 0.1, friction)
    assert not on_incline(angle + 0.1, friction)


def test_a_cube_tips_over_on_a_slope_of_45_degrees_whatever_the_friction():
    assert on_incline(44.9, 5.0)
    assert not on_incline(45.1, 5.0)


def test_two_planks_hold_each_other_if_neither_feet_nor_tips_slip():
    # The moment about a foot: half a plank's weight times the sine is the thrust times the cosine. The thrust is
    # level, and the face that the other tip presses on leans by 25 degrees.
    tent = tuple(
        Block(s * (LENGTH * math.sin(STEEP) + 0.01), 0, 0.02, LENGTH, tilt_deg=25.0 * s) for s in (1, -1)
    )
    assert moves(tent, 1.02 * math.tan(STEEP)) == [False, False]
    assert moves(tent, 0.98 * math.tan(STEEP) / 2) == [True, True]


def test_an_arch_of_three_needs_friction_to_hold_its_keystone():
    # Each plank carries half the keystone, as heavy as itself, so the thrust is the weight times the tangent.
    least = 0.5 / math.tan(STEEP)
    assert moves(arch(), 1.1 * least) == [False, False, False]
    assert moves(arch(), 0.9 * least)[2]
    assert moves(arch(), 0.0) == [True, True, True]


def test_a_plank_slips_from_a_wall_without_friction():
    assert moves(LEANING_PLANK, 0.7) == [False, False]
    assert moves(LEANING_PLANK, 0.05) == [True, False]
