"""The preset `blocks` before physics takes over."""

from __future__ import annotations

import pytest
import torch

from blockstab.boxes.separation import separation
from blockstab.simulation.layouts.blocks import arrange_blocks
from blockstab.simulation.physics.contacts import contacts
from blockstab.simulation.physics.settling import falls, settle


def test_piles_have_3_to_14_blocks_none_of_which_overlap(generator: torch.Generator) -> None:
    counts = []
    for _ in range(30):
        pile = arrange_blocks(generator)
        counts.append(len(pile))
        first, second = torch.combinations(torch.arange(len(pile)), 2).unbind(dim=1)
        assert (separation(pile.boxes(), first, second).gap > -1e-9).all()
        corners = pile.boxes().corners()
        assert corners[..., 1].min() > 0
        assert corners[..., [0, 2]].norm(dim=-1).max() < 0.45
    assert min(counts) >= 3
    assert max(counts) <= 14
    assert len(set(counts)) >= 6
    assert 6 <= sum(counts) / len(counts) <= 9


def test_equal_seeds_make_equal_piles() -> None:
    first, second = (arrange_blocks(torch.Generator().manual_seed(5)) for _ in range(2))
    assert torch.equal(first.center, second.center)
    assert torch.equal(first.rotation, second.rotation)


def test_most_piles_come_to_rest_a_third_stacked_and_with_something_that_holds_another() -> None:
    pytest.importorskip("mujoco", reason="the extra `sim` is not installed")
    good = 0
    for seed in range(8):
        resting = settle(arrange_blocks(torch.Generator().manual_seed(seed)))
        if resting is not None:
            stacked = (contacts(resting).share[:-1] >= 0.05).any(dim=0)
            good += bool(3 * stacked.sum() >= len(resting)) and bool(falls(resting).any())
    assert good >= 6
