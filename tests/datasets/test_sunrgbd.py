"""SUN RGB-D, from a miniature."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import pytest
import torch

from blockstab.datasets.polygons import polygon_labels
from blockstab.datasets.sunrgbd import SUNRGBD
from blockstab.rgbd.frame import Camera
from blockstab.rgbd.reading import FrameError
from tests.datasets.sunrgbd_files import FULL, POLYGONS, TILT, write_sunrgbd, write_text

NAME = "kv2-lab-0001"


@pytest.fixture
def root(tmp_path: Path) -> Path:
    write_sunrgbd(tmp_path)
    return tmp_path


def test_depth_is_turned_back_into_millimetres_and_the_measured_one_is_preferred(root: Path) -> None:
    for scene in SUNRGBD(root).scenes():
        frame, _ = SUNRGBD(root).read(scene)
        assert bool((frame.depth == 1.503).all())
        assert frame.camera == Camera(40.0, 41.0, 19.5, 14.5)


def test_a_pixel_belongs_to_the_last_polygon_around_it(root: Path) -> None:
    frame, truth = SUNRGBD(root).read(NAME)
    assert frame.label is not None
    expected = torch.zeros(30, 40, dtype=torch.int64)
    expected[20:30] = 1
    expected[5:25, 5:25] = 2
    expected[10:15, 10:15] = 4
    expected[10:15, 30:35] = 4
    assert torch.equal(frame.label, expected)
    assert truth.background_ids == frame.background_ids == (1,)
    assert [(o.id, o.category) for o in truth.objects] == [(2, "box"), (4, "cup")]


def test_up_is_where_the_tilt_of_the_camera_says(root: Path) -> None:
    frame, truth = SUNRGBD(root).read(NAME)
    assert truth.up_camera is not None
    # Looking down, up is against y and against the line of sight.
    upright = torch.from_numpy(TILT) @ truth.up_camera
    assert upright.tolist() == pytest.approx([0.0, -1.0, 0.0])
    assert truth.up_camera.tolist() == pytest.approx([0.0, -0.8, 0.6])
    assert SUNRGBD(root).read("xtion-home-0002")[1].up_camera is None
    assert frame.up_camera is not None


def test_images_are_named_by_their_folders_from_any_root(root: Path) -> None:
    assert SUNRGBD(root).scenes() == [NAME, "xtion-home-0002"]
    assert SUNRGBD(root / FULL).scenes() == ["0001"]
    with pytest.raises(ValueError, match="holds no image"):
        SUNRGBD(root / FULL / "image").scenes()


def polygons(**changes: Any) -> dict[str, Any]:
    made = copy.deepcopy(POLYGONS)
    made["frames"][0]["polygon"][0].update(changes)
    return made


@pytest.mark.parametrize(
    "said",
    [
        {"frames": [], "objects": []},
        {"frames": [{"polygon": {}}], "objects": []},
        {"frames": [{"polygon": [None]}], "objects": []},
        polygons(object=None),
        polygons(object=-1),
        polygons(object=True),
        polygons(x=[1, 2, 3]),
        polygons(x=[1, 2, 3, 1e9]),
        polygons(x=[1, 2, 3, "4"]),
    ],
)
def test_polygons_that_make_no_sense_are_one_line(root: Path, said: object) -> None:
    write_text(root / FULL / "annotation2Dfinal/index.json", json.dumps(said))
    with pytest.raises(FrameError, match=r"index\.json: .*copy it again\.$") as caught:
        SUNRGBD(root).read(NAME)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < len(str(root)) + 400


def test_more_corners_than_can_soon_be_painted_are_refused(tmp_path: Path) -> None:
    zigzag = {"object": 0, "x": [0, 39] * 20_000, "y": [0, 29, 29, 0] * 10_000}
    write_text(tmp_path / "index.json", json.dumps({"objects": [{}], "frames": [{"polygon": [zigzag]}]}))
    assert bool((polygon_labels(tmp_path / "index.json", (30, 40))[0] == 1).any())
    for size in ((480, 640), (10**6, 1)):
        with pytest.raises(FrameError, match=r"at most \d+ corners, but have 40000"):
            polygon_labels(tmp_path / "index.json", size)


@pytest.mark.parametrize(
    ("name", "category"),
    [
        ("Chair2:occluded", "chair"),
        ("night stand 3", "night stand"),
        ("wall", "wall"),
        ("12", None),
        (3, None),
    ],
)
def test_a_name_is_told_without_what_parts_and_copies_add(
    tmp_path: Path, name: object, category: str | None
) -> None:
    write_text(tmp_path / "index.json", json.dumps({"objects": [{"name": name}], "frames": [{}]}))
    assert polygon_labels(tmp_path / "index.json", (3, 4))[1] == {1: category}


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("intrinsics.txt", "40 0 19.5 0 41 14.5 0 0"),
        ("intrinsics.txt", "40 0 19.5 0 41 14.5 0 0 nan"),
        ("intrinsics.txt", "a b c"),
        ("extrinsics/20140101.txt", "1 " * 12),
        ("extrinsics/20140101.txt", ""),
    ],
)
def test_numbers_that_are_no_camera_are_one_line(root: Path, file: str, text: str) -> None:
    write_text(root / FULL / file, text)
    with pytest.raises(FrameError, match=rf"{Path(file).name}: must hold .*, but .*; copy it again\.$"):
        SUNRGBD(root).read(NAME)


def test_a_link_out_of_the_root_is_refused(root: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    outside = tmp_path_factory.mktemp("outside") / "index.json"
    outside.write_text(json.dumps(POLYGONS))
    (root / FULL / "annotation2Dfinal/index.json").unlink()
    (root / FULL / "annotation2Dfinal/index.json").symlink_to(outside)
    with pytest.raises(FrameError, match="links out of it"):
        SUNRGBD(root).read(NAME)


def test_a_stamp_changes_with_the_annotation(root: Path) -> None:
    before = SUNRGBD(root).stamp(NAME)
    write_text(root / FULL / "annotation2Dfinal/index.json", "{}")
    assert SUNRGBD(root).stamp(NAME) != before
