"""Objects by their faces."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch
from torch import Tensor

from blockstab.proposals.plane_pieces import GROUND_ID, Planes
from tests.block_scene import APART, STACK, TABLE, Picture, picture


def face(scene: Picture, block: int, axis: int) -> Tensor:
    """(H, W) bool: where a block faces along an axis of the world."""
    return (scene.frame.label == block) & (scene.cloud.normals[..., axis] > 0.99)


def overlap(label: Tensor, truth: Tensor) -> float:
    """The intersection over union of the truth with the region that has most of it."""
    region = label == label[truth].mode().values
    return float((region & truth).sum() / (region | truth).sum())


def test_each_face_of_a_block_is_a_region() -> None:
    scene = picture(STACK)
    label = Planes(least_px=100)(scene.observation).label
    faces = [face(scene, block, axis) for block in (2, 3) for axis in (1, 2)]
    assert all(overlap(label, truth) > 0.9 for truth in faces)
    assert len({int(label[truth].mode().values) for truth in faces}) == 4


def test_two_pieces_of_a_plane_are_two_regions() -> None:
    scene = picture(APART)  # whose fronts lie in one plane
    label = Planes(least_px=100)(scene.observation).label
    fronts = [face(scene, block, 2) for block in (2, 3)]
    plane = [int(scene.observation.planes.label[truth].mode().values) for truth in fronts]
    assert plane[0] == plane[1]
    assert label[fronts[0]].mode().values != label[fronts[1]].mode().values


def test_the_table_is_one_region_and_known_as_background() -> None:
    scene = picture(APART)
    proposed = Planes()(scene.observation)
    assert dict(proposed.is_background) == {GROUND_ID: True}
    table = scene.frame.label == TABLE
    assert overlap(proposed.label, table) > 0.95
    assert int(proposed.label[table].mode().values) == GROUND_ID


def test_what_lies_on_no_plane_is_a_region_for_each_piece() -> None:
    scene = picture(APART)
    observation = scene.observation
    for block in (2, 3):
        observation.planes.label[scene.frame.label == block] = 0
    label = Planes(least_px=100)(observation).label
    for block in (2, 3):
        assert overlap(label, scene.frame.label == block) > 0.8


def test_without_a_known_ground_no_region_is_background() -> None:
    scene = picture(STACK)
    unknown = replace(scene, ground=replace(scene.ground, height=None))
    proposed = Planes(least_px=100)(unknown.observation)
    assert not proposed.is_background
    assert overlap(proposed.label, scene.frame.label == TABLE) > 0.95


def test_a_ground_that_is_smaller_than_a_region_is_not_known() -> None:
    assert not Planes(least_px=10**6)(picture(STACK).observation).is_background


def test_no_region_is_smaller_than_asked() -> None:
    label = Planes(least_px=1000)(picture(STACK).observation).label
    pixels = torch.bincount(label.flatten())[1:]
    assert int(pixels[pixels > 0].min()) >= 1000


@pytest.mark.parametrize("share", [0.0, 1.5, float("nan")])
def test_a_share_that_no_plane_can_have_is_refused(share: float) -> None:
    with pytest.raises(ValueError, match="above 0 and up to 1"):
        Planes(ground_share=share)
