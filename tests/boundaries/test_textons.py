"""The filters behind textons, and which texton a place has."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from scipy.signal import hilbert

from blockstab.boundaries.textons import FLAT, filter_bank, textons
from tests.tolerance import HISTOGRAM, LEARNED


def wave(height: int, width: int, angle_deg: float, period_px: float = 9.0) -> np.ndarray:
    """A grey wave, (3, H, W), whose crests are at this angle, counter-clockwise from the x axis."""
    row, column = np.mgrid[:height, :width]
    across = column * np.sin(np.deg2rad(angle_deg)) + row * np.cos(np.deg2rad(angle_deg))
    grey = 0.5 + 0.2 * np.sin(2 * np.pi * across / period_px)
    return np.broadcast_to(grey.astype(np.float32), (3, height, width))


def test_filters_answer_nothing_to_a_plain_image_and_at_most_one_to_any() -> None:
    bank = filter_bank()
    assert bank.sum(dim=(-2, -1)).numpy() == pytest.approx(0.0, abs=LEARNED)
    assert bank.abs().sum(dim=(-2, -1)).numpy() == pytest.approx(1.0, abs=LEARNED)


def test_even_filters_are_even_and_odd_ones_odd() -> None:
    even, odd = filter_bank().unbind(dim=2)
    assert even.flip(-2, -1).numpy() == pytest.approx(even.numpy(), abs=LEARNED)
    assert odd.flip(-2, -1).numpy() == pytest.approx(-odd.numpy(), abs=LEARNED)


def test_three_orientations_further_on_a_filter_is_turned_by_a_right_angle() -> None:
    bank = filter_bank()
    turned = torch.rot90(bank[:, :3], 1, (-2, -1))
    assert turned.numpy() == pytest.approx(bank[:, 3:].numpy(), abs=LEARNED)


@pytest.mark.parametrize("scale", [0, 1])
def test_odd_filters_are_the_hilbert_transforms_of_even_ones(scale: int) -> None:
    sigma = (1.0, 2.0**0.5)[scale]
    fine = np.arange(-64.0, 64.0, 1 / 16)
    wanted = hilbert((fine**2 / sigma**2 - 1) * np.exp(-(fine**2) / (2 * sigma**2)))
    column = filter_bank()[scale, 0, :, :, 7].double().numpy()
    even, odd = (np.interp(np.arange(-7.5, 8.0), fine, part) for part in (wanted.real, wanted.imag))
    for found, profile in zip(column, (even, odd), strict=True):
        assert abs(np.corrcoef(found, profile)[0, 1]) == pytest.approx(1.0, abs=HISTOGRAM)


@pytest.mark.parametrize("scale", [0, 1])
def test_filters_are_twice_as_long_as_wide(scale: int) -> None:
    row = filter_bank()[scale, 0, 1, 6].double().numpy()
    sigma = 2.0 * (1.0, 2.0**0.5)[scale]
    expected = np.exp(-(np.arange(-7.5, 8.0) ** 2) / (2 * sigma**2))
    assert row / row.sum() == pytest.approx(expected / expected.sum(), abs=LEARNED)


@pytest.mark.parametrize("size", [(1, 1), (10, 7), (29, 41)])
def test_there_is_one_texton_for_every_two_by_two_pixels(size: tuple[int, int]) -> None:
    found = textons(np.full((3, *size), 0.3, np.float32))
    assert found.shape == ((size[0] + 1) // 2, (size[1] + 1) // 2)
    assert (found == FLAT).all()


def test_faint_noise_is_flat(generator: torch.Generator) -> None:
    noise = torch.randn(1, 40, 40, generator=generator).expand(3, -1, -1).numpy()
    assert (textons(0.5 + 0.002 * noise) == FLAT).all()
    assert (textons(0.5 + 0.1 * noise) == FLAT).mean() < 0.05


def test_textons_tell_the_orientations_of_waves_apart() -> None:
    found = [set(textons(wave(60, 60, 30.0 * k)).flatten().tolist()) for k in range(6)]
    for k in range(6):
        assert 2 <= len(found[k]) <= 4  # crest, trough and the slopes between them
        assert not any(found[k] & found[j] for j in range(k))


def test_textons_do_not_change_with_the_light(generator: torch.Generator) -> None:
    rgb = torch.rand(3, 60, 60, generator=generator).numpy()
    dim = textons(np.float32(0.1) * rgb)
    strong = dim != FLAT
    assert strong.mean() > 0.5
    # Two answers may be equal up to the steps that they are rounded to.
    assert (textons(rgb) == dim)[strong].mean() > 0.99


def test_beyond_what_filters_see_textons_are_mirrored(generator: torch.Generator) -> None:
    rgb = torch.rand(3, 61, 48, generator=generator).numpy()
    found = textons(rgb)
    assert np.array_equal(found[:7], found[7:14][::-1])
    assert np.array_equal(found[:, -7:], found[:, -14:-7][:, ::-1])
    rgb[:, :6] = rgb[:, -6:] = 0.0  # the blur may bring anything here from beyond the rim
    assert np.array_equal(textons(rgb), found)
