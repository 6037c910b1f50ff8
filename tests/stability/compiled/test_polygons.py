"""Polygons one at a time in machine code, against the same in batches."""

from __future__ import annotations

import math

import pytest
import torch
from torch import Tensor

from blockstab.geometry import convex_hulls as convex
from blockstab.stability.balance import margins
from blockstab.stability.compiled.measures import area, centroid, margin
from blockstab.stability.compiled.polygons import clip, hull
from tests.tolerance import EXACT

SETS = 400


def points(kind: str, size: int, generator: torch.Generator) -> Tensor:
    """Sets of points, (SETS, size, 2): many of them repeated, in line, or nearly so."""
    if kind == "scattered":
        return torch.rand(SETS, size, 2, dtype=torch.float64, generator=generator)
    on_grid = 0.1 * torch.randint(0, 4, (SETS, size, 2), generator=generator).double()
    if kind == "on a grid":
        return on_grid
    if kind == "on a turned grid":
        c, s = math.cos(0.7), math.sin(0.7)
        return on_grid @ torch.tensor([[c, s], [-s, c]], dtype=torch.float64)
    return on_grid + 1e-16 * torch.randint(-2, 3, on_grid.shape, generator=generator)


@pytest.fixture(params=["scattered", "on a grid", "on a turned grid", "nearly on a grid"])
def kind(request):
    return request.param


def unpadded(polygons: convex.Polygons) -> list:
    return [polygons.vertices[i, : int(polygons.count[i])].numpy() for i in range(len(polygons))]


@pytest.mark.parametrize("size", [1, 2, 3, 8, 24])
def test_a_hull_is_that_of_the_batch_to_the_bit(kind, size, generator):
    sets = points(kind, size, generator)
    for one, expected in zip(sets, unpadded(convex.hull(sets)), strict=True):
        assert hull(one.numpy()).tolist() == expected.tolist()


def test_a_clip_is_that_of_the_batch(kind, generator):
    first, second = (convex.hull(points(kind, 8, generator)) for _ in range(2))
    solid = (first.count > 2) & (second.count > 2)
    first, second = first[solid], second[solid]
    expected = unpadded(convex.clip(first, second))
    for one, other, shared in zip(unpadded(first), unpadded(second), expected, strict=True):
        found = clip(one, other)
        assert len(found) == len(shared)
        assert found.shape == shared.shape
        assert not len(found) or abs(found - shared).max() < EXACT


@pytest.mark.parametrize("size", [1, 2, 3, 8])
def test_measures_are_those_of_the_batch(kind, size, generator):
    polygons = convex.hull(points(kind, size, generator))
    place = 0.5 * torch.rand(SETS, 3, dtype=torch.float64, generator=generator)
    expected = zip(
        convex.area(polygons).tolist(),
        convex.centroid(polygons).tolist(),
        margins(polygons, place).tolist(),
        strict=True,
    )
    for one, (x, _, z), (size_of_it, middle, inside) in zip(
        unpadded(polygons), place.tolist(), expected, strict=True
    ):
        assert area(one) == size_of_it
        assert list(centroid(one)) == middle
        assert margin(one, x, z) == pytest.approx(inside, abs=EXACT)


def test_an_empty_polygon_has_neither_centre_nor_margin():
    none = torch.empty(0, 2, dtype=torch.float64).numpy()
    assert math.isnan(margin(none, 0.0, 0.0))
    assert all(map(math.isnan, centroid(none)))
    assert len(hull(none)) == 0
