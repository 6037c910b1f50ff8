"""Things stood on things, and structures side by side."""

from __future__ import annotations

import math

import pytest
import torch

from blockstab.boxes.separation import separation
from blockstab.simulation.layouts.draws import any_turn
from blockstab.simulation.layouts.placing import (
    LIFT,
    about,
    about_up,
    beside,
    clear,
    height,
    leaning,
    lifted,
    shifted,
    side_by_side,
    stand,
)
from blockstab.simulation.layouts.products import draw_product
from blockstab.simulation.physics.solids import box, concatenate
from tests.tolerance import EXACT

BRICK = box([0.1, 0.03, 0.05])


@pytest.mark.parametrize(("axis", "before", "after"), [(0, 1, 2), (1, 2, 0), (2, 0, 1)])
def test_a_quarter_turn_about_an_axis_takes_the_next_to_the_one_after(
    axis: int, before: int, after: int
) -> None:
    turn = about(axis, math.pi / 2)
    assert torch.allclose(turn[:, before], torch.eye(3, dtype=torch.float64)[after], atol=EXACT)


def test_turns_about_up_come_one_for_every_angle() -> None:
    yaw = torch.tensor([0.1, -2.0], dtype=torch.float64)
    assert torch.equal(about_up(yaw), torch.stack([about(1, float(each)) for each in yaw]))


@pytest.mark.parametrize("tilt", [0.0, 0.4, math.pi / 2, 2.0])
def test_what_stands_touches_its_support_with_its_lowest_corner(tilt: float) -> None:
    pile = stand(BRICK, 0.2, -0.1, on=0.07, yaw=0.3, tilt=about(2, tilt))
    assert float(pile.boxes().corners()[..., 1].min()) == pytest.approx(0.07, abs=EXACT)
    assert pile.center[0, [0, 2]].tolist() == [0.2, -0.1]


def test_a_leaning_plank_touches_the_ground_and_the_edge() -> None:
    support = box([0.04, 0.05, 0.05])
    pile = concatenate([stand(support), leaning(BRICK, 0.6, height(support), -0.04)])
    assert float(pile.boxes().corners()[1, :, 1].min()) == pytest.approx(0.0, abs=EXACT)
    gap = separation(pile.boxes(), torch.tensor([0]), torch.tensor([1])).gap
    assert float(gap) == pytest.approx(0.0, abs=EXACT)
    edge = torch.tensor([-0.04, 0.1, 0.0], dtype=torch.float64)
    local = pile.boxes()[[1]].local(edge[None, None])[0, 0]
    assert float(local[1]) == pytest.approx(-0.03, abs=EXACT)


def test_every_level_is_lifted_once_more_and_the_leaning_one_above_all() -> None:
    tower = [stand(BRICK, on=level * height(BRICK)) for level in range(2)]
    pile = concatenate([*tower, stand(BRICK, x=0.4), leaning(BRICK, 0.3, 0.05, -0.2)])
    up = (lifted(pile).center - pile.center)[:, 1]
    assert torch.allclose(up / LIFT, torch.tensor([1.0, 2.0, 1.0, 3.0], dtype=torch.float64), atol=1e-6)


def test_piles_are_clear_of_each_other_up_to_the_width_of_the_gap() -> None:
    first, second = stand(BRICK), shifted(stand(BRICK), x=0.21)
    assert clear(first, second, 0.0099)
    assert not clear(first, second, 0.0101)


def test_there_is_no_place_beside_what_fills_the_table(generator: torch.Generator) -> None:
    slab = stand(box([0.45, 0.01, 0.45]))
    assert beside(generator, stand(BRICK), [slab]) is None
    assert beside(generator, stand(BRICK), []) is not None


def test_structures_are_added_until_there_are_enough_but_never_too_many(generator: torch.Generator) -> None:
    pair = concatenate([stand(BRICK), stand(BRICK, on=height(BRICK))])
    counts = {len(side_by_side(generator, [lambda _: pair], (3, 5), 5)) for _ in range(10)}
    assert counts == {4}


def test_piles_are_clear_of_each_other_exactly_where_all_gaps_are_wide_enough(
    generator: torch.Generator,
) -> None:
    seen = set()
    for _ in range(300):
        one, other = (stand(draw_product(generator, "book"), tilt=any_turn(generator)) for _ in range(2))
        place = 0.3 * (torch.rand(3, generator=generator, dtype=torch.float64) - 0.5)
        moved = shifted(other, *place.tolist())
        both = concatenate([one, moved]).boxes()
        gap = separation(both, torch.tensor([0]), torch.tensor([1])).gap
        assert clear(one, moved, 0.02) == bool(gap >= 0.02)
        seen.add(bool(gap >= 0.02))
    assert seen == {True, False}
