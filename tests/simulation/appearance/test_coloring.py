"""Colour is lit and printed, and no guide to what is an object."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor
from torch.nn.functional import max_pool2d

from blockstab.simulation.appearance.coloring import paint
from tests.simulation.scenery import Scenery, of_one_part, scenery, standing

CARTON = of_one_part("box", (0.05, 0.06, 0.05), "carton")
PRODUCT = of_one_part("box", (0.05, 0.06, 0.05), "carton", product=9)
PILE = standing(
    *((CARTON, 0.15 * x, -0.15) for x in (-1, 0, 1)),
    *((PRODUCT, 0.15 * x, 0.05) for x in (-1, 1)),
)


def painted(scene: Scenery, variety: float, seed: int = 1) -> torch.Tensor:
    generator = torch.Generator().manual_seed(seed)
    return paint(scene.seen, scene.view, scene.room, scene.pile, scene.caster, variety, generator).double()


@pytest.fixture(scope="module")
def scene() -> Scenery:
    return scenery(PILE, 4)


@pytest.fixture(scope="module")
def full(scene: Scenery) -> torch.Tensor:
    return painted(scene, 1.0)


@pytest.fixture(scope="module")
def plain(scene: Scenery) -> torch.Tensor:
    return painted(scene, 0.0)


def faces(scene: Scenery, color: torch.Tensor) -> list[torch.Tensor]:
    """The pixels (M, 3) of every face of a carton that is well seen."""
    patch = 10 * scene.seen.solid + scene.seen.patch
    all_faces = [color[patch == n] for n in patch[scene.seen.solid >= len(scene.room)].unique().tolist()]
    return [pixels for pixels in all_faces if len(pixels) > 100]


def hue_spread(pixels: torch.Tensor) -> float:
    share = pixels / pixels.sum(dim=1, keepdim=True).clamp(min=1)
    return float((share - share.median(dim=0).values).norm(dim=1).median())


def test_faces_are_printed_with_variety_and_plain_without(
    scene: Scenery, full: torch.Tensor, plain: torch.Tensor
) -> None:
    printed, bare = ([hue_spread(face) for face in faces(scene, color)] for color in (full, plain))
    middle = len(bare) // 2
    assert max(bare) < 0.03
    assert sorted(printed)[middle] > 3 * sorted(bare)[middle]


def test_the_picture_is_muted_and_neither_dark_nor_bright(scene: Scenery, full: torch.Tensor) -> None:
    assert 70 < float(full.median()) < 160
    middle = full.median(dim=1).values.median(dim=0).values
    assert float(middle.max() - middle.min()) < 80


def test_pixels_at_the_edge_of_an_object_are_a_mix_of_both_sides(scene: Scenery, plain: torch.Tensor) -> None:
    # Along rows through the silhouette the steps from pixel to pixel are smaller than the whole edge.
    objects = scene.seen.solid >= len(scene.room)
    edge = (objects[:, 3:-3] != objects[:, 2:-4]).nonzero() + torch.tensor([0, 3])
    row, column = edge[::5].unbind(dim=1)
    whole = (plain[row, column + 2] - plain[row, column - 3]).norm(dim=1)
    step = (plain[row, column] - plain[row, column - 1]).norm(dim=1)
    strong = whole > 60
    assert int(strong.sum()) > 20
    assert float((step / whole)[strong].median()) < 0.8


def test_the_table_is_darker_at_the_foot_of_things_than_away_from_them(scene: Scenery, plain: Tensor) -> None:
    objects = (scene.seen.solid >= len(scene.room)).float()[None, None]
    near, far = (max_pool2d(objects, size, stride=1, padding=size // 2)[0, 0] > 0 for size in (7, 61))
    top = (scene.seen.solid == 0) & (scene.seen.points[..., 1].abs() < 1e-6)
    assert plain[top & near].mean() < 0.92 * plain[top & ~far].mean()


def test_equal_generators_paint_equal_pictures(scene: Scenery, full: torch.Tensor) -> None:
    assert torch.equal(full, painted(scene, 1.0))
    assert not torch.equal(full, painted(scene, 1.0, seed=2))
