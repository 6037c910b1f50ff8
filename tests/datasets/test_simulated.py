"""Simulated scenes are true, repeatable, and can be made in several goes."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import pytest
import torch

from blockstab.boxes.box import Boxes, checked
from blockstab.boxes.separation import separation
from blockstab.datasets.folder import read_truth, scene_folders
from blockstab.datasets.sensor import axial_noise
from blockstab.datasets.simulated import simulate_scene, write_simulated
from blockstab.datasets.truth import Truth
from blockstab.rgbd.cloud import cloud_from_frame
from blockstab.rgbd.frame import Frame, read_scene

pytest.importorskip("mujoco", reason="the extra `sim` is not installed")

TOUCH = 0.001  # metres; how far contacts sink in, or stay apart, in the engine
Scenes = list[tuple[Frame, Truth]]


def boxes_of(truth: Truth) -> Boxes:
    poses = torch.stack([o.pose_camera for o in truth.objects if o.pose_camera is not None])
    half_extents = torch.stack([o.half_extent for o in truth.objects if o.half_extent is not None])
    return checked(Boxes(poses[:, :3, 3], poses[:, :3, :3], half_extents))


def up_of(truth: Truth) -> torch.Tensor:
    assert truth.up_camera is not None
    return truth.up_camera


def label_of(frame: Frame) -> torch.Tensor:
    assert frame.label is not None
    return frame.label


def test_every_supporter_touches_what_it_supports(scenes: Scenes) -> None:
    for _, truth in scenes:
        pairs = [(i, s - 2) for i, o in enumerate(truth.objects) for s in o.supported_by or () if s != 1]
        upper, lower = torch.tensor(pairs).unbind(dim=1)
        assert float(separation(boxes_of(truth), lower, upper).gap.abs().max()) < TOUCH


def test_every_object_has_a_supporter_and_a_third_stand_on_another(scenes: Scenes) -> None:
    supporters = [o.supported_by for _, truth in scenes for o in truth.objects]
    assert all(supporters)
    for _, truth in scenes:
        stacked = [any(s != 1 for s in o.supported_by or ()) for o in truth.objects]
        assert 3 * sum(stacked) >= len(stacked)
        assert 3 <= len(stacked) <= 10


def test_what_the_table_supports_stands_on_one_plane_and_nothing_reaches_below_it(scenes: Scenes) -> None:
    for _, truth in scenes:
        lowest = (boxes_of(truth).corners() @ up_of(truth)).amin(dim=1)
        on_table = torch.tensor([1 in (o.supported_by or ()) for o in truth.objects])
        assert float(lowest[on_table].amax() - lowest.amin()) < TOUCH
        assert (lowest[~on_table] > lowest[on_table].amin() + 0.02).all()


def test_up_is_the_normal_of_the_table_that_the_sensor_measures(scenes: Scenes) -> None:
    for frame, truth in scenes:
        table = cloud_from_frame(frame).points[(label_of(frame) == 1) & (frame.depth < 2.0)]
        heights = table @ up_of(truth)
        assert float((heights - heights.median()).abs().quantile(0.9)) < 0.01
        lowest = (boxes_of(truth).corners() @ up_of(truth)).amin()
        assert abs(float(heights.median() - lowest)) < 0.002


def test_measured_points_lie_on_the_true_boxes_within_the_noise(scenes: Scenes) -> None:
    for frame, truth in scenes:
        points = cloud_from_frame(frame).points
        boxes = boxes_of(truth)
        for i, o in enumerate(truth.objects):
            mine = label_of(frame) == o.id
            if int(mine.sum()) < 300:
                continue
            local = boxes[[i]].local(points[mine][None])[0]
            # Where a point is outside, the largest excess bounds its distance to the surface from below.
            off = (local.abs() - boxes.half_extent[i]).amax(dim=1)
            noise = axial_noise(frame.depth[mine], torch.tensor(1.0, dtype=torch.float64))
            assert float((off.abs() / noise).quantile(0.8)) < 2.5
            assert abs(float(off.median())) < 0.0015


def test_labels_are_the_background_and_the_objects_and_only_where_depth_is(scenes: Scenes) -> None:
    for frame, truth in scenes:
        label = label_of(frame)
        known = {0, *truth.background_ids, *(o.id for o in truth.objects)}
        assert set(label.unique().tolist()) <= known
        assert frame.background_ids == truth.background_ids
        assert not label[frame.depth == 0].any()
        assert float((frame.depth == 0).double().mean()) < 0.6


def test_what_rests_on_one_thing_alone_falls_without_it(scenes: Scenes) -> None:
    for _, truth in scenes:
        falling = {o.id: o.falls_if_removed or () for o in truth.objects}
        for o in truth.objects:
            assert o.supported_by
            if len(o.supported_by) == 1 and o.supported_by != (1,):
                assert o.id in falling[o.supported_by[0]]


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Two scenes of seed 3, made by one job."""
    return write_simulated(tmp_path_factory.mktemp("one"), "blocks", 2, seed=3)


def test_scenes_and_bytes_do_not_depend_on_the_number_of_jobs(tmp_path: Path, written: list[Path]) -> None:
    two = write_simulated(tmp_path, "blocks", 2, seed=3, jobs=2)
    assert [f.name for f in written] == [f.name for f in two] == ["blocks_0000", "blocks_0001"]
    for a, b in zip(written, two, strict=True):
        names = sorted(f.name for f in a.iterdir())
        assert names == ["color.png", "depth.png", "label.png", "meta.json"]
        assert all((a / name).read_bytes() == (b / name).read_bytes() for name in names)
    assert (two[0] / "depth.png").read_bytes() != (two[1] / "depth.png").read_bytes()


def test_a_written_scene_is_the_simulated_one(written: list[Path]) -> None:
    folder = written[0]
    frame, truth = simulate_scene("blocks", 3, 0)
    found, told = read_scene(folder), read_truth(folder)
    assert found.name == frame.name
    assert torch.equal(found.color, frame.color)
    assert torch.equal(found.depth, frame.depth)
    assert torch.equal(label_of(found), label_of(frame))
    assert torch.equal(up_of(told), up_of(truth))
    assert told.support_annotated
    assert [(o.supported_by, o.falls_if_removed) for o in told.objects] == [
        (o.supported_by, o.falls_if_removed) for o in truth.objects
    ]


def test_a_second_run_makes_only_what_is_missing(tmp_path: Path, written: list[Path]) -> None:
    first = tmp_path / "blocks_0000"
    shutil.copytree(written[0], first)
    kept = first.stat().st_ino
    assert write_simulated(tmp_path, "blocks", 2, seed=3) == scene_folders(tmp_path)
    assert first.stat().st_ino == kept
    assert (tmp_path / "blocks_0001" / "depth.png").read_bytes() == (written[1] / "depth.png").read_bytes()


def test_another_seed_replaces_the_scenes(tmp_path: Path, written: list[Path]) -> None:
    shutil.copytree(written[0], tmp_path / "blocks_0000")
    (folder,) = write_simulated(tmp_path, "blocks", 1, seed=4)
    assert (folder / "depth.png").read_bytes() != (written[0] / "depth.png").read_bytes()
    assert list(tmp_path.iterdir()) == [folder]


def test_a_folder_that_is_no_simulated_scene_is_not_overwritten(tmp_path: Path) -> None:
    (tmp_path / "blocks_0001").mkdir()
    (tmp_path / "blocks_0001" / "thesis.txt").write_text("mine")
    with pytest.raises(ValueError, match="blocks_0001 exists and is no simulated scene"):
        write_simulated(tmp_path, "blocks", 2, seed=3)
    assert not (tmp_path / "blocks_0000").exists()
    assert (tmp_path / "blocks_0001" / "thesis.txt").read_text() == "mine"


def test_an_unknown_preset_is_refused_with_those_there_are(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no preset 'cubes'; choose from: blocks"):
        write_simulated(tmp_path, "cubes", 1, seed=0)


@pytest.mark.parametrize(("count", "seed", "jobs"), [(0, 0, 1), (1, -1, 1), (1, 0, 0)])
def test_numbers_out_of_range_are_named(tmp_path: Path, count: int, seed: int, jobs: int) -> None:
    with pytest.raises(ValueError, match=f"count is {count}, seed {seed} and jobs {jobs}"):
        write_simulated(tmp_path, "blocks", count, seed, jobs)


def test_a_run_without_the_engine_says_so_before_it_writes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(ModuleNotFoundError, match=r"pip install 'blockstab\[sim\]'"):
        write_simulated(tmp_path / "out", "blocks", 1, seed=0)
    assert not (tmp_path / "out").exists()
