"""Numbers and cells in MATLAB files of version 5, read within bounds of time and memory."""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from reprlib import repr as shown

import numpy as np
from numpy.typing import NDArray

from blockstab.rgbd.reading import FrameError

_MOST_BYTES = 16 * 2**20  # of the file, and of each variable
_MOST_ELEMENTS = 65536  # of one variable, or of the file
_HEADER_BYTES = 128
_MATRIX, _COMPRESSED = 14, 15
_CELL, _NUMBERS = 1, range(6, 16)  # classes of arrays
_COMPLEX = 0x800
_DTYPES = dict(zip((1, 2, 3, 4, 5, 6, 7, 9, 12, 13), "bBhHiIfdqQ", strict=True))


class _Damage(ValueError):
    """Fault in the content of a file, for a line that names the file."""


@dataclass(frozen=True)
class Matrix:
    """An array of a MATLAB file; what it holds is looked at when asked for.

    Args:
        path: of the file.
        name: of the variable.
        shape: as MATLAB has it.
        flags: its class and whether it is complex, as in the file.
        content: the elements that follow the name.
    """

    path: Path
    name: str
    shape: tuple[int, ...]
    flags: int
    content: memoryview

    def numbers(self) -> NDArray[np.float64]:
        """Its real numbers, of its shape; FrameError where it holds anything else."""
        if self.flags & 0xFF not in _NUMBERS or self.flags & _COMPLEX:
            raise self._fault("must hold real numbers, but does not")
        try:
            kind, data = next(_elements(self.content), (0, memoryview(b"")))
        except _Damage as error:
            raise self._fault(str(error)) from None
        count = math.prod(self.shape)
        if kind not in _DTYPES or len(data) != count * struct.calcsize(_DTYPES[kind]):
            raise self._fault(f"must hold {count} numbers, but has {len(data)} bytes of type {kind}")
        values = np.frombuffer(data, np.dtype(_DTYPES[kind]).newbyteorder("<")).astype(np.float64)
        return values.reshape(self.shape, order="F")

    def cells(self) -> list[Matrix]:
        """The arrays that it holds, in the order of the file; FrameError where it is no cell array."""
        if self.flags & 0xFF != _CELL:
            raise self._fault("must be a cell array, but is none")
        try:
            inner = [_matrix(self.path, data) for kind, data in _elements(self.content) if kind == _MATRIX]
        except _Damage as error:
            raise self._fault(str(error)) from None
        if len(inner) != math.prod(self.shape):
            raise self._fault(f"must hold {math.prod(self.shape)} cells, but has {len(inner)}")
        return inner

    def _fault(self, what: str) -> FrameError:
        name = shown(self.name) if self.name else "a cell"
        return FrameError(f"{self.path}: {name} {what}; copy the file again.")


def read_matlab(path: Path) -> dict[str, Matrix]:
    """The variables of a MATLAB file of version 5, as MATLAB and SciPy write it on the machines of today.

    Raises:
        FrameError: it is missing, larger than 16 MiB, of another version, or damaged.
    """
    try:
        size = path.stat().st_size if path.is_file() else -1
        content = path.read_bytes() if 0 <= size <= _MOST_BYTES else b""
    except OSError:
        size, content = -1, b""
    if size > _MOST_BYTES:
        raise FrameError(f"{path}: must have at most {_MOST_BYTES} bytes, but has {size}; copy it again.")
    if len(content) < _HEADER_BYTES or content[124:128] != b"\x00\x01IM":
        raise FrameError(
            f"{path}: must be a MATLAB file of version 5, little-endian, but is missing or none; copy it again."
        )
    try:
        whole = memoryview(content)[_HEADER_BYTES:]
        found = [
            _matrix(path, _inflated(data) if kind == _COMPRESSED else data)
            for kind, data in _elements(whole)
            if kind in (_COMPRESSED, _MATRIX)
        ]
    except _Damage as error:
        raise FrameError(f"{path}: {error}; copy it again.") from None
    return {matrix.name: matrix for matrix in found}


def _elements(data: memoryview) -> Iterator[tuple[int, memoryview]]:
    """Type and bytes of each element in a row."""
    at = count = 0
    while at < len(data):
        count += 1
        if count > _MOST_ELEMENTS or len(data) - at < 8:
            raise _Damage("it must be a row of whole elements, but is not")
        kind, size = struct.unpack_from("<II", data, at)
        if kind >> 16:  # few bytes, packed beside the type
            kind, size, start, step = kind & 0xFFFF, kind >> 16, at + 4, 8
        else:
            # Compressed elements alone are not padded to eight bytes.
            start, step = at + 8, 8 + (size if kind == _COMPRESSED else -(-size // 8) * 8)
        if start + size > len(data):
            raise _Damage(f"an element must have {size} bytes, but the file ends before")
        yield kind, data[start : start + size]
        at += step


def _inflated(data: memoryview) -> memoryview:
    """The one matrix in a compressed element."""
    inflater = zlib.decompressobj()
    try:
        content = inflater.decompress(data, _MOST_BYTES)
    except zlib.error:
        raise _Damage("a compressed variable is damaged") from None
    if len(content) >= _MOST_BYTES:
        raise _Damage(f"a variable must have less than {_MOST_BYTES} bytes, but has more")
    kind, inner = next(_elements(memoryview(content)), (0, memoryview(b"")))
    if kind != _MATRIX:
        raise _Damage("a compressed variable must be an array, but is none")
    return inner


def _matrix(path: Path, data: memoryview) -> Matrix:
    """The head of an array; what it holds stays packed."""
    at, parts = 0, []
    for _, part in _elements(data):
        parts.append(part)
        if len(parts) == 3:
            break
    if len(parts) < 3 or len(parts[0]) != 8 or len(parts[1]) % 4 or not 8 <= len(parts[1]) <= 64:
        raise _Damage("an array must have flags, a shape and a name, but has not")
    flags = struct.unpack_from("<I", parts[0])[0]
    shape = struct.unpack(f"<{len(parts[1]) // 4}i", parts[1])
    if min(shape) < 0 or math.prod(shape) > _MOST_BYTES:
        raise _Damage(f"an array must fit in {_MOST_BYTES} bytes, but has shape {shape}")
    for part in parts:
        at += 8 if _packed(data, at) else 8 + -(-len(part) // 8) * 8
    return Matrix(path, bytes(parts[2]).decode("ascii", "replace"), shape, flags, data[min(at, len(data)) :])


def _packed(data: memoryview, at: int) -> bool:
    return bool(struct.unpack_from("<I", data, at)[0] >> 16)
