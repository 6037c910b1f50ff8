"""The smallest box around points, and what Open3D makes of points that lie in a plane."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor

from blockstab.boxes.box import MIN_HALF_EXTENT, checked
from blockstab.boxes.fitting import Fits, MinimumSurface
from blockstab.boxes.minimum_volume import MinimumVolume
from tests.seen_boxes import axis_error_deg, boxes_showing, half_extent_error, random_turns, seen_points
from tests.tolerance import EXACT


def fitted(points: Tensor, axis: Tensor | None = None) -> Fits:
    n = len(points)
    return MinimumVolume()(points, torch.full((n,), points.shape[1]), torch.arange(n), axis)


def holds(fits: Fits, points: Tensor) -> bool:
    return bool((fits.boxes.local(points).abs() <= fits.boxes.half_extent[:, None] + EXACT).all())


def test_the_smallest_box_around_the_corners_of_a_box_is_that_box(generator: torch.Generator) -> None:
    boxes = boxes_showing(3, 20, generator)
    fits = fitted(boxes.corners())
    assert float(axis_error_deg(fits.boxes, boxes).max()) < 1e-6
    assert float(half_extent_error(fits.boxes, boxes).abs().max()) < EXACT
    assert float((fits.boxes.center - boxes.center).abs().max()) < EXACT
    assert float(fits.mean.max()) < EXACT


def test_no_turn_makes_a_box_much_smaller(generator: torch.Generator) -> None:
    size = torch.tensor([0.1, 0.05, 0.02], dtype=torch.float64)
    points = size * torch.randn(20, 100, 3, generator=generator, dtype=torch.float64)
    turned = points[:, None] @ random_turns(2000, generator)
    smallest = (turned.amax(dim=2) - turned.amin(dim=2)).prod(dim=-1).amin(dim=1)
    fits = fitted(points)
    # Open3D tries the turns that lay one edge of each triangle of the hull along the box: near the best.
    share = fits.boxes.volume() / smallest
    assert float(share.max()) < 1.3
    assert float(share.mean()) < 1.1
    assert holds(fits, points)


def lattice(thickness_m: float, generator: torch.Generator) -> Tensor:
    """(1, 300, 3) points of a plate of 20 by 10 cm, somewhere."""
    side, other = torch.linspace(-0.1, 0.1, 20).double(), torch.linspace(-0.05, 0.05, 15).double()
    flat = torch.cartesian_prod(side, other, torch.zeros(1, dtype=torch.float64))
    flat[:, 2] += thickness_m * torch.randn(300, generator=generator, dtype=torch.float64)
    return (flat @ random_turns(1, generator)[0].T + flat.new_tensor([0.1, 0.2, -1.0]))[None]


@pytest.mark.parametrize("thickness_m", [0.0, 1e-12])
def test_points_in_a_plane_get_a_box_of_their_own_size(
    thickness_m: float, generator: torch.Generator
) -> None:
    points = lattice(thickness_m, generator)
    fits = fitted(points)
    checked(fits.boxes)
    half = fits.boxes.half_extent[0].sort().values
    assert half.tolist() == pytest.approx([MIN_HALF_EXTENT, 0.05, 0.1], abs=1e-8)
    assert holds(fits, points)


@pytest.mark.parametrize("thickness_m", [1e-9, 1e-7, 1e-5])
def test_points_almost_in_a_plane_get_a_flat_box_of_about_their_size(
    thickness_m: float, generator: torch.Generator
) -> None:
    points = lattice(thickness_m, generator)
    fits = fitted(points)
    checked(fits.boxes)
    thin, narrow, wide = fits.boxes.half_extent[0].sort().values.tolist()
    assert thin == MIN_HALF_EXTENT
    assert 0.05 - 1e-6 < narrow < 0.06
    assert 0.1 - 1e-6 < wide < 0.12
    assert holds(fits, points)


@pytest.mark.parametrize(
    "points",
    [
        [[0.1, 0.2, -1.0]],
        [[0.1, 0.2, -1.0], [0.2, 0.1, -1.0]],
        [[0.1, 0.2, -1.0], [0.15, 0.2, -1.0], [0.1, 0.3, -1.1]],
        [[0.1, 0.2, -1.0]] * 50,
        [[0.01 * k, 0.02 * k, -1.0 + 0.005 * k] for k in range(50)],
        [[0.0, 0.0, -1.0], [0.1, 0.0, -1.0], [0.0, 0.1, -1.0], [0.0, 0.0, -1.1]],
    ],
    ids=["one", "two", "three", "equal", "on a line", "a tetrahedron"],
)
def test_poor_points_give_a_whole_box_around_them(points: list[list[float]]) -> None:
    given = torch.tensor([points], dtype=torch.float64)
    fits = fitted(given)
    checked(fits.boxes)
    assert holds(fits, given)
    assert bool(fits.mean.isfinite().all())


def test_rows_past_the_count_do_not_count(generator: torch.Generator) -> None:
    boxes = boxes_showing(3, 2, generator)
    points = torch.cat([boxes.corners(), 9 + torch.zeros(2, 5, 3, dtype=torch.float64)], dim=1)
    found = MinimumVolume()(points, torch.tensor([8, 8]), torch.arange(2)).boxes
    assert float((found.volume() / boxes.volume() - 1).abs().max()) < 1e-6


def test_it_misses_the_axes_of_boxes_of_which_only_part_is_seen(generator: torch.Generator) -> None:
    # The reason for boxes of minimum surface distance (Fig. 3 of the paper).
    boxes = boxes_showing(3, 30, generator)
    points = seen_points(boxes, 500, generator, 0.002)
    count, seed = torch.full((30,), 500), torch.arange(30)
    volume, surface = (fit(points, count, seed).boxes for fit in (MinimumVolume(), MinimumSurface()))
    assert float(axis_error_deg(volume, boxes).mean()) > 5 * float(axis_error_deg(surface, boxes).mean())


def test_no_sets_give_no_fits() -> None:
    assert len(fitted(torch.zeros(0, 10, 3, dtype=torch.float64))) == 0


def test_it_refuses_to_follow_an_axis() -> None:
    points = torch.rand(1, 10, 3, dtype=torch.float64, generator=torch.Generator().manual_seed(0))
    with pytest.raises(ValueError, match="cannot follow an axis; use MinimumSurface"):
        fitted(points, torch.tensor([[0.0, 1.0, 0.0]], dtype=torch.float64))
