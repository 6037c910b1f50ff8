"""The active stereo sensor errs as published."""

from __future__ import annotations

import pytest
import torch

from blockstab.simulation.sensors.realsense import RealSense
from tests.simulation.sensors.walls import SHAPE, panel, seen, wall

REACH = 0.05 * 615.0  # pixels of disparity of a surface a metre away
SENSOR = RealSense()


def disparity_error(distance: float, generator: torch.Generator) -> torch.Tensor:
    true = wall(distance)
    return REACH / seen(SENSOR, true, generator) - REACH / true


# z ** 2 * 0.08 px / (615 px * 0.05 m), by hand.
@pytest.mark.parametrize(("distance", "expected"), [(1.0, 0.0026), (2.0, 0.0104), (3.0, 0.0234)])
def test_noise_has_the_published_size(distance: float, expected: float, generator: torch.Generator) -> None:
    error = seen(SENSOR, wall(distance), generator) - wall(distance)
    assert float(error.std()) == pytest.approx(expected, rel=0.1)
    assert abs(float(error.mean())) < 0.1 * expected


def test_depth_comes_in_steps_of_disparity(generator: torch.Generator) -> None:
    values = seen(SENSOR, wall(3.0), generator).unique()
    steps = 32 * REACH / values
    assert float((steps - steps.round()).abs().max()) < 0.1
    assert int((steps.diff().round() == -1).sum()) > 50


@pytest.mark.parametrize(("apart", "expected"), [(1, 6 / 7), (3, 4 / 7), (7, 0.0), (12, 0.0)])
def test_neighbours_err_alike_as_far_as_their_windows_overlap(
    apart: int, expected: float, generator: torch.Generator
) -> None:
    error = disparity_error(2.0, generator)
    for beside in (error, error.T):
        pair = torch.stack([beside[:, apart:].flatten(), beside[:, :-apart].flatten()])
        assert float(pair.corrcoef()[0, 1]) == pytest.approx(expected, abs=0.06)


def test_a_near_thing_grows_over_its_background_by_three_pixels_at_most(generator: torch.Generator) -> None:
    measured = seen(SENSOR, panel(0.8, 1.2), generator)
    near = (measured > 0.75) & (measured < 0.82)
    above = near[:80, 110:210].double().mean(dim=1).flip(0)
    assert above[0] > above[1] > above[2] > 0.01
    assert above[0] > 0.4
    assert not above[4:].any()


def test_edges_tear_and_all_else_stays_whole(generator: torch.Generator) -> None:
    true = panel(0.8, 1.2)
    measured = seen(SENSOR, true, generator)
    flying = (measured > 0.85) & (measured < 1.12)
    around = torch.zeros(SHAPE, dtype=torch.bool)
    around[76:164, 96:224] = True
    around[81:159, 101:219] = False  # a pixel inside the panel, four outside
    wrong = (measured - true).abs() > 0.05
    assert wrong.any()
    assert not wrong[~around].any()
    assert 0.02 < float(flying[around].double().mean()) < 0.2
    assert 0.05 < float((measured[around] == 0).double().mean()) < 0.3


@pytest.mark.parametrize(("tilt_deg", "share"), [(70.0, 1.0), (89.0, 0.0)])
def test_a_surface_seen_from_the_side_has_no_depth(
    tilt_deg: float, share: float, generator: torch.Generator
) -> None:
    assert float((seen(SENSOR, wall(1.0), generator, tilt_deg) > 0).double().mean()) == pytest.approx(
        share, abs=0.001
    )


@pytest.mark.parametrize("distance", [0.0, 0.26, 7.0])
def test_nothing_is_measured_out_of_range(distance: float, generator: torch.Generator) -> None:
    assert not seen(SENSOR, torch.full(SHAPE, distance, dtype=torch.float64), generator).any()


@pytest.mark.parametrize("distance", [0.28, 5.9])
def test_noise_does_not_leave_the_range(distance: float, generator: torch.Generator) -> None:
    measured = seen(SENSOR, torch.full(SHAPE, distance, dtype=torch.float64), generator)
    kept = measured[measured > 0]
    assert 0 < len(kept) < measured.numel()
    assert 0.28 <= float(kept.min()) <= float(kept.max()) <= 6.0


def test_nothing_flies_where_nothing_is_behind(generator: torch.Generator) -> None:
    measured = seen(SENSOR, panel(1.0, 0.0), generator)
    assert 1000 < int(((measured > 0.98) & (measured < 1.02)).sum()) == int((measured > 0).sum())


def test_a_steep_table_and_the_foot_of_a_wall_are_no_edges(generator: torch.Generator) -> None:
    """A table of slant 65 degrees, which meets a wall 0.6 m away in the middle of the picture."""
    v, u = torch.meshgrid(torch.arange(180, 300).double(), torch.arange(160, 480).double(), indexing="ij")
    camera = SENSOR.camera
    rays = torch.stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, torch.ones_like(u)], dim=-1)
    tilt = torch.deg2rad(torch.tensor(65.0, dtype=torch.float64))
    facing = rays @ torch.stack([torch.zeros_like(tilt), tilt.sin(), tilt.cos()])
    true = (0.6 * tilt.cos() / facing).clamp(max=0.6)
    incidence = (torch.where(true < 0.6, facing, 1.0) / rays.norm(dim=-1)).arccos()
    measured = SENSOR.measure(
        true, incidence, torch.ones_like(true, dtype=torch.bool), torch.ones_like(true), generator
    )
    error = REACH / measured - REACH / true
    assert (measured > 0).all()
    assert float(error.std()) == pytest.approx(0.08, rel=0.1)
    for rows in (slice(None), slice(57, 60)):  # all, and the foot of the wall
        assert abs(float(error[rows].mean())) < 0.02
