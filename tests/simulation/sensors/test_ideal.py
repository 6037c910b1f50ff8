"""The ideal sensor errs by its last digit alone."""

from __future__ import annotations

import torch

from blockstab.simulation.sensors.ideal import Ideal
from tests.simulation.sensors.walls import SHAPE, panel, seen


def test_the_error_is_half_a_millimetre_at_most(generator: torch.Generator) -> None:
    true = 0.05 + 20.0 * torch.rand(SHAPE, generator=generator, dtype=torch.float64)
    error = (seen(Ideal(), true, generator) - true).abs()
    assert 0.00049 < float(error.max()) <= 0.0005 + 1e-9


def test_edges_and_steep_surfaces_are_measured_and_nothing_is_in_shadow(generator: torch.Generator) -> None:
    true = panel(0.8, 1.2)
    dark = torch.zeros(SHAPE, dtype=torch.bool)
    assert torch.equal(
        Ideal().measure(true, torch.full_like(true, 1.57), dark, torch.full_like(true, 0.1), generator), true
    )


def test_what_16_bits_do_not_hold_is_missing(generator: torch.Generator) -> None:
    assert seen(Ideal(), torch.tensor([[65.535, 65.536]]).double(), generator).tolist() == [[65.535, 0.0]]
