"""The Object Clutter Indoor Dataset."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from blockstab.datasets.ocid import OCID
from blockstab.rgbd.frame import Camera
from blockstab.rgbd.reading import FrameError
from tests.datasets.pcd_files import seen, table_of, write_cloud

SIZE = (480, 640)
LABEL = np.indices(SIZE)[1] // 160  # four stripes, 0 to 3
DEPTH = np.full(SIZE, 1234, np.uint16)
COLOR = np.full((*SIZE, 3), (200, 30, 7), np.uint8)
FLOOR = "ARID20/floor/bottom/seq01"
TABLE = "YCB10/table/top/mixed/seq07"
NAMES = ["ARID20-floor-bottom-seq01-2018-a", "YCB10-table-top-mixed-seq07-2018-b"]


def images_at(sequence: Path, stem: str) -> None:
    """The three images of a view."""
    for kind, image in {"rgb": COLOR, "depth": DEPTH, "label": LABEL.astype(np.uint16)}.items():
        (sequence / kind).mkdir(parents=True, exist_ok=True)
        Image.fromarray(image).save(sequence / kind / f"{stem}.png", compress_level=1)


def cloud_at(sequence: Path, stem: str) -> None:
    """A cloud of 30 x 20 points, labelled as the images are."""
    points = seen(np.full((20, 30), 0.9), Camera(50, 50, 14.5, 9.5))
    table = table_of(points, np.zeros((20, 30, 3), np.uint8), LABEL[::24, :][:, ::22][:20, :30])
    write_cloud(sequence / "pcd" / f"{stem}.pcd", table)


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """A view on the floor and one on the table; the second one's images are not there."""
    images_at(tmp_path / FLOOR, "2018-a")
    cloud_at(tmp_path / TABLE, "2018-b")
    return tmp_path


def test_views_are_named_by_their_folders(root: Path) -> None:
    assert OCID(root).scenes() == NAMES
    assert OCID(root / "YCB10" / "table").scenes() == ["top-mixed-seq07-2018-b"]


def test_a_view_is_read_from_its_images(root: Path) -> None:
    cloud_at(root / FLOOR, "2018-a")
    frame, _ = OCID(root).read(NAMES[0])
    assert frame.name == NAMES[0]
    assert frame.camera == Camera(570.34, 570.34, 319.5, 239.5)
    np.testing.assert_allclose(frame.depth, 1.234)
    np.testing.assert_array_equal(frame.color, COLOR)
    np.testing.assert_array_equal(frame.label, LABEL)


def test_a_view_without_all_images_is_read_from_its_cloud(root: Path) -> None:
    assert OCID(root).read(NAMES[1])[0].depth.shape == (20, 30)
    cloud_at(root / FLOOR, "2018-a")
    (root / FLOOR / "label" / "2018-a.png").unlink()
    assert OCID(root).read(NAMES[0])[0].depth.shape == (20, 30)


def test_the_table_is_background_where_there_is_one(root: Path) -> None:
    for name, background, objects in ((NAMES[0], (1,), [2, 3]), (NAMES[1], (1, 2), [3])):
        frame, truth = OCID(root).read(name)
        assert frame.background_ids == truth.background_ids == background
        assert [o.id for o in truth.objects] == objects
    # The folder that says so may lie above the root.
    assert OCID(root / "YCB10" / "table" / "top").read("mixed-seq07-2018-b")[1].background_ids == (1, 2)


def test_a_view_neither_on_floor_nor_table_is_refused(tmp_path: Path) -> None:
    cloud_at(tmp_path / "seq01", "a")
    with pytest.raises(FrameError, match="under a folder floor or table"):
        OCID(tmp_path).read("seq01-a")


@pytest.mark.parametrize(
    ("kind", "image", "fault"),
    [
        ("depth", DEPTH[:240], "must have the 640 x 480 pixels"),
        ("rgb", COLOR[:240], "must have the 640 x 480 pixels"),
        ("label", LABEL[:240].astype(np.uint8), "must have the 640 x 480 pixels"),
        ("label", COLOR, "one channel of 8 or 16 bits"),
        ("depth", DEPTH // 1000, "median depth"),
    ],
)
def test_an_image_that_does_not_fit_is_refused(root: Path, kind: str, image: np.ndarray, fault: str) -> None:
    Image.fromarray(image).save(root / FLOOR / kind / "2018-a.png")
    with pytest.raises(FrameError, match=fault) as caught:
        OCID(root).read(NAMES[0])
    assert f"{kind}/2018-a.png" in str(caught.value)


def test_a_cloud_without_labels_is_refused(root: Path) -> None:
    cloud = root / TABLE / "pcd" / "2018-b.pcd"
    cloud.write_bytes(cloud.read_bytes().replace(b"rgb label", b"rgb other"))
    with pytest.raises(FrameError, match=r"must have a field label.*label/2018-b\.png"):
        OCID(root).read(NAMES[1])


@pytest.mark.parametrize("kind", ["rgb", "depth", "label"])
def test_a_file_that_links_out_of_the_root_is_refused(root: Path, kind: str, tmp_path_factory) -> None:  # type: ignore[no-untyped-def]
    file, out = root / FLOOR / kind / "2018-a.png", tmp_path_factory.mktemp("out") / "a.png"
    file.rename(out)
    file.symlink_to(out)
    with pytest.raises(FrameError, match="links out of it"):
        OCID(root).read(NAMES[0])


def test_links_to_folders_are_not_followed(root: Path) -> None:
    (root / "again").symlink_to(root / "ARID20")
    (root / "loop").symlink_to(root)
    assert OCID(root).scenes() == NAMES


def test_folders_too_deep_for_the_set_are_not_searched(root: Path) -> None:
    cloud_at(root.joinpath(*"abcdefgh"), "near")
    cloud_at(root.joinpath(*"bcdefghij"), "far")
    assert OCID(root).scenes() == [*NAMES, "a-b-c-d-e-f-g-h-near"]


def test_no_view_two_of_one_name_or_an_unknown_one_are_refused(root: Path, tmp_path_factory) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ValueError, match="holds no sequence"):
        OCID(tmp_path_factory.mktemp("empty")).scenes()
    with pytest.raises(ValueError, match="holds no sequence"):
        OCID(root / "none").scenes()
    with pytest.raises(FrameError, match="holds no view other"):
        OCID(root).read("other")
    cloud_at(root / "ARID20" / "floor" / "bottom-seq01", "2018-a")
    with pytest.raises(ValueError, match=f"two views that would be called {NAMES[0]}"):
        OCID(root).scenes()


@pytest.mark.parametrize("kind", ["rgb", "depth", "label"])
def test_the_stamp_changes_with_every_image(root: Path, kind: str) -> None:
    data = OCID(root)
    before = data.stamp(NAMES[0])
    assert data.stamp(NAMES[0]) == before
    (root / FLOOR / kind / "2018-a.png").write_bytes(b"other")
    assert data.stamp(NAMES[0]) != before
