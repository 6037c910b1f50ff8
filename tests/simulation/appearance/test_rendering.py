"""The picture of a pile that is known."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from blockstab.simulation.appearance.rendering import TABLE, Picture, photograph, slipped
from blockstab.simulation.sensors import Ideal, Sensor
from tests.simulation.scenery import KINECT, Scenery, of_one_part, scenery, standing

BLOCK = of_one_part("box", (0.05, 0.1, 0.05), "block")
TIN = of_one_part("cylinder", (0.04, 0.06, 0.04), "tin")
PILE = standing((BLOCK, 0.0, 0.0), (TIN, 0.05, 0.12), (TIN, -0.12, -0.05))


def taken(scene: Scenery, seed: int, variety: float = 1.0, sensor: Sensor = KINECT) -> Picture:
    generator = torch.Generator().manual_seed(seed)
    return photograph("one", scene.pile, scene.view, scene.room, sensor, variety, generator)


@pytest.fixture(scope="module")
def blocks() -> list[tuple[Scenery, Picture]]:
    """One block by itself, from four sides."""
    scenes = [scenery(standing((BLOCK, 0.0, 0.0)), seed) for seed in range(4)]
    return [(scene, taken(scene, seed)) for seed, scene in enumerate(scenes)]


@pytest.fixture(scope="module")
def piles() -> list[tuple[Scenery, Picture]]:
    """A block and two tins, on a table and on a shelf."""
    scenes = [scenery(PILE, 5), scenery(PILE, 6, "shelf")]
    return [(scene, taken(scene, 3)) for scene in scenes]


def labels(picture: Picture) -> torch.Tensor:
    assert picture.frame.label is not None
    return picture.frame.label


def test_the_block_has_label_2_and_covers_the_middle(blocks: list[tuple[Scenery, Picture]]) -> None:
    for scene, picture in blocks:
        frame = picture.frame
        assert frame.label is not None
        assert frame.label[120, 160] == 2
        assert frame.background_ids == (TABLE, *range(3, 2 + len(scene.room)))
        assert frame.color.shape == (KINECT.height_px, KINECT.width_px, 3)
        assert frame.color.dtype == torch.uint8


def test_the_projector_s_shadow_falls_to_the_left_of_the_block(blocks: list[tuple[Scenery, Picture]]) -> None:
    left = right = 0  # holes on the right are faces seen at a grazing angle
    for _, picture in blocks:
        rows, columns = (labels(picture) == 2).nonzero().unbind(dim=1)
        beside = picture.frame.depth[rows.min() : rows.max(), columns.min() - 20 : columns.max() + 20] == 0
        across = torch.arange(beside.shape[1]) + columns.min() - 20 - columns.double().mean()
        left += int(beside[:, across < 0].sum())
        right += int(beside[:, across > 0].sum())
    assert left > 2 * right


def test_labels_are_the_surfaces_whether_the_sensor_sees_them_or_not(
    piles: list[tuple[Scenery, Picture]],
) -> None:
    for scene, picture in piles:
        label = labels(picture)
        assert int(((picture.frame.depth == 0) & (label > 0)).sum()) > 25
        # The pieces of the room come first among the solids that are cast at, and after the objects in labels.
        assert torch.equal(label == 2, scene.seen.solid == len(scene.room))
        assert torch.equal(label == TABLE, scene.seen.solid == 0)
        assert torch.equal(label == 0, scene.seen.solid < 0)


def test_objects_alone_would_cover_what_is_seen_of_them_or_more(piles: list[tuple[Scenery, Picture]]) -> None:
    for _, picture in piles:
        seen = torch.stack([(labels(picture) == 2 + i).sum() for i in range(3)])
        assert (picture.total_pixels >= seen).all()
        assert (picture.total_pixels > seen).any()


def test_an_object_that_nothing_hides_covers_what_is_seen_of_it(
    blocks: list[tuple[Scenery, Picture]],
) -> None:
    for _, picture in blocks:
        assert picture.total_pixels.tolist() == [int((labels(picture) == 2).sum())]


def test_equal_generators_take_equal_pictures_and_depth_does_not_depend_on_colour() -> None:
    scene = scenery(PILE, 8)
    first, again, plain = taken(scene, 2), taken(scene, 2), taken(scene, 2, variety=0.0)
    assert torch.equal(first.frame.color, again.frame.color)
    assert torch.equal(first.frame.depth, again.frame.depth)
    assert torch.equal(first.frame.depth, plain.frame.depth)
    assert not torch.equal(first.frame.color, plain.frame.color)


def test_an_ideal_sensor_measures_every_surface() -> None:
    scene = scenery(PILE, 8)
    picture = taken(scene, 2, 0.0, Ideal(KINECT.camera, KINECT.height_px, KINECT.width_px))
    assert torch.equal(picture.frame.depth > 0, labels(picture) > 0)
    assert float((picture.frame.depth - scene.seen.depth).abs().max()) < 0.0006


def test_black_glass_has_holes_where_wood_has_none() -> None:
    dark = replace(BLOCK, parts=(replace(BLOCK.parts[0], echo=0.1),))
    shares = []
    for block in (BLOCK, dark):
        picture = taken(scenery(standing((block, 0.0, 0.0)), 2), 1)
        inside = labels(picture) == TABLE + 1
        shares.append(float((picture.frame.depth[inside] > 0).double().mean()))
    assert shares[0] > 0.9
    assert 0.05 < shares[1] < 0.5


def test_a_picture_slips_by_whole_pixels_and_its_border_is_drawn_out(generator: torch.Generator) -> None:
    color = torch.arange(30 * 40 * 3).view(30, 40, 3).to(torch.uint8)
    assert torch.equal(slipped(color, 0.0, generator), color)
    offsets = set()
    for _ in range(60):
        after = slipped(color, 1.2, generator)
        found = [
            (down, right)
            for down in range(-4, 5)
            for right in range(-4, 5)
            if torch.equal(after[5:-5, 5:-5], color[5 + down : 25 + down, 5 + right : 35 + right])
        ]
        assert len(found) == 1
        offsets.update(found)
        for side in (after[0], after[-1], after[:, 0], after[:, -1]):
            assert side.shape[-1] == 3
    assert len(offsets) > 10
    assert max(abs(d) for pair in offsets for d in pair) <= 4
