"""Cropped scenes: the same world through smaller windows."""

from __future__ import annotations

from pathlib import Path

import pytest
import torch

from blockstab.datasets.cropped import CroppedScenes
from blockstab.datasets.folder import write_scene
from blockstab.datasets.sets import FolderScenes
from blockstab.datasets.truth import ObjectTruth, Truth
from blockstab.observation import estimated_ground, observe
from blockstab.rgbd.cloud import cloud_from_frame
from blockstab.testing import SceneSetContract
from blockstab.testing.photographs import BLOCKS, photograph
from tests.tolerance import EXACT

TRUTH = Truth((1,), tuple(ObjectTruth(id=k) for k in range(2, 6)), None, False)


@pytest.fixture
def whole(tmp_path: Path) -> FolderScenes:
    for k in range(6):
        write_scene(tmp_path / f"scene{k}", photograph(*BLOCKS, seed=k).frame, TRUTH, {})
    return FolderScenes(tmp_path)


def test_a_share_of_the_scenes_is_cropped_and_the_others_stay(whole):
    full = whole.read("scene0")[0].depth.shape
    sizes = [
        sum(CroppedScenes(whole, share).read(scene)[0].depth.shape != full for scene in whole.scenes())
        for share in (0.0, 0.5, 1.0)
    ]
    assert sizes[0] == 0 < sizes[1] < sizes[2]


def test_every_pixel_keeps_its_colour_its_label_and_its_place_in_the_world(whole):
    cut, full = CroppedScenes(whole, 1.0, 0.5).read("scene0")[0], whole.read("scene0")[0]
    top, left = round(full.camera.cy - cut.camera.cy), round(full.camera.cx - cut.camera.cx)
    height, width = cut.depth.shape
    window = (slice(top, top + height), slice(left, left + width))
    assert (height, width) < tuple(full.depth.shape)
    assert torch.equal(cut.color, full.color[window])
    assert torch.equal(cut.label, full.label[window])
    points, wanted = cloud_from_frame(cut).points, cloud_from_frame(full).points[window]
    assert torch.allclose(points, wanted, rtol=0, atol=EXACT)


def test_things_are_cut_by_the_rim_and_what_is_left_of_them_may_be_hardly_seen(whole):
    data, cuts = CroppedScenes(whole, 1.0, 0.3), 0
    for scene in data.scenes():
        frame, truth = data.read(scene)
        rim = torch.cat([frame.label[0], frame.label[-1], frame.label[:, 0], frame.label[:, -1]])
        cuts += int(bool((rim > 1).any()))
        for o in truth.objects:
            assert o.hardly_seen == (int(((frame.label == o.id) & (frame.depth > 0)).sum()) < 100)
        assert bool((frame.label > 1).any())
    assert cuts >= 3


def test_the_same_seed_cuts_the_same_windows_and_another_others(whole):
    one, other = (
        [CroppedScenes(whole, 1.0, seed=seed).read(s)[0].camera for s in whole.scenes()] for seed in (0, 1)
    )
    assert one == [CroppedScenes(whole, 1.0).read(s)[0].camera for s in whole.scenes()]
    assert one != other
    assert CroppedScenes(whole, seed=0).stamp("scene0") != CroppedScenes(whole, seed=1).stamp("scene0")


def test_a_cropped_scene_can_be_looked_at(whole):
    frame, _ = CroppedScenes(whole, 1.0, 0.5).read("scene1")
    assert int(observe(frame, estimated_ground).fine.max()) > 3


def test_it_keeps_the_contract_of_sets(whole):
    tests = type("TestCropped", (SceneSetContract,), {"part": CroppedScenes(whole)})()
    for name in dir(tests):
        if name.startswith("test_"):
            getattr(tests, name)()


@pytest.mark.parametrize(("share", "least"), [(-0.1, 0.5), (1.1, 0.5), (0.5, 0.0), (0.5, 1.5)])
def test_shares_that_are_none_are_refused(whole, share, least):
    with pytest.raises(ValueError, match="choose others"):
        CroppedScenes(whole, share, least)
