"""Blurred images, and the bins of their brightness and colour."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from scipy.ndimage import gaussian_filter
from skimage.color import xyz2lab
from skimage.color.colorconv import xyz_from_rgb

from blockstab.boundaries.colors import BINS, blurred, brightness_bins, color_bins, halved


@pytest.mark.parametrize("size", [(31, 20), (3, 2), (1, 1)])
def test_the_blur_is_gaussian(size: tuple[int, int], generator: torch.Generator) -> None:
    color = torch.randint(0, 256, (*size, 3), generator=generator).byte().numpy()
    expected = gaussian_filter(color / 255, (2, 2, 0), mode="reflect", truncate=3)
    # Each of the 26 weights is rounded to the next 2048th.
    assert blurred(color).transpose(1, 2, 0) == pytest.approx(expected, abs=26 / 2048 / 2)


@pytest.mark.parametrize("level", [0, 77, 255])
def test_the_blur_leaves_a_plain_image_as_it_is(level: int) -> None:
    plain = blurred(np.full((9, 14, 3), level, np.uint8))
    assert plain.dtype == np.float32
    assert (plain == np.float32(level / 255)).all()


def test_a_halved_image_has_the_means_of_two_by_two_pixels() -> None:
    image = np.array([[[0, 4, 1], [8, 4, 3], [2, 6, 5]]], np.float32)
    assert halved(image).tolist() == [[[4, 2], [4, 5]]]
    assert halved(image[:, :1, :1]).tolist() == [[[0]]]


def test_black_and_white_have_the_outermost_bins_and_no_color() -> None:
    rgb = np.broadcast_to(np.float32([0, 1]), (3, 1, 2))
    assert brightness_bins(rgb).tolist() == [[0, BINS - 1]]
    neutral = int(73 / 168 * BINS)
    assert [bins.tolist() for bins in color_bins(rgb)] == [[[neutral, neutral]]] * 2


def test_bins_are_those_of_lab_after_a_power_of_2_5(generator: torch.Generator) -> None:
    rgb = torch.rand(3, 40, 50, generator=generator).numpy()
    lab = xyz2lab(rgb.astype(np.float64).transpose(1, 2, 0) ** 2.5 @ xyz_from_rgb.T)
    share = ((lab - [0.0, -73.0, -73.0]) / [100.0, 168.0, 168.0]).transpose(2, 0, 1) * BINS
    bins = np.stack([brightness_bins(rgb), *color_bins(rgb)])
    # The two whites differ in the fourth digit, which decides only next to the limit of a bin.
    decided = np.abs(share - share.round()) > 0.02
    assert decided.mean() > 0.9
    assert np.array_equal(bins[decided], np.floor(share[decided].clip(0, BINS - 1)))
