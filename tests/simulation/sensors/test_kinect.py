"""The structured-light sensor errs as published."""

from __future__ import annotations

import pytest
import torch

from blockstab.simulation.sensors.kinect import Kinect, axial_noise
from tests.simulation.sensors.walls import SHAPE, panel, seen, wall

SPREAD = 0.06  # relative; correlated noise of 77,000 pixels
SENSOR = Kinect()


@pytest.mark.parametrize("distance", [0.7, 1.0, 1.5, 2.0, 3.0])
def test_noise_has_the_published_size_and_no_bias(distance: float, generator: torch.Generator) -> None:
    true = wall(distance)
    error = seen(SENSOR, true, generator) - true
    expected = float(axial_noise(true, torch.zeros_like(true)).mean())
    assert float(error.std()) == pytest.approx(expected, rel=SPREAD)
    assert abs(float(error.mean())) < 0.1 * expected


def test_noise_grows_with_distance_and_with_slant() -> None:
    depth = torch.tensor([0.8, 1.6, 1.6], dtype=torch.float64)
    near, far, slanted = axial_noise(depth, torch.deg2rad(torch.tensor([0.0, 0.0, 75.0])).double())
    assert near < far < slanted


def test_depth_comes_in_steps_of_disparity(generator: torch.Generator) -> None:
    values = seen(SENSOR, wall(2.0), generator).unique()
    steps = values.diff() / values[:-1] ** 2
    assert float(steps.median()) == pytest.approx(1 / (8 * 580 * 0.075), rel=0.05)


@pytest.mark.parametrize(("tilt_deg", "share"), [(70.0, 1.0), (89.0, 0.0)])
def test_a_surface_seen_from_the_side_has_no_depth(
    tilt_deg: float, share: float, generator: torch.Generator
) -> None:
    assert float((seen(SENSOR, wall(1.0), generator, tilt_deg) > 0).double().mean()) == pytest.approx(
        share, abs=0.01
    )


@pytest.mark.parametrize("distance", [0.0, 0.2, 8.0])
def test_nothing_is_measured_out_of_range(distance: float, generator: torch.Generator) -> None:
    assert (seen(SENSOR, torch.full(SHAPE, distance, dtype=torch.float64), generator) == 0).all()


def test_nothing_is_measured_in_the_projector_s_shadow(generator: torch.Generator) -> None:
    true = torch.ones(SHAPE, dtype=torch.float64)
    lit = torch.ones(SHAPE, dtype=torch.bool)
    lit[:, :100] = False
    measured = SENSOR.measure(true, torch.zeros_like(true), lit, torch.ones_like(true), generator)
    assert torch.equal(measured > 0, lit)


def test_edges_fray_by_a_pixel_and_nothing_else_does(generator: torch.Generator) -> None:
    true = panel(1.0, 1.5)
    measured = seen(SENSOR, true, generator)
    rows = slice(90, 150)
    near, lost = ((measured > 0.9) & (measured < 1.1))[rows], (measured == 0)[rows]
    assert 0.1 < float(near[:, 99].double().mean()) < 0.5
    assert 0.5 < float(near[:, 100].double().mean()) < 0.9
    assert not near[:, :99].any()
    assert near[:, 101:219][~lost[:, 101:219]].all()
    assert not lost[:, :95].any()
    assert not lost[:, 105:215].any()


def test_pixels_along_edges_are_lost_here_and_there(generator: torch.Generator) -> None:
    lost = seen(SENSOR, panel(1.0, 1.5), generator) == 0
    assert 0.01 < float(lost[90:150, 98:102].double().mean()) < 0.2


def test_a_far_table_seen_from_the_side_is_no_edge(generator: torch.Generator) -> None:
    away = torch.linspace(3.0, 1.2, SHAPE[0], dtype=torch.float64)[:, None]  # 2 cm and more in three pixels
    assert (seen(SENSOR, away.expand(SHAPE).contiguous(), generator, tilt_deg=70.0) > 0).all()
