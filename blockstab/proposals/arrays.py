"""Masks from the arrays of an .npz file; the sizes that it declares are checked before memory is taken."""

from __future__ import annotations

import os
import re
import struct
import zipfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from math import prod
from pathlib import Path
from reprlib import repr as shown
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from blockstab.proposals.masks import Mask, check_count
from blockstab.rgbd.reading import FrameError

_SCORES = ("scores", "predicted_iou")
_MASK_KINDS = ("b1", "u1", "i1")
_SCORE_KINDS = ("f2", "f4", "f8")
_MAGIC = b"\x93NUMPY\x01\x00"
# What numpy writes; its own reader would evaluate the header as Python.
_HEADER = re.compile(
    r"\{'descr': '([<>|])(\w\d)', 'fortran_order': False, 'shape': \(([\d, ]{0,60})\), \}\s*"
)
_END, _END_BYTES, _LONGEST_COMMENT = b"PK\x05\x06", 22, 2**16
_END_64, _END_64_BYTES = b"PK\x06\x07", 20
_MOST_DIRECTORY = 2**16  # bytes
_DAMAGE = (OSError, EOFError, ValueError, RuntimeError, struct.error, zlib.error, zipfile.BadZipFile)


def stored_masks(path: Path, height: int, width: int) -> Iterator[Mask]:
    """The masks of one image, one by one.

    Args:
        path: .npz with `masks` (N, H, W), bool or whole numbers of one byte, 0 outside; and, where there are scores,
            floats `scores` or `predicted_iou` (N,). `numpy.savez` and `numpy.savez_compressed` write it.
        height, width: of the image.

    Raises:
        FrameError: the file is not that, or has not what it declares.
    """
    try:
        with path.open("rb") as file:
            _check_directory(file)
            with zipfile.ZipFile(file) as archive:
                yield from _masks(path, archive, height, width)
    except FrameError:
        raise
    except _DAMAGE as error:
        raise FrameError(
            f"{path}: must be a whole .npz file, but cannot be read ({str(error)[:100]}); copy it again."
        ) from error


def _check_directory(file: IO[bytes]) -> None:
    """See that the list of members is short: zipfile takes all of it into memory."""
    end = file.seek(0, os.SEEK_END)
    file.seek(max(0, end - _END_64_BYTES - _END_BYTES - _LONGEST_COMMENT))
    tail = file.read(_END_64_BYTES + _END_BYTES + _LONGEST_COMMENT)
    at = tail.rfind(_END)
    if at < 0 or len(tail) - at < _END_BYTES:
        raise zipfile.BadZipFile("it has no end")
    (size,) = struct.unpack_from("<I", tail, at + 12)
    if size > _MOST_DIRECTORY or _END_64 in tail[max(0, at - _END_64_BYTES) : at]:
        raise zipfile.BadZipFile("it has too many members")


def _masks(path: Path, archive: zipfile.ZipFile, height: int, width: int) -> Iterator[Mask]:
    masks = _array(path, archive, "masks", _MASK_KINDS, f"masks x {height} x {width} bool")
    if len(masks.shape) != 3 or masks.shape[1:] != (height, width):
        raise FrameError(
            f"{path}: masks must be N x {height} x {width}, as the image is, but are "
            f"{' x '.join(map(str, masks.shape))}; segment the same image, at its full size."
        )
    count = masks.shape[0]
    check_count(path, count, height, width)
    scores = _all_scores(path, archive, count)
    for number in range(1, count + 1):
        inside = masks.read(height * width).reshape(height, width) != 0
        yield Mask(number, inside, scores[number - 1])


def _all_scores(path: Path, archive: zipfile.ZipFile, count: int) -> list[float | None]:
    """The score of each mask; None where the file has none."""
    name = next((name for name in _SCORES if f"{name}.npy" in archive.namelist()), None)
    if name is None:
        return [None] * count
    array = _array(path, archive, name, _SCORE_KINDS, "floats, one for each mask")
    if array.shape != (count,):
        raise FrameError(
            f"{path}: {name} must be one for each of the {count} masks, but their shape is {array.shape}; "
            "store them in the order of the masks."
        )
    scores = array.read(count).astype(np.float64)
    if not np.isfinite(scores).all():
        raise FrameError(
            f"{path}: {name} must be finite, but one is {scores[~np.isfinite(scores)][0]}; correct it."
        )
    return [float(score) for score in scores]


@dataclass(frozen=True)
class _Array:
    """An array of the file, before its values are read."""

    stream: IO[bytes]
    kind: np.dtype[Any]
    shape: tuple[int, ...]

    def read(self, count: int) -> NDArray[Any]:
        """(count,) the next values."""
        data = self.stream.read(count * self.kind.itemsize)
        if len(data) != count * self.kind.itemsize:
            raise EOFError("it ends too early")
        return np.frombuffer(data, dtype=self.kind)


def _array(path: Path, archive: zipfile.ZipFile, name: str, kinds: tuple[str, ...], wanted: str) -> _Array:
    """Open an array of one of the kinds; its header and that of the archive must declare one size."""
    members = [info for info in archive.infolist() if info.filename == f"{name}.npy"]
    if len(members) != 1:
        came = shown(archive.namelist())
        raise FrameError(f"{path}: must hold one array {name}, but holds {came}; store {name} as {wanted}.")
    if members[0].compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise zipfile.BadZipFile("it is compressed in a way that numpy does not use")
    stream = archive.open(members[0])
    start = stream.read(len(_MAGIC) + 2)
    length = int.from_bytes(start[len(_MAGIC) :], "little")
    header = _HEADER.fullmatch(stream.read(length).decode("latin-1"))
    if not start.startswith(_MAGIC) or header is None or header[2] not in kinds:
        raise FrameError(f"{path}: {name} must be {wanted}, row by row, but is not; convert it with numpy.")
    kind, shape = np.dtype(header[1] + header[2]), tuple(int(n) for n in header[3].split(",") if n.strip())
    declared = len(start) + length + prod(shape) * kind.itemsize
    if members[0].file_size != declared:
        raise FrameError(
            f"{path}: {name} of shape {shape} must take {declared} bytes, but has {members[0].file_size}; "
            "write the file again."
        )
    return _Array(stream, kind, shape)
