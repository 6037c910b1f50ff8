"""Organised point clouds."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from blockstab.datasets.formats.pcd import read_cloud
from blockstab.rgbd.frame import Camera
from blockstab.rgbd.reading import FrameError
from tests.datasets.pcd_files import POINT, body_of, header_of, seen, table_of, write_cloud

FORMATS = ("ascii", "binary", "binary_compressed")
HEIGHT, WIDTH = 6, 8


def some_table(height: int = HEIGHT, width: int = WIDTH) -> NDArray[np.void]:
    """Points, colours and labels of no pattern; the first point is missing."""
    draw = np.random.default_rng(3)
    depth = draw.uniform(0.5, 2, (height, width))
    depth[0, 0] = 0
    color = draw.integers(0, 256, (height, width, 3), dtype=np.uint8)
    points = seen(depth, Camera(500, 500, width / 2, height / 2))
    return table_of(points, color, draw.integers(0, 9, (height, width)))


def refusal(path: Path) -> str:
    """What a file is refused with."""
    with pytest.raises(FrameError) as caught:
        read_cloud(path)
    message = str(caught.value)
    assert message.startswith(str(path))
    assert "\n" not in message
    return message


@pytest.mark.parametrize("data", FORMATS)
def test_every_format_gives_the_points_colours_and_labels_that_were_written(
    tmp_path: Path, data: str
) -> None:
    table = some_table()
    cloud = read_cloud(write_cloud(tmp_path / "a.pcd", table, data))
    for axis, name in enumerate("xyz"):
        tolerance = 1e-8 if data == "ascii" else 0
        np.testing.assert_allclose(cloud.points[..., axis], table[name], rtol=tolerance, atol=0)
    packed = cloud.color.astype(np.uint32) @ np.array([1 << 16, 1 << 8, 1], np.uint32)
    np.testing.assert_array_equal(packed, table["rgb"])
    np.testing.assert_array_equal(cloud.label, table["label"])


@pytest.mark.parametrize("data", FORMATS)
@pytest.mark.parametrize("label", ["u1", "u2", "u4"])
def test_other_fields_are_skipped_and_small_labels_are_read(tmp_path: Path, data: str, label: str) -> None:
    kinds = {"x": "<f8", "label": f"<{label}"}
    order = ("_", "label", "x", "normal", "y", "z", "rgb")
    layout = [("_", "u1"), ("normal", "<f4", 3), *POINT]
    table = some_table()
    wide = np.ones(table.shape, [(n, kinds.get(n, k), *s) for o in order for n, k, *s in layout if n == o])
    for name, _ in POINT:
        wide[name] = table[name]
    cloud = read_cloud(write_cloud(tmp_path / "a.pcd", wide, data))
    np.testing.assert_array_equal(cloud.label, table["label"])
    np.testing.assert_allclose(cloud.points[..., 2], table["z"], rtol=1e-7)


@pytest.mark.parametrize("data", FORMATS)
def test_a_colour_stored_as_a_float_is_the_same_colour(tmp_path: Path, data: str) -> None:
    table = some_table()
    as_float = table.astype([(name, "<f4" if name == "rgb" else kind) for name, kind in POINT])
    as_float["rgb"] = table["rgb"].view("<f4")
    expected = read_cloud(write_cloud(tmp_path / "a.pcd", table)).color
    np.testing.assert_array_equal(read_cloud(write_cloud(tmp_path / "b.pcd", as_float, data)).color, expected)


def test_an_ascii_colour_of_type_f_may_be_an_integer(tmp_path: Path) -> None:
    table = some_table()
    file = write_cloud(tmp_path / "a.pcd", table, "ascii", TYPE="F F F F U")
    packed = read_cloud(file).color.astype(np.uint32) @ np.array([1 << 16, 1 << 8, 1], np.uint32)
    np.testing.assert_array_equal(packed, table["rgb"])


def test_a_point_at_depth_zero_or_with_one_infinite_coordinate_is_missing(tmp_path: Path) -> None:
    table = some_table()
    table["z"][2, 3], table["x"][4, 5] = 0, np.inf
    missing = np.isnan(read_cloud(write_cloud(tmp_path / "a.pcd", table)).points)
    assert np.argwhere(missing.all(axis=-1)).tolist() == [[0, 0], [2, 3], [4, 5]]
    assert missing.sum() == 9


@pytest.mark.filterwarnings("error")
def test_a_nan_of_any_bits_is_a_missing_point_and_no_warning(tmp_path: Path) -> None:
    table = some_table()
    table["x"].view("<u4")[2, 3] = 0x7F800001  # one that signals
    assert np.isnan(read_cloud(write_cloud(tmp_path / "a.pcd", table)).points[2, 3]).all()


def test_a_cloud_without_labels_has_none(tmp_path: Path) -> None:
    table = some_table()[["x", "y", "z", "rgb"]].astype(POINT[:4])
    assert read_cloud(write_cloud(tmp_path / "a.pcd", table)).label is None


@pytest.mark.parametrize(
    "options", [{}, {"write_ascii": True}, {"compressed": True}], ids=FORMATS[1:2] + FORMATS[::2]
)
def test_what_open3d_writes_is_read(tmp_path: Path, options: dict[str, bool]) -> None:
    o3d = pytest.importorskip("open3d")
    table, path = some_table(), tmp_path / "a.pcd"
    table["x"][1:4] = 0.25  # so that there is something to compress
    points = np.stack([table[n] for n in "xyz"], axis=-1).reshape(-1, 3)
    color = read_cloud(write_cloud(tmp_path / "b.pcd", table)).color
    cloud = o3d.t.geometry.PointCloud(o3d.core.Tensor(points))
    cloud.point.colors = o3d.core.Tensor(color.reshape(-1, 3).copy())
    cloud.point.label = o3d.core.Tensor(table["label"].astype(np.uint8).reshape(-1, 1))
    assert o3d.t.io.write_point_cloud(str(path), cloud, **options)
    # It writes every cloud as one row.
    rows = path.read_bytes().replace(b"WIDTH 48\nHEIGHT 1\n", b"WIDTH 8\nHEIGHT 6\n")
    path.write_bytes(rows)
    found = read_cloud(path)
    np.testing.assert_allclose(found.points.reshape(-1, 3)[1:], points[1:], rtol=1e-6)
    assert np.isnan(found.points[0, 0]).all()
    np.testing.assert_array_equal(found.color, color)
    np.testing.assert_array_equal(found.label, table["label"])


@pytest.mark.parametrize("data", FORMATS)
def test_open3d_reads_what_the_tests_write(tmp_path: Path, data: str) -> None:
    o3d = pytest.importorskip("open3d")
    path = write_cloud(tmp_path / "a.pcd", some_table(), data)
    other, found = o3d.t.io.read_point_cloud(str(path)), read_cloud(path)
    np.testing.assert_allclose(other.point.positions.numpy(), found.points.reshape(-1, 3), rtol=1e-6)
    np.testing.assert_array_equal(other.point.colors.numpy(), found.color.reshape(-1, 3))
    np.testing.assert_array_equal(other.point.label.numpy().ravel(), found.label.ravel())


@pytest.mark.parametrize(
    ("changed", "fault"),
    [
        ({"HEIGHT": 1, "WIDTH": 48}, "no rows and columns"),
        ({"POINTS": 47}, "not WIDTH times HEIGHT"),
        ({"WIDTH": 80000, "HEIGHT": 80000, "POINTS": 6400000000}, "whole number"),
        ({"WIDTH": 8001, "HEIGHT": 8000, "POINTS": 64008000}, "over 64 million"),
        ({"WIDTH": 8000, "HEIGHT": 8000, "POINTS": 64000000}, "bytes follow"),
        ({"WIDTH": "-8"}, "WIDTH is not 1 whole number"),
        ({"WIDTH": None}, "WIDTH is not 1 whole number"),
        ({"FIELDS": "x y z intensity label"}, "rgb or rgba"),
        ({"FIELDS": "x y z rgb x"}, "field x is not one value of type F4 or F8"),
        ({"FIELDS": "x y z rgb rgb"}, "once each"),
        ({"FIELDS": "x y z rgb"}, "not as many"),
        ({"TYPE": "F F F U I"}, "field label"),
        ({"TYPE": "F F F U Q"}, "field 5 has no known TYPE"),
        ({"SIZE": "4 4 4 4 3"}, "field 5 has no known TYPE"),
        ({"COUNT": "1 1 1 1 2"}, "field label"),
        ({"FIELDS": "x y z rgb _", "COUNT": "1 1 1 1 99999999"}, "over 2 GB"),
        ({"DATA": "binary_zipped"}, "neither ascii nor binary"),
        ({"VIEWPOINT": "0 " * 5000}, "no line DATA"),
    ],
)
def test_a_header_that_cannot_be_is_refused(tmp_path: Path, changed: dict[str, object], fault: str) -> None:
    assert fault in refusal(write_cloud(tmp_path / "a.pcd", some_table(), "binary", **changed))


@pytest.mark.parametrize("data", FORMATS)
def test_a_cut_file_is_refused(tmp_path: Path, data: str) -> None:
    path = write_cloud(tmp_path / "a.pcd", some_table(), data)
    path.write_bytes(path.read_bytes()[:-20])
    assert "must be an organised .pcd cloud" in refusal(path)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    assert "cannot be opened" in refusal(tmp_path / "none.pcd")


def test_a_small_file_that_says_it_unpacks_to_gigabytes_is_refused(tmp_path: Path) -> None:
    path, table = tmp_path / "a.pcd", some_table()
    header = header_of(table, "binary_compressed", WIDTH=8000, HEIGHT=8000, POINTS=64000000)
    size = (64000000 * 20).to_bytes(4, "little")
    path.write_bytes(header + (1000).to_bytes(4, "little") + size + bytes(1000))
    assert "that become 1280000000" in refusal(path)


def test_data_that_grew_by_more_than_half_is_refused(tmp_path: Path) -> None:
    path, table = tmp_path / "a.pcd", some_table()
    whole = body_of(table, "binary")
    packed = b"".join(bytes([0, byte]) for byte in whole)  # every byte a run of its own
    sizes = len(packed).to_bytes(4, "little") + len(whole).to_bytes(4, "little")
    path.write_bytes(header_of(table, "binary_compressed") + sizes + packed)
    assert f"{len(packed)} bytes that become {len(whole)}" in refusal(path)


@pytest.mark.parametrize("data", ["binary", "binary_compressed"])
def test_a_cloud_of_a_depth_camera_is_read_within_two_seconds(tmp_path: Path, data: str) -> None:
    path = write_cloud(tmp_path / "a.pcd", some_table(480, 640), data)
    start = time.perf_counter()
    read_cloud(path)
    assert time.perf_counter() - start < 2


@pytest.mark.parametrize("data", FORMATS)
def test_no_damage_brings_out_another_error(tmp_path: Path, data: str) -> None:
    draw, path = np.random.default_rng(11), tmp_path / "a.pcd"
    header, whole = header_of(some_table(), data), header_of(some_table(), data) + body_of(some_table(), data)
    messages = []
    for _ in range(200):
        path.write_bytes(damaged(whole, len(header), draw))
        try:
            read_cloud(path)
        except FrameError as error:
            messages.append(str(error))
    assert len(messages) > 50
    assert not any("\n" in message for message in messages)


def damaged(whole: bytes, header: int, draw: np.random.Generator) -> bytes:
    """With some bytes flipped, in the header or anywhere; a piece of it cut out; or a number replaced."""
    spoilt, way = bytearray(whole), draw.integers(4)
    if way < 2:
        for place in draw.integers(header if way else len(whole), size=draw.integers(1, 6)):
            spoilt[place] ^= 1 << draw.integers(8)
    elif way == 2:
        start, end = sorted(draw.integers(len(whole) + 1, size=2))
        del spoilt[start:end]
    else:
        digits = [place for place in range(header) if chr(whole[place]).isdigit()]
        place = draw.choice(digits)
        spoilt[place : place + 1] = draw.choice(
            [b"0", b"7", b"-1", b"99999999", b"9" * 500, b"1e9", b"nan", b""]
        )
    return bytes(spoilt)
