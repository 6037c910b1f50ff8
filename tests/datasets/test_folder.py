"""Scene folders: what is written is what is read, and never half of it."""

from __future__ import annotations

import json
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image

from blockstab.datasets.folder import read_truth, scene_folders, write_scene
from blockstab.datasets.truth import ObjectTruth, Truth
from blockstab.rgbd.frame import Camera, Frame, read_scene

POSE = torch.tensor(
    [[0.0, -1.0, 0.0, 0.1], [1.0, 0.0, 0.0, 0.2], [0.0, 0.0, 1.0, 1.3], [0.0, 0.0, 0.0, 1.0]],
    dtype=torch.float64,
)
FULL = ObjectTruth(
    *(2, "box", torch.tensor([0.03, 0.05, 0.1], dtype=torch.float64), POSE, (1,), (7,)),
    *(("partial",), "plank", 700, True),
)
BARE = ObjectTruth(7)
UP = torch.tensor([0.0, -0.8, -0.6], dtype=torch.float64)
TRUTH = Truth((1, 9), (FULL, BARE), UP, False)


@pytest.fixture
def frame(generator: torch.Generator) -> Frame:
    color = torch.randint(256, (6, 8, 3), generator=generator, dtype=torch.uint8)
    depth = torch.randint(3000, (6, 8), generator=generator).to(torch.float64) / 1000
    label = torch.randint(10, (6, 8), generator=generator)
    return Frame("a", color, depth, Camera(525.0, 526.0, 3.5, 2.5), label, (1, 9), UP)


def same(first: object, second: object) -> bool:
    if isinstance(first, torch.Tensor) and isinstance(second, torch.Tensor):
        return torch.equal(first, second)
    return first == second


def test_truth_survives_the_disk(tmp_path: Path, frame: Frame) -> None:
    write_scene(tmp_path / "a", frame, TRUTH, {})
    truth = read_truth(tmp_path / "a")
    assert truth.background_ids == (1, 9)
    assert truth.support_annotated is False
    assert same(truth.up_camera, UP)
    for found, given in zip(truth.objects, (FULL, BARE), strict=True):
        assert all(same(getattr(found, f.name), getattr(given, f.name)) for f in fields(given))


def test_a_boundary_survives_the_disk_and_can_be_seen(tmp_path: Path, frame: Frame) -> None:
    boundary = torch.zeros(2, 6, 8, dtype=torch.bool)
    boundary[0, 2, 3] = boundary[1, 2, 3] = boundary[0, 4, 4] = boundary[1, 5, 1] = True
    write_scene(tmp_path / "a", frame, replace(TRUTH, boundary=boundary), {})
    assert same(read_truth(tmp_path / "a").boundary, boundary)
    with Image.open(tmp_path / "a" / "boundary.png") as image:
        values = np.array(image)
    assert (values[2, 3], values[4, 4], values[5, 1], values[0, 0]) == (255, 85, 170, 0)


def test_a_boundary_of_another_size_is_refused(tmp_path: Path, frame: Frame) -> None:
    write_scene(tmp_path / "a", frame, TRUTH, {})
    Image.fromarray(np.zeros((6, 9), np.uint8)).save(tmp_path / "a" / "boundary.png")
    with pytest.raises(
        ValueError, match=r"boundary\.png: must have the 8 x 6 pixels of depth.png, but has 9 x 6"
    ):
        read_truth(tmp_path / "a")


def test_a_boundary_of_other_values_is_refused(tmp_path: Path, frame: Frame) -> None:
    write_scene(tmp_path / "a", frame, TRUTH, {})
    Image.fromarray(np.full((6, 8), 7, np.uint8)).save(tmp_path / "a" / "boundary.png")
    with pytest.raises(ValueError, match=r"boundary\.png: must hold 0, 85"):
        read_truth(tmp_path / "a")


def test_a_written_frame_is_read_back_the_same(tmp_path: Path, frame: Frame) -> None:
    write_scene(tmp_path / "a", frame, TRUTH, {})
    found = read_scene(tmp_path / "a")
    assert all(same(getattr(found, f.name), getattr(frame, f.name)) for f in fields(frame))


def test_meta_counts_the_pixels_of_each_object_and_keeps_extra_keys(tmp_path: Path, frame: Frame) -> None:
    write_scene(tmp_path / "a", frame, TRUTH, {"by": "hand"})
    meta = json.loads((tmp_path / "a" / "meta.json").read_text())
    assert meta["by"] == "hand"
    assert frame.label is not None
    assert [o["pixels"] for o in meta["objects"]] == [int((frame.label == i).sum()) for i in (2, 7)]


def test_an_extra_key_cannot_replace_one_of_the_format(tmp_path: Path, frame: Frame) -> None:
    with pytest.raises(ValueError, match="'fx'"):
        write_scene(tmp_path / "a", frame, TRUTH, {"fx": 1.0})


def test_depth_that_16_bits_cannot_hold_is_refused(tmp_path: Path, frame: Frame) -> None:
    frame.depth[0, 0] = 70.0
    with pytest.raises(ValueError, match="one pixel is 70000"):
        write_scene(tmp_path / "a", frame, TRUTH, {})


@pytest.mark.parametrize("already", [False, True])
def test_a_write_that_is_cut_off_leaves_what_was_there(
    tmp_path: Path, frame: Frame, monkeypatch: pytest.MonkeyPatch, already: bool
) -> None:
    folder = tmp_path / "a"
    if already:
        write_scene(folder, frame, TRUTH, {"run": 1})
    save = Image.Image.save

    def run_out_of_space(image: Image.Image, file: Path) -> None:
        if file.name == "label.png":
            raise OSError("no space left on device")
        save(image, file)

    monkeypatch.setattr(Image.Image, "save", run_out_of_space)
    with pytest.raises(OSError, match="no space"):
        write_scene(folder, frame, TRUTH, {"run": 2})
    assert scene_folders(tmp_path) == ([folder] if already else [])
    assert list(tmp_path.iterdir()) == ([folder] if already else [])
    if already:
        assert json.loads((folder / "meta.json").read_text())["run"] == 1


def test_a_draft_that_a_killed_run_left_is_no_scene_and_does_not_stay(tmp_path: Path, frame: Frame) -> None:
    draft = tmp_path / ".a.123.draft"
    draft.mkdir()
    (draft / "meta.json").write_text("{}")
    (draft / "stray.png").write_text("")
    assert scene_folders(tmp_path) == []
    write_scene(tmp_path / "a", frame, TRUTH, {})
    assert [f.name for f in tmp_path.iterdir()] == ["a"]
    assert sorted(f.name for f in (tmp_path / "a").iterdir()) == [
        "color.png",
        "depth.png",
        "label.png",
        "meta.json",
    ]


def test_scene_folders_are_those_with_a_meta_file_in_order(tmp_path: Path) -> None:
    for name in ("c", "a", "b"):
        (tmp_path / name).mkdir()
    for name in ("c", "a"):
        (tmp_path / name / "meta.json").write_text("{}")
    assert [f.name for f in scene_folders(tmp_path)] == ["a", "c"]


def test_a_missing_meta_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"meta\.json: must be a readable file"):
        read_truth(tmp_path)


def test_the_real_scenes_have_46_annotated_with_supports(real_scenes: Path) -> None:
    truths = [read_truth(folder) for folder in scene_folders(real_scenes / "osd")]
    assert len(truths) == 51
    annotated = [t for t in truths if t.support_annotated]
    assert len(annotated) == 46
    assert all(o.supported_by for t in annotated for o in t.objects)
