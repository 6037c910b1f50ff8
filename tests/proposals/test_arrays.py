"""Masks from an .npz file, whole and damaged."""

from __future__ import annotations

import struct
import tracemalloc
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from blockstab.proposals.arrays import stored_masks
from blockstab.proposals.masks import Mask
from blockstab.rgbd.reading import FrameError
from tests.proposals.mask_files import SMALL, nested, write_arrays

MASKS = np.stack(nested())


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "masks.npz"


def read(path: Path, **arrays: NDArray[Any]) -> list[Mask]:
    np.savez(path, **arrays)
    return list(stored_masks(path, *SMALL))


def member(shape: str, descr: str = "|b1", data: bytes = b"", order: str = "False") -> bytes:
    """An .npy file that says what it likes."""
    header = f"{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}\n".encode()
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header + data


def zipped(path: Path, members: dict[str, bytes], compression: int = zipfile.ZIP_DEFLATED) -> list[Mask]:
    with zipfile.ZipFile(path, "w", compression) as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return list(stored_masks(path, *SMALL))


@pytest.mark.parametrize("kind", ["bool", "uint8", "int8"])
def test_masks_come_back(path: Path, kind: str) -> None:
    masks = read(path, masks=MASKS.astype(kind))
    assert [(mask.number, mask.score) for mask in masks] == [(1, None), (2, None), (3, None)]
    assert np.array_equal(np.stack([mask.inside for mask in masks]), MASKS)


@pytest.mark.parametrize("value", [255, 1])
def test_all_that_is_not_0_is_inside(path: Path, value: int) -> None:
    masks = read(path, masks=MASKS.astype(np.uint8) * np.uint8(value))
    assert np.array_equal(masks[0].inside, MASKS[0])


@pytest.mark.parametrize("name", ["scores", "predicted_iou"])
def test_scores_come_in_the_order_of_the_masks(path: Path, name: str) -> None:
    write_arrays(path, nested(), (0.5, 0.25, 0.75), name)
    assert [mask.score for mask in stored_masks(path, *SMALL)] == [0.5, 0.25, 0.75]


@pytest.mark.parametrize("kind", ["float16", "float64", ">f4"])
def test_scores_may_be_any_floats(path: Path, kind: str) -> None:
    masks = read(path, masks=MASKS, scores=np.array([0.5, 0.25, 0.75], dtype=kind))
    assert [mask.score for mask in masks] == [0.5, 0.25, 0.75]


def test_other_arrays_are_not_looked_at(path: Path) -> None:
    assert len(read(path, masks=MASKS, boxes=np.zeros((3, 4)), bbox=np.array([None]))) == 3


def test_there_may_be_no_masks(path: Path) -> None:
    assert read(path, masks=MASKS[:0]) == []


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"arr_0": MASKS}, r"must hold one array masks, but holds \['arr_0.npy'\]"),
        ({"masks": MASKS.astype(float)}, "masks must be masks x 30 x 40 bool"),
        ({"masks": np.array([None])}, "masks must be masks x 30 x 40 bool"),
        ({"masks": np.asfortranarray(MASKS)}, "row by row"),
        ({"masks": MASKS[:, :20]}, "must be N x 30 x 40, as the image is, but are 3 x 20 x 40"),
        ({"masks": MASKS[:, None]}, "but are 3 x 1 x 30 x 40"),
        ({"masks": MASKS, "scores": np.zeros(2)}, r"one for each of the 3 masks, but their shape is \(2,\)"),
        ({"masks": MASKS, "scores": np.array([0, np.nan, 0])}, "must be finite, but one is nan"),
        ({"masks": MASKS, "scores": np.zeros(3, dtype=int)}, "scores must be floats"),
    ],
)
def test_arrays_that_are_no_masks_are_refused(
    path: Path, arrays: dict[str, NDArray[Any]], message: str
) -> None:
    with pytest.raises(FrameError, match=rf"masks\.npz: {message}|masks\.npz: .*{message}"):
        read(path, **arrays)


@pytest.mark.parametrize(
    "shape", ["(4096, 30, 40)", "(3, 30, 41)", "(999999999, 999999999, 30, 40)", "(1 2, 30, 40)"]
)
def test_a_header_must_declare_what_there_is(path: Path, shape: str) -> None:
    with pytest.raises(FrameError, match=r"must take|cannot be read"):
        zipped(path, {"masks.npy": member(shape, data=bytes(3 * 1200))})


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\x93NUMPY",
        b"\x93NUMPY\x01\x00\xff\xff",
        member("(3, 30, 40)", data=bytes(3600)).replace(b"\x01\x00", b"\x02\x00", 1),
        member("__import__('os')", data=bytes(3600)),
        member("(3, 30, 40)", "|O8", data=bytes(3600)),
        member("(3, 30, 40)", order="True", data=bytes(3600)),
    ],
)
def test_what_is_no_array_is_refused(path: Path, data: bytes) -> None:
    with pytest.raises(FrameError, match="masks must be masks x 30 x 40 bool, row by row"):
        zipped(path, {"masks.npy": data})


def test_a_bomb_takes_no_memory(path: Path) -> None:
    # 48 MB of zeros, in 48 kB, that agree with their header.
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("masks.npy", "w") as file:
        file.write(member("(40000, 30, 40)"))
        for _ in range(48):
            file.write(bytes(10**6))
    tracemalloc.start()
    with pytest.raises(FrameError, match="at most 4096 masks"):
        list(stored_masks(path, *SMALL))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 4 * 10**6


def test_masks_are_read_one_by_one(path: Path) -> None:
    np.savez_compressed(path, masks=np.zeros((200, 300, 400), dtype=bool))
    tracemalloc.start()
    for _ in stored_masks(path, 300, 400):
        pass
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 12 * 300 * 400  # of 200


@pytest.mark.parametrize("cut", [0, 10, 100, 300, -1, -22, -60])
def test_a_file_that_is_cut_is_refused(path: Path, cut: int) -> None:
    np.savez_compressed(path, masks=MASKS, scores=np.ones(3))
    path.write_bytes(path.read_bytes()[:cut])
    with pytest.raises(FrameError, match=r"masks\.npz: must be a whole \.npz file"):
        list(stored_masks(path, *SMALL))


def test_a_changed_pixel_is_seen(path: Path) -> None:
    np.savez(path, masks=MASKS)
    data = bytearray(path.read_bytes())
    data[data.index(b"\n", 60) + 1800] ^= 1
    path.write_bytes(data)
    with pytest.raises(FrameError, match="Bad CRC"):
        list(stored_masks(path, *SMALL))


def test_the_list_of_members_must_be_short(path: Path) -> None:
    names = {f"{number}.npy": b"" for number in range(2000)}
    with pytest.raises(FrameError, match="too many members"):
        zipped(path, {"masks.npy": member("(0, 30, 40)"), **names})


def test_a_longer_list_behind_the_short_one_is_not_believed(path: Path) -> None:
    zipped(path, {"masks.npy": member("(0, 30, 40)")})
    data = path.read_bytes()
    locator = b"PK\x06\x07" + bytes(16)
    path.write_bytes(data[:-22] + locator + data[-22:])
    with pytest.raises(FrameError, match="too many members"):
        list(stored_masks(path, *SMALL))


def test_a_compression_of_another_kind_is_refused(path: Path) -> None:
    with pytest.raises(FrameError, match="compressed in a way"):
        zipped(path, {"masks.npy": member("(0, 30, 40)")}, zipfile.ZIP_BZIP2)


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_two_arrays_of_one_name_are_refused(path: Path) -> None:
    with zipfile.ZipFile(path, "w") as archive:
        for _ in range(2):
            archive.writestr("masks.npy", member("(0, 30, 40)"))
    with pytest.raises(FrameError, match="must hold one array masks"):
        list(stored_masks(path, *SMALL))


def test_a_missing_file_is_named(path: Path) -> None:
    with pytest.raises(FrameError, match=r"masks\.npz: must be a whole \.npz file"):
        list(stored_masks(path, *SMALL))
