"""Textures that fill space."""

from __future__ import annotations

import torch

from blockstab.simulation.appearance.noise import SolidNoise, rings


def test_noise_is_smooth_within_a_cell_and_unlike_a_few_cells_on(generator: torch.Generator) -> None:
    noise = SolidNoise(generator)
    points = 200.0 * torch.rand(5000, 3, generator=generator) - 100.0
    here, near, far = noise(points), noise(points + 0.02), noise(points + 5.3)
    assert float(here.abs().max()) <= 1.0
    assert float(here.std()) > 0.2
    assert float((near - here).abs().max()) < 0.2
    assert abs(float(torch.corrcoef(torch.stack([here, far]))[0, 1])) < 0.06


def test_rings_come_again_after_their_spacing_away_from_the_pith() -> None:
    spacing = torch.full((3,), 0.01)
    pith = torch.tensor([0.0, -0.073, 0.119])
    away = torch.tensor([0.0, 0.6, 0.8])
    points = torch.stack([pith + r * away for r in (0.204, 0.214, 0.209)])
    values = rings(points, spacing, torch.zeros(3))
    assert torch.allclose(values[0], values[1], atol=1e-3)
    assert torch.allclose(values[0], -values[2], atol=1e-3)
    along = points + torch.tensor([0.3, 0.0, 0.0])
    assert torch.allclose(rings(along, spacing, torch.zeros(3)), values, atol=1e-5)
