"""The preset `grocery`, before and after physics."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise

import pytest
import torch

from blockstab.boxes.separation import separation
from blockstab.simulation.layouts.grocery import arrange_grocery
from blockstab.simulation.physics.contacts import contacts
from blockstab.simulation.physics.settling import settle
from blockstab.simulation.physics.solids import Pile
from tests.tolerance import EXACT


@pytest.fixture(scope="module")
def piles() -> list[Pile]:
    return [arrange_grocery(torch.Generator().manual_seed(seed)) for seed in range(20)]


def alike(pile: Pile) -> list[list[int]]:
    """The lowest layer of each product that comes more than once, from left to right."""
    groups: dict[int, list[int]] = {}
    for i, solid in enumerate(pile.solids):
        if solid.product is not None:
            groups.setdefault(solid.product, []).append(i)
    bottoms = pile.boxes().corners()[..., 1].amin(dim=1)
    lowest = [[i for i in group if bottoms[i] < 0.0011] for group in groups.values()]
    return [sorted(g, key=lambda i: float(pile.center[i, 0])) for g in lowest if len(g) > 1]


def test_piles_have_6_to_18_products_none_of_which_overlap(piles: list[Pile]) -> None:
    for pile in piles:
        assert 6 <= len(pile) <= 18
        first, second = torch.combinations(torch.arange(len(pile)), 2).unbind(dim=1)
        assert separation(pile.boxes(), first, second).gap.min() > -EXACT
        assert pile.boxes().corners()[..., 1].min() > 0
        assert pile.boxes().corners()[..., 0].abs().max() < 0.45


def test_neighbours_of_one_product_touch_within_a_millimetre_and_their_fronts_are_flush(
    piles: list[Pile],
) -> None:
    pairs = [(p, a, b) for p in piles for group in alike(p) for a, b in pairwise(group)]
    assert len(pairs) > 40
    for pile, a, b in pairs:
        half = pile.solids[a].half_extent
        gap = pile.center[b, 0] - pile.center[a, 0] - 2 * half[0]
        assert -EXACT <= float(gap) <= 0.001 + EXACT
        assert torch.equal(half, pile.solids[b].half_extent)
        assert float(pile.center[a, 2] - pile.center[b, 2]) == pytest.approx(0.0, abs=EXACT)


def test_different_products_of_a_row_stand_flush_too(piles: list[Pile]) -> None:
    for pile in piles:
        corners = pile.boxes().corners()
        fronts = corners[..., 2].amax(dim=1)
        front_row = fronts > fronts.max() - EXACT
        left, right = corners[front_row][..., 0].amin(dim=1), corners[front_row][..., 0].amax(dim=1)
        # What covers the row leaves no slit wider than a millimetre or, under a carton laid on top, two.
        covered = left.sort().values[1:]
        reach = right[left.argsort()].cummax(dim=0).values[:-1]
        assert int(front_row.sum()) >= 2
        assert (covered - reach).max() <= 0.002 + EXACT


def test_products_come_several_times_in_most_scenes(piles: list[Pile]) -> None:
    repeats = [max(Counter(s.product for s in p.solids if s.product is not None).values()) for p in piles]
    assert min(repeats) >= 2
    assert sum(r >= 3 for r in repeats) >= 15


def test_most_piles_come_to_rest_where_they_were_put_and_a_fifth_of_all_stand_on_another(
    piles: list[Pile],
) -> None:
    pytest.importorskip("mujoco", reason="the extra `sim` is not installed")
    resting = [(pile, settle(pile)) for pile in piles[:6]]
    settled = [(pile, after) for pile, after in resting if after is not None]
    assert len(settled) >= 5
    moved = torch.cat([(after.center - pile.center).norm(dim=1) for pile, after in settled])
    assert moved.max() < 0.015
    stacked = [(contacts(after).share[:-1] >= 0.05).any(dim=0) for _, after in settled]
    assert torch.cat(stacked).double().mean() >= 0.2


def test_equal_seeds_make_equal_piles(piles: list[Pile]) -> None:
    again = arrange_grocery(torch.Generator().manual_seed(5))
    assert torch.equal(again.center, piles[5].center)
    assert [s.product for s in again.solids] == [s.product for s in piles[5].solids]
