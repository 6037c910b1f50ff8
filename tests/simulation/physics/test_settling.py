"""Rest and falls of piles small enough to be worked out by hand."""

from __future__ import annotations

import sys

import pytest
import torch

from blockstab.simulation.physics.settling import falls, moves, settle
from blockstab.simulation.physics.shapes import bottle, bowl, cylinder, l_shape, sphere
from blockstab.simulation.physics.solids import Pile, Solid, box, concatenate
from tests.simulation.resting import bridge, put, rested, seesaw, tower

pytest.importorskip("mujoco", reason="the extra `sim` is not installed")

CUBE = box((0.05, 0.05, 0.05))


def test_blocks_settle_where_they_are_put() -> None:
    expected = torch.tensor([0.04, 0.12, 0.2], dtype=torch.float64)
    assert torch.allclose(tower().center[:, 1], expected, atol=0.0005)


@pytest.mark.parametrize(
    "solid",
    [
        sphere(0.04),
        cylinder(0.035, 0.05),
        bowl(0.08, 0.035),
        bottle(0.04, 0.14),
        l_shape((0.06, 0.06, 0.04), 0.03),
    ],
    ids=lambda solid: solid.kind,
)
def test_every_shape_stands_as_it_should_with_its_bounding_box_on_the_table(solid: Solid) -> None:
    pile = rested(put(solid, 0.1, float(solid.half_extent[1]) + 0.001))
    assert float(pile.center[0, 1]) == pytest.approx(float(solid.half_extent[1]), abs=0.0005)
    assert float(pile.center[0, [0, 2]].sub(torch.tensor([0.1, 0.0])).norm()) < 0.0005
    assert float(pile.rotation[0, 1, 1]) > 0.9999


@pytest.mark.parametrize("solid", [cylinder(0.035, 0.05), bottle(0.04, 0.14)], ids=lambda solid: solid.kind)
def test_what_lies_on_its_round_side_comes_to_rest(solid: Solid) -> None:
    radius = float(solid.half_extent[0])
    pile = rested(put(solid, 0.0, radius + 0.001, lean_deg=90.0))
    assert float(pile.center[0, 1]) == pytest.approx(radius, abs=0.001)


def test_a_ball_in_a_bowl_lies_on_the_bowl_s_bottom() -> None:
    pile = rested(put(bowl(0.08, 0.035), 0.0, 0.036), put(sphere(0.03), 0.0, 0.06))
    assert float(pile.center[1, 1]) == pytest.approx(0.08 * 0.08 + 0.03, abs=0.001)


def test_a_block_too_far_over_the_edge_does_not_stay() -> None:
    lower, upper = put(CUBE, 0.0, 0.051), put(box((0.06, 0.05, 0.05)), 0.08, 0.152)
    pile = concatenate([lower, upper])
    resting = settle(pile)
    assert resting is None or float((resting.center - pile.center).norm(dim=1).max()) > 0.05
    assert moves(pile).tolist() == [False, True]


@pytest.mark.parametrize(("shift", "moved"), [(0.045, False), (0.055, True)])
def test_a_block_in_exact_contact_moves_only_if_its_centre_is_past_the_edge(
    shift: float, moved: bool
) -> None:
    pile = concatenate([put(CUBE, 0.0, 0.05), put(CUBE, shift, 0.15)])
    assert moves(pile).tolist() == [False, moved]


def test_what_still_falls_after_four_seconds_is_not_at_rest() -> None:
    assert settle(put(CUBE, 0.0, 100.0)) is None


def test_a_tower_may_be_higher_than_the_table_is_wide() -> None:
    brick = box((0.08, 0.1, 0.08))
    pile = rested(*(put(brick, 0.0, 0.1 + 0.2 * k) for k in range(6)))
    assert float(pile.center[-1, 1]) == pytest.approx(1.1, abs=0.001)


def test_what_leaves_the_table_is_lost() -> None:
    assert settle(put(CUBE, 0.6, 0.05)) is None


def test_a_ball_that_spins_where_it_is_has_not_moved_but_one_that_rolls_has() -> None:
    ball = put(sphere(0.04), 0.0, 0.04)
    turned = Pile(ball.solids, ball.center, put(CUBE, 0, 0, lean_deg=90.0).rotation)
    assert not moves(turned).any()
    down = concatenate([put(box((0.1, 0.01, 0.1)), 0.0, 0.1, lean_deg=-25.0), put(sphere(0.04), 0.0, 0.16)])
    assert moves(down).tolist()[1]


def test_all_above_a_removed_layer_falls() -> None:
    assert falls(tower()).tolist() == [[False, True, True], [False, False, True], [False, False, False]]


def test_a_bridge_falls_with_either_pillar_but_the_other_pillar_stays() -> None:
    assert falls(bridge()).tolist() == [[False, False, True], [False, False, True], [False, False, False]]


def test_a_beam_falls_without_its_counterweight_though_that_is_above_it() -> None:
    assert falls(seesaw())[2].tolist() == [False, True, False]


def test_what_touches_nothing_but_the_table_fells_nothing() -> None:
    assert not falls(rested(put(CUBE, 0.0, 0.051), put(CUBE, 0.3, 0.051))).any()


def test_the_same_pile_settles_to_the_same_bits() -> None:
    first, second = (
        settle(concatenate([put(bowl(0.08, 0.035), 0.0, 0.036), put(sphere(0.03), 0.01, 0.08)])) for _ in "ab"
    )
    assert first is not None
    assert second is not None
    assert torch.equal(first.center, second.center)
    assert torch.equal(first.rotation, second.rotation)


def test_the_missing_engine_is_named_with_the_command_that_installs_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(ModuleNotFoundError, match=r"pip install 'blockstab\[sim\]'"):
        settle(put(CUBE, 0.0, 0.05))
