"""What every sensor must keep to."""

from __future__ import annotations

import math

import pytest
import torch

from blockstab.simulation.sensors import SENSORS, Sensor
from tests.simulation.sensors.walls import SHAPE, panel, seen, wall

RIM = 5  # pixels around an edge that may have the depth of either side, or none

everyone = pytest.mark.parametrize("sensor", SENSORS.values(), ids=SENSORS.keys())


@everyone
def test_the_picture_is_640_by_480_pixels_and_the_camera_looks_at_its_middle(sensor: Sensor) -> None:
    assert (sensor.width_px, sensor.height_px) == (640, 480)
    assert (sensor.camera.cx, sensor.camera.cy) == (319.5, 239.5)


@everyone
def test_the_same_generator_gives_the_same_bytes(sensor: Sensor) -> None:
    one, two = (seen(sensor, panel(0.8, 1.2), torch.Generator().manual_seed(3)) for _ in range(2))
    assert torch.equal(one, two)


@everyone
def test_a_sensor_draws_from_its_generator_alone_and_as_often_whatever_it_sees(sensor: Sensor) -> None:
    before = torch.get_rng_state()
    after = []
    for depth in (panel(0.8, 1.2), torch.zeros(SHAPE, dtype=torch.float64)):
        generator = torch.Generator().manual_seed(3)
        seen(sensor, depth, generator)
        after.append(generator.get_state())
    assert torch.equal(torch.get_rng_state(), before)
    assert torch.equal(*after)


@everyone
def test_depth_is_whole_millimetres_that_16_bits_hold(sensor: Sensor, generator: torch.Generator) -> None:
    distances = torch.logspace(-9, 6, SHAPE[1], dtype=torch.float64).expand(SHAPE)
    for tilt_deg in (0.0, 70.0, 90.0):
        millimetres = 1000 * seen(sensor, distances, generator, tilt_deg)
        assert millimetres.dtype == torch.float64
        assert torch.allclose(millimetres, millimetres.round(), rtol=0, atol=1e-6)
        assert millimetres.min() >= 0
        assert millimetres.max() < 65535.5


@everyone
def test_what_is_given_is_not_changed(sensor: Sensor, generator: torch.Generator) -> None:
    depth = panel(0.8, 1.2)
    seen(sensor, depth, generator)
    assert torch.equal(depth, panel(0.8, 1.2))


@everyone
def test_a_wall_is_measured_everywhere_and_without_bias(sensor: Sensor, generator: torch.Generator) -> None:
    measured = seen(sensor, wall(1.0), generator)
    assert (measured > 0).all()
    assert abs(float((measured - wall(1.0)).mean())) < 0.0003


@everyone
@pytest.mark.parametrize("behind", [0.0, 90.0])
def test_a_hole_stays_a_hole(sensor: Sensor, behind: float, generator: torch.Generator) -> None:
    measured = seen(sensor, panel(behind, 1.0), generator)
    assert not measured[80 + RIM : 160 - RIM, 100 + RIM : 220 - RIM].any()
    assert measured[: 80 - RIM].all()
    assert measured[:, : 100 - RIM].all()
    assert measured[:, 220 + RIM :].all()


@everyone
def test_a_near_thing_casts_its_shadow_to_the_left_and_as_wide_as_the_second_eye_is_away(
    sensor: Sensor, generator: torch.Generator
) -> None:
    near, far = 0.8, 1.6
    # A point at depth z and column u has the column u - moved / z in the second eye.
    moved = sensor.camera.fx * sensor.baseline
    columns = torch.arange(SHAPE[1]) - moved / far + moved / near
    hidden = (columns >= 100) & (columns < 220) & (panel(near, far) == far)
    hidden[:80] = hidden[160:] = False
    flat = torch.zeros(SHAPE, dtype=torch.float64)
    measured = sensor.measure(panel(near, far), flat, ~hidden, torch.ones_like(flat), generator)[
        80 + RIM : 160 - RIM
    ]
    width = math.ceil(moved / near - moved / far)
    assert not measured[:, 100 - width + RIM : 100 - RIM].any()
    assert measured[:, : 100 - width - RIM].all()
    assert measured[:, 220 + RIM :].all()
    assert int(hidden[100].sum()) == int(hidden[100, :100].sum()) in (width - 1, width)


measuring = pytest.mark.parametrize(
    "sensor", [SENSORS["kinect"], SENSORS["realsense"]], ids=["kinect", "realsense"]
)


@measuring
def test_the_less_light_comes_back_the_more_is_lost_and_the_worse_the_rest(
    sensor: Sensor, generator: torch.Generator
) -> None:
    lost, error = [], []
    for echo in (1.0, 0.6, 0.3, 0.1):
        measured = seen(sensor, wall(1.0), generator, echo=echo)
        found = measured > 0
        lost.append(1.0 - float(found.double().mean()))
        error.append(float((measured - wall(1.0))[found].std()))
    assert lost[:2] == [0.0, 0.0]
    assert 0.25 < lost[2] < 0.55 < lost[3] < 0.95
    assert error == sorted(error)
    assert error[3] > 4 * error[0]


@measuring
def test_what_is_lost_of_a_dark_surface_lies_in_patches(sensor: Sensor, generator: torch.Generator) -> None:
    missing = (seen(sensor, wall(1.0), generator, echo=0.25) == 0).double()
    alike = float((missing[:, 3:] == missing[:, :-3]).double().mean())
    share = float(missing.mean())
    assert alike > share**2 + (1 - share) ** 2 + 0.15
