"""The Object Segmentation Database."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from blockstab.datasets.osd import OSD
from blockstab.datasets.sets import FolderScenes
from blockstab.rgbd.frame import Camera
from blockstab.rgbd.reading import FrameError
from tests.datasets.pcd_files import seen, table_of, write_cloud

CAMERA = Camera(40.0, 40.0, 15.5, 9.5)
SIZE = (20, 30)
REAL = ("learn00", "learn33", "test57")


def cloud_of(path: Path, *ids: int) -> Path:
    """A wall of labelled stripes, the first on the left."""
    label = np.array(ids)[np.arange(SIZE[1]) * len(ids) // SIZE[1]] + np.zeros(SIZE, np.int64)
    points = seen(np.ones(SIZE), CAMERA)
    return write_cloud(path, table_of(points, np.full((*SIZE, 3), (200, 30, 7), np.uint8), label))


def annotate(path: Path, ids: np.ndarray) -> None:
    path.parent.mkdir()
    Image.fromarray(ids).save(path)


@pytest.mark.parametrize("name", REAL)
def test_a_real_scene_comes_back_from_a_cloud_as_from_its_folder(
    real_scenes: Path, tmp_path: Path, name: str
) -> None:
    frame, _ = FolderScenes(real_scenes / "osd").read(name)
    assert frame.label is not None
    points = seen(frame.depth.numpy(), frame.camera)
    write_cloud(tmp_path / f"{name}.pcd", table_of(points, frame.color.numpy(), frame.label.numpy()))
    found, truth = OSD(tmp_path).read(name)
    np.testing.assert_array_equal(found.depth, frame.depth.numpy().astype(np.float32))
    np.testing.assert_array_equal(found.color, frame.color)
    np.testing.assert_array_equal(found.label, frame.label)
    assert found.camera.intrinsics == pytest.approx(frame.camera.intrinsics, abs=0.5)
    assert [o.id for o in truth.objects] == [i for i in frame.label.unique().tolist() if i > 1]


@pytest.mark.parametrize("folder", ["", "learn", "pcd"])
def test_labelled_clouds_lie_in_any_of_the_layouts(tmp_path: Path, folder: str) -> None:
    cloud_of(tmp_path / folder / "learn3.pcd", 0, 1, 2, 3)
    assert OSD(tmp_path).scenes() == ["learn3"]
    frame, truth = OSD(tmp_path).read("learn3")
    assert frame.name == "learn3"
    assert frame.background_ids == truth.background_ids == (1,)
    assert [o.id for o in truth.objects] == [2, 3]
    assert frame.color[0, 0].tolist() == [200, 30, 7]


@pytest.mark.parametrize(
    ("ids", "merged"),
    [
        ((0, 1, 2, 20, 21, 39), [0, 1, 2, 3]),  # parts
        ((0, 1, 2, 3, 17), [0, 1, 2, 3, 17]),  # one id each
        ((0, 1, 2, 12, 21), [0, 1, 2, 12, 21]),  # one id each, and many
    ],
)
def test_parts_of_an_object_are_merged_and_objects_are_not(
    tmp_path: Path, ids: tuple[int, ...], merged: list[int]
) -> None:
    cloud_of(tmp_path / "learn0.pcd", *ids)
    frame, _ = OSD(tmp_path).read("learn0")
    assert frame.label is not None
    assert frame.label.unique().tolist() == merged


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_an_annotation_counts_instead_of_the_label_field(tmp_path: Path, kind: type) -> None:
    cloud_of(tmp_path / "pcd" / "test1.pcd", 0, 1, 2, 3)
    annotate(tmp_path / "annotation" / "test1.png", (np.indices(SIZE)[0] // 7).astype(kind))
    frame, truth = OSD(tmp_path).read("test1")
    np.testing.assert_array_equal(frame.label, np.indices(SIZE)[0] // 7 + 1)
    assert [o.id for o in truth.objects] == [2, 3]


@pytest.mark.parametrize(
    ("ids", "fault"),
    [
        (np.zeros((20, 29), np.uint8), "must have the 30 x 20 pixels"),
        (np.full(SIZE, 65535, np.uint16), "ids must be below 65535"),
        (np.zeros((*SIZE, 3), np.uint8), "one channel of 8 or 16 bits"),
    ],
)
def test_an_annotation_that_does_not_fit_is_refused(tmp_path: Path, ids: np.ndarray, fault: str) -> None:
    cloud_of(tmp_path / "pcd" / "test1.pcd", 1, 2)
    annotate(tmp_path / "annotation" / "test1.png", ids)
    with pytest.raises(FrameError, match=fault) as caught:
        OSD(tmp_path).read("test1")
    assert str(caught.value).startswith(str(tmp_path / "annotation" / "test1.png"))


def test_a_cloud_with_neither_labels_nor_annotation_is_refused(tmp_path: Path) -> None:
    plain = table_of(seen(np.ones(SIZE), CAMERA), np.zeros((*SIZE, 3), np.uint8), np.zeros(SIZE, np.int64))
    write_cloud(tmp_path / "pcd" / "test1.pcd", plain, FIELDS="x y z rgb _")
    with pytest.raises(FrameError, match=r"must have a field label.*annotation/test1\.png"):
        OSD(tmp_path).read("test1")


@pytest.mark.parametrize("file", ["pcd/a.pcd", "annotation/a.png"])
def test_a_link_out_of_the_root_is_refused(tmp_path: Path, file: str) -> None:
    root = tmp_path / "root"
    cloud_of(root / "pcd" / "a.pcd", 1, 2)
    annotate(root / "annotation" / "a.png", np.zeros(SIZE, np.uint8))
    (root / file).rename(tmp_path / "out")
    (root / file).symlink_to(tmp_path / "out")
    with pytest.raises(FrameError, match="links out of it"):
        OSD(root).read("a")


def test_the_split_is_told_by_the_names(tmp_path: Path) -> None:
    for folder, name in (("learn", "learn0"), ("learn", "learn1"), ("test", "test0")):
        cloud_of(tmp_path / folder / f"{name}.pcd", 1, 2)
    assert OSD(tmp_path).official() == {"train": ["learn0", "learn1"], "test": ["test0"]}
    cloud_of(tmp_path / "mine.pcd", 1, 2)
    assert OSD(tmp_path).official() == {}


def test_no_clouds_or_two_of_one_name_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="holds 0 with 0 names"):
        OSD(tmp_path).scenes()
    for folder in ("learn", "pcd"):
        cloud_of(tmp_path / folder / "a.pcd", 1, 2)
    with pytest.raises(ValueError, match="holds 2 with 1 names"):
        OSD(tmp_path).scenes()


@pytest.mark.parametrize("file", ["pcd/a.pcd", "annotation/a.png"])
def test_the_stamp_changes_with_every_file(tmp_path: Path, file: str) -> None:
    cloud_of(tmp_path / "pcd" / "a.pcd", 1, 2)
    annotate(tmp_path / "annotation" / "a.png", np.zeros(SIZE, np.uint8))
    before = OSD(tmp_path).stamp("a")
    assert OSD(tmp_path).stamp("a") == before
    (tmp_path / file).write_bytes(b"other")
    assert OSD(tmp_path).stamp("a") != before
