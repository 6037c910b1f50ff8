"""Shares of weight and types of support, in piles worked out by hand."""

from __future__ import annotations

import math

import pytest
import torch
from torch import Tensor

from blockstab.simulation.physics.contacts import CARRIES, contacts
from blockstab.simulation.physics.shapes import bowl, cylinder, sphere
from blockstab.simulation.physics.solids import Pile, box
from blockstab.stability.support import SupportType
from tests.simulation.resting import bridge, leaning_plank, put, rested, seesaw, tower

pytest.importorskip("mujoco", reason="the extra `sim` is not installed")

CARRIED = 0.01  # share of a weight; averaged over 0.05 s at rest
CUBE = box((0.05, 0.05, 0.05))
ORIGIN = torch.zeros(3, dtype=torch.float64)
SURFACE, PARTIAL, SIDE = SupportType.SURFACE, SupportType.PARTIAL, SupportType.SIDE


def about_y(degrees: float) -> Tensor:
    """Rotation (3, 3) about +y."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return torch.tensor([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]], dtype=torch.float64)


def volume(pile: Pile) -> Tensor:
    return pile.boxes().volume()


def types(pile: Pile) -> dict[tuple[int, int], SupportType]:
    """Supports as {(supporter, supported): type}; the table is -1."""
    kind, n = contacts(pile).type, len(pile)
    return {
        ((i + 1) % (n + 1) - 1, j): SupportType(int(kind[i, j]))
        for i in range(n + 1)
        for j in range(n)
        if int(kind[i, j]) >= 0
    }


def test_each_layer_of_a_tower_carries_all_above() -> None:
    pile = tower()
    above = volume(pile).flip(0).cumsum(0).flip(0)
    expected = torch.zeros(4, 3, dtype=torch.float64)
    expected[3, 0], expected[0, 1], expected[1, 2] = (above / volume(pile)).tolist()
    assert torch.allclose(contacts(pile).share, expected, atol=CARRIED)
    assert types(pile) == {(-1, 0): SURFACE, (0, 1): SURFACE, (1, 2): SURFACE}


def test_two_pillars_share_a_bridge() -> None:
    pile = bridge()
    share = contacts(pile).share
    assert torch.allclose(share[:2, 2], torch.full((2,), 0.5, dtype=torch.float64), atol=CARRIED)
    assert share[3, 2] == 0
    assert (share[2] == 0).all()
    assert types(pile) == {(-1, 0): SURFACE, (-1, 1): SURFACE, (0, 2): SURFACE, (1, 2): SURFACE}


def test_blocks_side_by_side_carry_nothing_of_each_other() -> None:
    share = contacts(rested(put(CUBE, 0.0, 0.051), put(CUBE, 0.1001, 0.051))).share
    assert (share[:2] < CARRIED).all()
    assert torch.allclose(share[2], torch.ones(2, dtype=torch.float64), atol=CARRIED)


def test_the_table_carries_the_weight_of_all() -> None:
    pile = seesaw()
    carried = float((contacts(pile).share[-1] * volume(pile)).sum() / volume(pile).sum())
    assert carried == pytest.approx(1.0, abs=CARRIED)


def test_a_leaning_plank_has_its_end_on_the_table_and_its_face_on_an_edge() -> None:
    # The end is a line. The edge pushes at right angles to the plank, 30 degrees from the vertical.
    assert types(leaning_plank()) == {(-1, 0): SURFACE, (-1, 1): PARTIAL, (0, 1): SIDE}


@pytest.mark.parametrize("degrees", [5.0, 17.0, 45.0])
def test_a_line_of_contact_is_no_surface_whichever_way_it_runs(degrees: float) -> None:
    # Eight centimetres long, it spans over 5 mm along any direction but the one across it.
    assert types(leaning_plank().moved(about_y(degrees), ORIGIN))[-1, 1] == PARTIAL
    base = put(box((0.1, 0.05, 0.1)), 0.0, 0.051)
    lying = rested(base, put(cylinder(0.035, 0.05), 0.0, 0.137, lean_deg=90.0))
    assert types(lying.moved(about_y(degrees), ORIGIN)) == {(-1, 0): SURFACE, (0, 1): PARTIAL}


@pytest.mark.parametrize(("half_width", "kind"), [(0.002, PARTIAL), (0.003, SURFACE)])
def test_a_surface_is_broader_than_five_millimetres(half_width: float, kind: SupportType) -> None:
    slat = put(box((half_width, 0.005, 0.05)), 0.0, 0.0055)
    assert types(rested(slat).moved(about_y(33.0), ORIGIN)) == {(-1, 0): kind}


def test_a_can_on_a_box_has_a_surface_and_a_ball_or_a_lying_can_has_none() -> None:
    base = put(box((0.1, 0.05, 0.1)), 0.0, 0.051)
    assert types(rested(base, put(cylinder(0.035, 0.05), 0.0, 0.152)))[0, 1] == SURFACE
    assert types(rested(base, put(sphere(0.04), 0.0, 0.142)))[0, 1] == PARTIAL
    assert types(rested(base, put(cylinder(0.035, 0.05), 0.0, 0.137, lean_deg=90.0)))[0, 1] == PARTIAL


def test_a_ball_in_a_bowl_is_held_by_it_alone() -> None:
    held = types(rested(put(bowl(0.08, 0.035), 0.0, 0.036), put(sphere(0.03), 0.0, 0.06)))
    assert set(held) == {(-1, 0), (0, 1)}


def test_the_same_pile_is_heard_to_the_same_bits() -> None:
    pile = leaning_plank()
    first, second = contacts(pile), contacts(pile)
    assert torch.equal(first.share, second.share)
    assert torch.equal(first.type, second.type)


def test_a_type_is_given_wherever_enough_is_carried_and_nowhere_else() -> None:
    held = contacts(leaning_plank())
    assert torch.equal(held.type >= 0, held.share >= CARRIES)
