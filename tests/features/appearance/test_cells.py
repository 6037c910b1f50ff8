"""Cells of pixels, against what numpy counts of their pixels one by one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from torch import Tensor

from blockstab.features.appearance.cells import MOMENT, Cells, measured_cells
from blockstab.features.appearance.views import Views, view
from tests.features.observed import HEIGHT, WIDTH, cells, cluttered
from tests.tolerance import EXACT

COUNT = 40


@pytest.fixture
def views(generator: torch.Generator) -> Views:
    return view(cluttered(cells(10, generator), generator))


@pytest.fixture
def cell(views: Views, generator: torch.Generator) -> Tensor:
    """Of every pixel; some have none, cell 7 has few, and cell 9 none at all."""
    drawn = torch.randint(-1, COUNT, (HEIGHT * WIDTH,), generator=generator)
    drawn[drawn == 9] = 8
    drawn[(drawn == 7).nonzero()[3:]] = -1
    return drawn


def members(cell: Tensor, which: int) -> np.ndarray:
    return (cell == which).nonzero()[:, 0].numpy()


def test_sums_extremes_and_counts_are_those_of_the_pixels(views, cell):
    found = measured_cells(views, cell, COUNT)
    colors, points = views.colors.numpy(), views.points.numpy()
    for k in range(COUNT):
        own = members(cell, k)
        assert int(found.pixels[k]) == len(own)
        expected = np.concatenate([colors[own].sum(axis=0), (colors[own] ** 2).sum(axis=0)])
        np.testing.assert_allclose(found.colors[k], expected, atol=EXACT)
        homogeneous = np.concatenate([points[own], np.ones((len(own), 1))], axis=1)
        moments = found.moments[k][torch.tensor(MOMENT)]
        np.testing.assert_allclose(moments, homogeneous.T @ homogeneous, atol=EXACT)
        known = own[views.has_normal.numpy()[own]]
        np.testing.assert_allclose(found.normals[k], views.normals.numpy()[known].sum(axis=0), atol=EXACT)
        assert (
            found.planes[k].tolist() == np.bincount(views.plane[own], minlength=len(found.planes[k])).tolist()
        )
        kinds, steps = np.unravel_index(views.facing[known, 0].numpy(), (5, 16))
        assert found.facing[k, 0, :5].tolist() == np.bincount(kinds, minlength=5).tolist()
        assert found.facing[k, 0, 5:9].tolist() == np.bincount(steps // 4, minlength=4).tolist()
        assert found.facing[k, 0, 9:].tolist() == np.bincount(steps % 4, minlength=4).tolist()
        if len(own):
            spread = np.concatenate([points[own], views.depth.numpy()[own, None]], axis=1)
            assert found.least[k].tolist() == spread.min(axis=0).tolist()
            assert found.greatest[k].tolist() == spread.max(axis=0).tolist()


def drawn(found: Cells, views: Views, cell: Tensor, unions: list[list[int]], most: int) -> None:
    """Compare the first pixels of unions with those found by going through all pixels in their order."""
    entries = torch.tensor([k for union in unions for k in union])
    owner = torch.tensor([i for i, union in enumerate(unions) for _ in union])
    pixel, count = found.first(entries, owner, len(unions), most)
    for row, number, union in zip(pixel.tolist(), count.tolist(), unions, strict=True):
        inside = torch.isin(cell, torch.tensor(union))
        expected = views.order[inside[views.order]][:most].tolist()
        assert number == len(expected)
        assert row == [expected[k % number] for k in range(most)]


@pytest.mark.parametrize("most", [1, 5, 100, 5000])
def test_the_first_pixels_of_a_union_come_first_in_the_order_of_all(views, cell, most):
    unions = [[3], [5, 0, 11], [7], [7, 20], list(range(COUNT)), [1, 39, 9, 2]]
    drawn(measured_cells(views, cell, COUNT), views, cell, unions, most)


@pytest.mark.parametrize("most", [5, 100])
def test_pixels_that_happen_to_come_late_are_found_all_the_same(views, cell, most):
    last = torch.cat([(cell != 3).nonzero()[:, 0], (cell == 3).nonzero()[:, 0]])
    late = replace(views, order=last)
    drawn(measured_cells(late, cell, COUNT), late, cell, [[3], [3, 7], [4, 5, 6]], most)


def test_a_cell_says_whether_its_pixels_have_depth(views):
    holes = torch.arange(HEIGHT * WIDTH) % 3 == 0
    found = measured_cells(replace(views, measured=~holes), holes.to(torch.int64), 2)
    assert found.measured.tolist() == [True, False]
