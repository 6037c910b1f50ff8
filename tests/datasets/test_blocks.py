"""The preset `blocks` before physics takes over."""

from __future__ import annotations

import torch

from blockstab.boxes.separation import separation
from blockstab.datasets.blocks import arrange_blocks


def test_piles_have_at_most_ten_blocks_none_of_which_overlap(generator: torch.Generator) -> None:
    counts = set()
    for _ in range(20):
        pile = arrange_blocks(generator)
        counts.add(len(pile))
        first, second = torch.combinations(torch.arange(len(pile)), 2).unbind(dim=1)
        assert (separation(pile, first, second).gap > 0).all()
        assert pile.corners()[..., 1].min() > 0
    assert min(counts) >= 3
    assert max(counts) <= 10
    assert len(counts) >= 4


def test_equal_seeds_make_equal_piles() -> None:
    first, second = (arrange_blocks(torch.Generator().manual_seed(5)) for _ in range(2))
    assert torch.equal(first.center, second.center)
    assert torch.equal(first.rotation, second.rotation)
