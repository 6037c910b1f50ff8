"""Organised clouds as frames."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from blockstab.datasets.organised import inside, read_frame, truth_of
from blockstab.rgbd.frame import Camera
from blockstab.rgbd.reading import FrameError
from tests.datasets.pcd_files import seen, table_of, write_cloud

CAMERA = Camera(40.0, 42.0, 15.5, 9.0)
DEPTH = 1.0 + np.random.default_rng(5).uniform(0, 0.5, (20, 30))


def cloud_at(path: Path, points: NDArray[np.float64], label: int = 1) -> Path:
    """A cloud of one colour and one label."""
    shape = points.shape[:2]
    return write_cloud(
        path / "a.pcd", table_of(points, np.zeros((*shape, 3), np.uint8), np.full(shape, label))
    )


def test_the_camera_is_found_and_the_depth_kept(tmp_path: Path) -> None:
    depth = DEPTH.copy()
    depth[3:9, :7] = 0
    frame = read_frame(cloud_at(tmp_path, seen(depth, CAMERA)), "a")
    assert frame.camera.intrinsics == pytest.approx(CAMERA.intrinsics, abs=1e-4)
    np.testing.assert_array_equal(frame.depth, depth.astype(np.float32))


def test_a_point_may_be_off_by_no_more_than_a_pixel(tmp_path: Path) -> None:
    points = seen(DEPTH, CAMERA)
    aside = points[4, 4, 2] / CAMERA.fx  # what a pixel is wide there
    points[4, 4, 0] += 0.9 * aside
    read_frame(cloud_at(tmp_path, points), "a")
    points[4, 4, 0] += 0.3 * aside
    with pytest.raises(FrameError, match=r"misses one by 1\.2"):
        read_frame(cloud_at(tmp_path, points), "a")


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        (lambda p: p * np.nan, "points in front of the camera"),
        (lambda p: p * [1, 1, -1], "points in front of the camera"),
        (lambda p: p * 1e-4, "points in front of the camera"),
        (lambda p: p * 1000, "points in front of the camera"),
        (lambda p: p * [-1, 1, 1], "one pinhole camera"),
        (lambda p: p[:, ::-1], "one pinhole camera"),
        (lambda p: np.add(p, [0, 0, 0.5]), "one pinhole camera"),
        (lambda p: np.where(np.indices((20, 30))[1][..., None] == 4, p, np.nan), "one pinhole camera"),
        (lambda p: p * 0.05, "median depth"),
    ],
)
def test_a_cloud_that_is_no_view_of_a_camera_is_refused(tmp_path: Path, change, fault: str) -> None:  # type: ignore[no-untyped-def]
    path = cloud_at(tmp_path, change(seen(DEPTH, CAMERA)))
    with pytest.raises(FrameError, match=fault) as caught:
        read_frame(path, "a")
    assert str(caught.value).startswith(str(path))


def test_a_label_fits_a_label_image(tmp_path: Path) -> None:
    points = seen(DEPTH, CAMERA)
    label = read_frame(cloud_at(tmp_path, points, 65535), "a").label
    assert label is not None
    assert bool((label == 65535).all())
    with pytest.raises(FrameError, match="at most 65535"):
        read_frame(cloud_at(tmp_path, points, 65536), "a")


def test_every_id_but_zero_and_background_is_an_object() -> None:
    truth = truth_of(torch.tensor([[0, 1, 5], [3, 3, 2]]), (1, 2))
    assert [o.id for o in truth.objects] == [3, 5]
    assert truth.background_ids == (1, 2)
    assert not truth.support_annotated


def test_only_links_that_stay_in_the_root_are_followed(tmp_path: Path) -> None:
    root = tmp_path / "root"
    root.mkdir()
    (tmp_path / "out").touch()
    for name, target in {"in": root / "file", "away": tmp_path / "out", "loop": root / "loop"}.items():
        (root / name).symlink_to(target)
    assert inside(root / "in", root) == root / "in"
    for name in ("away", "loop", "../out"):
        with pytest.raises(FrameError, match="links out of it"):
            inside(root / name, root)
