"""What a cheap camera makes of known light."""

from __future__ import annotations

import pytest
import torch

from blockstab.simulation.appearance.lens import develop

SIZE = (120, 160, 3)


def developed(light: torch.Tensor, variety: float = 1.0, seed: int = 0) -> torch.Tensor:
    return develop(light, variety, torch.Generator().manual_seed(seed)).double()


@pytest.mark.parametrize("brightness", [0.01, 1.0, 50.0])
def test_the_exposure_follows_the_light(brightness: float) -> None:
    for seed in range(4):
        assert 70 < float(developed(torch.full(SIZE, brightness), seed=seed).median()) < 160


def test_corners_are_darker_than_the_middle() -> None:
    picture = developed(torch.ones(SIZE), 0.0)
    assert picture[:20, :20].mean() < picture[50:70, 70:90].mean() - 8


def test_edges_are_blurred_and_what_gets_no_light_is_dark() -> None:
    light = torch.ones(SIZE)
    light[:, 80:] = 0.0
    row = developed(light, 0.0)[40:80].mean(dim=(0, 2))
    assert row[120:].mean() < 30
    assert row[40:60].mean() > 90
    assert (row[78:82].diff().abs() < 0.8 * (row[60] - row[100])).all()


def test_noise_differs_from_generator_to_generator_and_no_more_than_that() -> None:
    light = torch.full(SIZE, 0.5)
    first, again, other = (develop(light, 1.0, torch.Generator().manual_seed(s)) for s in (1, 1, 2))
    assert torch.equal(first, again)
    assert not torch.equal(first, other)
    assert 0.5 < developed(light)[40:60, 60:80].std(dim=(0, 1)).mean() < 12


def test_brighter_light_makes_brighter_pixels_without_a_limit() -> None:
    light = torch.ones(SIZE)
    light[:40], light[80:] = 3.0, 9.0
    dark, middle, bright = (
        developed(light, 0.0)[rows, 70:90].mean() for rows in (slice(50, 70), slice(5, 30), slice(95, 110))
    )
    assert dark < middle - 5
    assert middle < bright - 5


def test_cameras_differ_in_brightness_and_contrast() -> None:
    light = torch.ones(SIZE)
    light[:60] = 0.25
    found = [developed(light, seed=seed) for seed in range(12)]
    levels = [float(picture.median()) for picture in found]
    steps = [float(picture[70:110].mean() - picture[10:50].mean()) for picture in found]
    assert max(levels) - min(levels) > 25
    assert max(steps) > 1.2 * min(steps)
