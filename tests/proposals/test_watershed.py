"""Objects found by their boundaries alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
import torch
from torch import Tensor

from blockstab.observation import estimated_ground, observe
from blockstab.proposals.watershed import GROUND_ID, Watershed
from blockstab.rgbd.cloud import Cloud
from blockstab.rgbd.frame import Camera, Frame, read_scene
from tests.block_scene import APART, STACK, TABLE, Picture, picture


def overlap(label: Tensor, truth: Tensor) -> float:
    """The greatest intersection over union of any region with the true one."""
    regions = [label == region for region in label[truth].unique().tolist() if region > 0]
    return max((float((r & truth).sum() / (r | truth).sum()) for r in regions), default=0.0)


def propose(scene: Picture, threshold: float = 0.5, least_px: int = 100) -> Tensor:
    return Watershed(threshold, least_px)(scene.observation).label


@pytest.mark.parametrize("blocks", [APART, STACK], ids=["apart", "stack"])
def test_each_block_is_one_region(blocks) -> None:
    scene = picture(blocks)
    label = propose(scene)
    for number in (2, 3):
        assert overlap(label, scene.frame.label == number) > 0.9


def test_the_table_is_one_region_and_known_as_background() -> None:
    scene = picture(APART)
    proposed = Watershed()(scene.observation)
    assert dict(proposed.is_background) == {GROUND_ID: True}
    table = scene.frame.label == TABLE
    assert float(((proposed.label == GROUND_ID) & table).sum() / table.sum()) > 0.97
    assert float(((proposed.label == GROUND_ID) & ~table).sum() / (~table).sum()) < 0.05


def test_an_unknown_ground_leaves_the_blocks_apart() -> None:
    scene = picture(APART)
    unknown = replace(scene, ground=replace(scene.ground, height=None))
    proposed = Watershed()(unknown.observation)
    assert not proposed.is_background
    for number in (2, 3):
        assert overlap(proposed.label, scene.frame.label == number) > 0.8


def test_a_lower_threshold_gives_no_fewer_regions() -> None:
    scene = picture(STACK)
    counts = [len(propose(scene, threshold).unique()) for threshold in (0.1, 0.3, 0.6, 1.0)]
    assert counts == sorted(counts, reverse=True)
    assert counts[0] > counts[-1]


def test_no_region_is_smaller_than_asked() -> None:
    scene = picture(STACK)
    label = propose(scene, threshold=0.1, least_px=400)
    assert int(torch.bincount(label.flatten())[1:].min()) >= 400


@pytest.mark.parametrize("threshold", [-0.1, 1.5, float("nan")])
def test_a_threshold_that_no_strength_reaches_is_refused(threshold: float) -> None:
    with pytest.raises(ValueError, match="between 0 and 1"):
        Watershed(threshold)


def test_a_picture_without_depth_has_no_regions() -> None:
    empty = torch.zeros(40, 50, dtype=torch.float64)
    points = torch.zeros(40, 50, 3, dtype=torch.float64)
    frame = Frame("dark", torch.zeros(40, 50, 3, dtype=torch.uint8), empty, Camera(50.0, 50.0, 24.5, 19.5))
    cloud = Cloud(points, points, empty > 0, empty)
    assert not propose(Picture(frame, cloud, picture(()).ground)).any()


@pytest.mark.parametrize("name", ["learn04", "learn16", "learn22"])
def test_boxes_on_a_real_table_are_found(real_scenes: Path, name: str) -> None:
    frame = read_scene(real_scenes / "osd" / name)
    label = Watershed()(observe(frame, estimated_ground)).label
    assert frame.label is not None
    label = torch.where(frame.label > 0, label, 0)
    for number in frame.label.unique().tolist():
        if number > 0 and number not in frame.background_ids:
            assert overlap(label, frame.label == number) > 0.75
