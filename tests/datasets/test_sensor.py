"""The depth sensor errs as published."""

from __future__ import annotations

import math

import pytest
import torch

from blockstab.datasets.sensor import axial_noise, measure

SHAPE = (240, 320)
SPREAD = 0.06  # relative; correlated noise of 77,000 pixels


def wall(distance: float) -> torch.Tensor:
    """A wall turned just enough that its depth crosses many steps of disparity."""
    across = torch.linspace(-0.03, 0.03, SHAPE[1], dtype=torch.float64)
    return (distance + distance**2 * across).expand(SHAPE).contiguous()


def seen(depth: torch.Tensor, generator: torch.Generator, tilt_deg: float = 0.0) -> torch.Tensor:
    lit = torch.ones_like(depth, dtype=torch.bool)
    return measure(depth, torch.full_like(depth, math.radians(tilt_deg)), lit, generator)


@pytest.mark.parametrize("distance", [0.7, 1.0, 1.5, 2.0, 3.0])
def test_noise_has_the_published_size_and_no_bias(distance: float, generator: torch.Generator) -> None:
    true = wall(distance)
    error = seen(true, generator) - true
    expected = float(axial_noise(true, torch.zeros_like(true)).mean())
    assert float(error.std()) == pytest.approx(expected, rel=SPREAD)
    assert abs(float(error.mean())) < 0.1 * expected


def test_noise_grows_with_distance_and_with_slant() -> None:
    depth = torch.tensor([0.8, 1.6, 1.6], dtype=torch.float64)
    near, far, slanted = axial_noise(depth, torch.deg2rad(torch.tensor([0.0, 0.0, 75.0])).double())
    assert near < far < slanted


def test_depth_comes_in_steps_of_disparity(generator: torch.Generator) -> None:
    values = seen(wall(2.0), generator).unique()
    steps = values.diff() / values[:-1] ** 2
    assert float(steps.median()) == pytest.approx(1 / (8 * 580 * 0.075), rel=0.05)


def test_depth_is_whole_millimetres(generator: torch.Generator) -> None:
    millimetres = 1000 * seen(wall(1.0), generator)
    assert torch.allclose(millimetres, millimetres.round(), atol=1e-6)


@pytest.mark.parametrize(("tilt_deg", "share"), [(70.0, 1.0), (89.0, 0.0)])
def test_a_surface_seen_from_the_side_has_no_depth(
    tilt_deg: float, share: float, generator: torch.Generator
) -> None:
    assert float((seen(wall(1.0), generator, tilt_deg) > 0).double().mean()) == pytest.approx(share, abs=0.01)


@pytest.mark.parametrize("distance", [0.0, 0.2, 8.0])
def test_nothing_is_measured_out_of_range(distance: float, generator: torch.Generator) -> None:
    assert (seen(torch.full(SHAPE, distance, dtype=torch.float64), generator) == 0).all()


def test_nothing_is_measured_in_the_projector_s_shadow(generator: torch.Generator) -> None:
    true = torch.ones(SHAPE, dtype=torch.float64)
    lit = torch.ones(SHAPE, dtype=torch.bool)
    lit[:, :100] = False
    measured = measure(true, torch.zeros_like(true), lit, generator)
    assert torch.equal(measured > 0, lit)


def test_edges_fray_by_a_pixel_or_two_and_nothing_else_does(generator: torch.Generator) -> None:
    true = torch.ones(SHAPE, dtype=torch.float64)
    true[:, 160:] = 1.5
    wrong = (seen(true, generator) - true).abs() > 0.1
    assert 0.1 < float(wrong[:, 159:161].double().mean()) < 0.5
    assert not wrong[:, :156].any()
    assert not wrong[:, 164:].any()
