"""Organised point clouds in the .pcd format of the Point Cloud Library, version 0.7."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from blockstab.datasets.formats.lzf import HIGHEST_RATIO, decompress
from blockstab.datasets.formats.pcd_header import Field, Header, read_header
from blockstab.rgbd.reading import FrameError

_MOST_CHARACTERS = 32  # of a number in an ascii file, with the blank after it
_Columns = Mapping[str, NDArray[Any]]


@dataclass(frozen=True)
class OrganisedCloud:
    """A point and a colour for every pixel.

    Args:
        points: (H, W, 3) float64, metres; NaN where there is none.
        color: (H, W, 3) uint8, RGB.
        label: (H, W) int64 ids; None where the file has none.
    """

    points: NDArray[np.float64]
    color: NDArray[np.uint8]
    label: NDArray[np.int64] | None


def read_cloud(path: Path) -> OrganisedCloud:
    """Read an organised cloud, one with rows: ascii, binary or binary_compressed.

    It has the fields x, y, z; rgb or rgba, a colour packed into 4 bytes; and perhaps label, an unsigned
    integer of 1, 2 or 4 bytes. Others are skipped.

    Convention:
        A point is missing where a coordinate is not finite, or z is 0: the Point Cloud Library writes NaN,
        the first Object Segmentation Database 0.

    Raises:
        FrameError: the file is missing, damaged, not organised, over 64 megapixels or lacks a field.
    """
    readers = {"ascii": _ascii, "binary": _binary, "binary_compressed": _compressed}
    try:
        with path.open("rb") as file:
            header = read_header(file)
            columns = readers[header.data](file, header, path.stat().st_size - file.tell())
    except OSError as error:
        raise FrameError(
            f"{path}: must be a readable file, but cannot be opened ({error.strerror}); check the path."
        ) from error
    except ValueError as error:
        raise FrameError(
            f"{path}: must be an organised .pcd cloud, but {error}; copy or convert it again."
        ) from None
    return _cloud(columns, (header.height, header.width))


def _ascii(file: BinaryIO, header: Header, left: int) -> _Columns:
    points = header.width * header.height
    numbers = points * header.values
    if not 2 * numbers - 1 <= left <= _MOST_CHARACTERS * numbers:
        raise ValueError(f"{left} bytes follow its header, which cannot be {numbers} numbers")
    places = [field.values for field in header.fields]
    table = np.loadtxt(islice(file, points), usecols=places, ndmin=2, comments=None)
    if len(table) != points:
        raise ValueError(f"it does not have {points} lines of numbers")
    return {f.name: _from_text(table[:, i], f) for i, f in enumerate(header.fields)}


def _from_text(numbers: NDArray[np.float64], field: Field) -> NDArray[Any]:
    """The values of a field as they would be in a binary file."""
    if field.name in ("x", "y", "z"):
        return numbers
    unsigned = np.dtype(f"<u{np.dtype(field.dtype).itemsize}")
    whole = (numbers >= 0) & (numbers <= np.iinfo(unsigned).max) & (np.floor(numbers) == numbers)
    # Where its type is F, writers differ: some give the packed colour as an integer, some as the float of
    # the same bytes, and that is below 1.
    if field.dtype == "<f4" and not bool(whole.all()):
        with np.errstate(over="ignore"):
            return numbers.astype("<f4")
    if not bool(whole.all()):
        raise ValueError(f"its field {field.name} holds values out of its range")
    return numbers.astype(unsigned)


def _binary(file: BinaryIO, header: Header, left: int) -> _Columns:
    points = header.width * header.height
    if left < points * header.size:
        raise ValueError(f"{left} bytes follow its header, where {points * header.size} are needed")
    layout = np.dtype(
        {
            "names": [field.name for field in header.fields],
            "formats": [field.dtype for field in header.fields],
            "offsets": [field.size for field in header.fields],
            "itemsize": header.size,
        }
    )
    table = np.frombuffer(file.read(points * header.size), layout, points)
    return {field.name: table[field.name] for field in header.fields}


def _compressed(file: BinaryIO, header: Header, left: int) -> _Columns:
    """The fields lie one after the other: all x, then all y."""
    points, sizes = header.width * header.height, file.read(8)
    if len(sizes) < 8:
        raise ValueError("it ends before its compressed data")
    packed, size = struct.unpack("<II", sizes)
    # Full runs make data larger by a part in 32; what grows by more than half is built to take long.
    sane = size <= HIGHEST_RATIO * packed and packed <= size + size // 2 + 8
    if size != points * header.size or packed > left - 8 or not sane:
        raise ValueError(f"{packed} bytes that become {size} are not its {points} points and the rest of it")
    data = decompress(file.read(packed), size)
    return {f.name: np.frombuffer(data, f.dtype, points, f.size * points) for f in header.fields}


def _cloud(columns: _Columns, shape: tuple[int, int]) -> OrganisedCloud:
    with np.errstate(invalid="ignore"):  # a NaN of any bits is a missing point
        points = np.stack([columns[axis].astype(np.float64) for axis in ("x", "y", "z")], axis=-1)
    points[~np.isfinite(points).all(axis=1) | (points[:, 2] == 0)] = np.nan
    packed = columns["rgb"] if "rgb" in columns else columns["rgba"]
    # Its four bytes are blue, green, red and alpha.
    color = np.ascontiguousarray(packed).view(np.uint8).reshape(-1, 4)[:, 2::-1].copy()
    label = columns["label"].astype(np.int64).reshape(shape) if "label" in columns else None
    return OrganisedCloud(points.reshape(*shape, 3), color.reshape(*shape, 3), label)
