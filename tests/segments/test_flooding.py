"""Basins of the boundary strength."""

from __future__ import annotations

import torch

from blockstab.segments.flooding import MOST_BASINS, basins


def test_basins_cover_the_mask_and_nothing_else(generator: torch.Generator) -> None:
    strength = torch.rand(60, 80, dtype=torch.float64, generator=generator)
    area = torch.rand(60, 80, generator=generator) > 0.2
    assert torch.equal(basins(strength, area) > 0, area)


def test_a_grainy_picture_has_a_bounded_number_of_basins(generator: torch.Generator) -> None:
    strength = torch.rand(480, 640, dtype=torch.float64, generator=generator)
    found = basins(strength, torch.ones(480, 640, dtype=torch.bool))
    assert MOST_BASINS / 4 < int(found.max()) <= MOST_BASINS


def test_a_picture_that_is_not_grainy_is_not_smoothed() -> None:
    strength = torch.zeros(40, 60, dtype=torch.float64)
    strength[:, 30] = 0.8  # a median filter would remove the line
    assert int(basins(strength, torch.ones(40, 60, dtype=torch.bool)).max()) == 2


def test_more_islands_than_basins_end_in_one_for_each() -> None:
    area = torch.zeros(260, 260, dtype=torch.bool)
    area[::2, ::2] = True
    found = basins(torch.zeros(260, 260, dtype=torch.float64), area)
    assert int(found.max()) == int(area.sum()) > MOST_BASINS
