"""MATLAB files of version 5, beside SciPy's reader."""

from __future__ import annotations

import dataclasses
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
import scipy.io

from blockstab.datasets.formats.matlab import read_matlab
from blockstab.rgbd.reading import FrameError


def cell(*values: object) -> np.ndarray:
    made = np.empty((len(values), 1), dtype=object)
    for i, value in enumerate(values):
        made[i, 0] = np.asarray(value)
    return made


@pytest.fixture(params=[True, False], ids=["compressed", "plain"])
def file(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    values = {
        f"n{kind}": np.arange(6).reshape(2, 3).astype(kind) for kind in ("u1", "i2", "u4", "f4", "f8", "i8")
    }
    values |= {"one": 7.5, "none": np.zeros((0, 3)), "word": "floor", "complex": np.array([1 + 2j])}
    values["cells"] = cell([[1, 2, 1], [3, -1, 2]], np.zeros((0, 3)), 4.0)
    scipy.io.savemat(tmp_path / "a.mat", values, do_compression=request.param)
    return tmp_path / "a.mat"


def test_numbers_are_those_that_scipy_reads(file: Path) -> None:
    ours, theirs = read_matlab(file), scipy.io.loadmat(file)
    assert set(ours) == {name for name in theirs if not name.startswith("__")}
    for name in ("nu1", "ni2", "nu4", "nf4", "nf8", "ni8", "one", "none"):
        assert ours[name].shape == theirs[name].shape
        np.testing.assert_array_equal(ours[name].numbers(), theirs[name].astype(float))


def test_cells_are_those_that_scipy_reads(file: Path) -> None:
    ours, theirs = read_matlab(file)["cells"].cells(), scipy.io.loadmat(file)["cells"]
    assert len(ours) == theirs.size == 3
    for mine, other in zip(ours, theirs[:, 0], strict=True):
        np.testing.assert_array_equal(mine.numbers(), other.astype(float))


@pytest.mark.parametrize("name", ["word", "complex", "cells"])
def test_what_holds_no_real_numbers_says_so(file: Path, name: str) -> None:
    with pytest.raises(FrameError, match=rf"a\.mat: '{name}' must hold real numbers"):
        read_matlab(file)[name].numbers()


def test_numbers_are_no_cells(file: Path) -> None:
    with pytest.raises(FrameError, match="'one' must be a cell array"):
        read_matlab(file)["one"].cells()


def test_a_name_of_bytes_that_are_no_letters_is_told_in_letters(file: Path) -> None:
    damaged = dataclasses.replace(read_matlab(file)["one"], name="\t\0\n\ufffd" * 50)
    with pytest.raises(FrameError, match="must be a cell array") as caught:
        damaged.cells()
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < len(str(file)) + 150


@pytest.mark.parametrize("content", [b"", b"MATLAB 7.3", bytes(200), b"\x89HDF" + bytes(300)])
def test_another_file_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "b.mat").write_bytes(content)
    with pytest.raises(FrameError, match=r"b\.mat: must be a MATLAB file of version 5"):
        read_matlab(tmp_path / "b.mat")


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(FrameError, match=r"c\.mat: must be a MATLAB file"):
        read_matlab(tmp_path / "c.mat")


@pytest.mark.parametrize("cut", [1, 9, 60])
def test_a_truncated_file_is_one_line(file: Path, cut: int) -> None:
    file.write_bytes(file.read_bytes()[:-cut])
    with pytest.raises(FrameError, match=r"a\.mat: .*; copy (it|the file) again\."):
        [matrix.numbers() for matrix in read_matlab(file).values()]


def test_what_inflates_without_end_is_refused(tmp_path: Path) -> None:
    packed = zlib.compress(struct.pack("<II", 14, 2**30) + bytes(2**26))
    head = b"MATLAB 5.0".ljust(124) + b"\x00\x01IM"
    (tmp_path / "d.mat").write_bytes(head + struct.pack("<II", 15, len(packed)) + packed)
    with pytest.raises(FrameError, match="must have less than"):
        read_matlab(tmp_path / "d.mat")
