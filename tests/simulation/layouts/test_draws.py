"""Draws stay in their ranges and reach all of them."""

from __future__ import annotations

import torch

from blockstab.simulation.layouts.draws import any_turn, chance, choice, twist, uniform, whole
from tests.tolerance import EXACT


def test_numbers_fill_their_ranges_and_stay_inside(generator: torch.Generator) -> None:
    numbers = [uniform(generator, 2.0, 3.0) for _ in range(200)]
    assert 2.0 <= min(numbers) < 2.05
    assert 2.95 < max(numbers) <= 3.0
    assert {whole(generator, 1, 3) for _ in range(50)} == {1, 2, 3}
    assert {choice(generator, "ab") for _ in range(50)} == {"a", "b"}
    turns = [twist(generator, 0.1) for _ in range(50)]
    assert -0.1 <= min(turns) < 0 < max(turns) <= 0.1


def test_a_chance_comes_as_often_as_it_says(generator: torch.Generator) -> None:
    assert 140 <= sum(chance(generator, 0.3) for _ in range(600)) <= 220


def test_any_turn_is_a_rotation_and_favours_no_direction(generator: torch.Generator) -> None:
    turns = torch.stack([any_turn(generator) for _ in range(600)])
    identity = torch.eye(3, dtype=torch.float64).expand_as(turns)
    assert torch.allclose(turns @ turns.transpose(1, 2), identity, atol=EXACT)
    assert torch.allclose(torch.linalg.det(turns), turns.new_ones(600), atol=EXACT)
    # Each entry is even on [-1, 1] (Archimedes): its mean is 0 and its mean square 1/3.
    assert turns.mean(dim=0).abs().max() < 0.1
    assert (turns.square().mean(dim=0) - 1 / 3).abs().max() < 0.06
