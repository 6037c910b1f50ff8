"""Arrays and words in an HDF5 file, the format of MATLAB 7.3, read within bounds of time and memory."""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from blockstab.rgbd.reading import FrameError

_MOST_DEFLATED = 1032  # bytes that one can stand for (zlib's technical details)
_DEFLATE, _SHUFFLE = 1, 2
_MOST_CHUNKS = 4096
_MOST_CHUNK_BYTES = 64 * 2**20
_MOST_INFLATED_BYTES = 256 * 2**20  # of all chunks that hold a part of one entry
_MOST_WORDS, _MOST_LETTERS = 4096, 256
_MOST_WORD_BYTES = 64 * 2**10


@dataclass(frozen=True)
class ArrayFile:
    """An open HDF5 file as MATLAB writes it: what it calls H x W x N is an array of N x W x H here.

    Its methods raise `FrameError` where something is missing, damaged, lies in another file, or is packed
    otherwise than by deflate, with or without shuffling.
    """

    path: Path
    file: Any

    def count(self, name: str) -> int:
        """The length of an array's first axis; no more than the file can have bytes for."""
        array, size = self._dataset(name), self.path.stat().st_size
        if not array.shape or math.prod(array.shape) * array.dtype.itemsize > size * _MOST_DEFLATED:
            raise self._fault(f"{name} must fit in the file's {size} bytes, but has shape {array.shape}")
        return int(array.shape[0])

    def entry(self, name: str, index: int, shape: tuple[int, ...], dtype: DTypeLike) -> NDArray[Any]:
        """The entry of an array at one index of its first axis.

        Args:
            shape: of the entry, as it must be.
            dtype: as it must be.
        """
        array = self._dataset(name)
        if array.shape[1:] != shape or array.dtype != dtype or not 0 <= index < array.shape[0]:
            raise self._fault(
                f"{name} must have an entry {index} of shape {shape} and type {np.dtype(dtype)}, but has shape "
                f"{array.shape} and type {array.dtype}"
            )
        return np.asarray(array[index]) if array.chunks is None else self._assembled(array, index)

    def word(self, name: str, index: int) -> str:
        """One word of a cell of words, which are UTF-16."""
        import h5py

        cell = self._small(self._dataset(name), _MOST_WORDS)
        if h5py.check_ref_dtype(cell.dtype) is not h5py.Reference or not 0 <= index < cell.size:
            raise self._fault(f"{name} must refer to a word {index}, but has shape {cell.shape}")
        reference = cell[np.unravel_index(index, cell.shape)]
        letters = self._small(self._checked(self.file[reference], f"word {index} of {name}"), _MOST_LETTERS)
        text = letters[()].tobytes().decode("utf-16-le") if letters.dtype == np.uint16 else "\0"
        if not text.isprintable():
            raise self._fault(f"{name} must hold words, but at {index} it does not")
        return text

    def _dataset(self, name: str) -> Any:
        import h5py

        # Any other kind of link may lead to another file.
        if self.file.id.links.get_info(name.encode()).type != h5py.h5l.TYPE_HARD:
            raise self._fault(f"{name} must lie in the file, but is a link")
        return self._checked(self.file[name], name)

    def _checked(self, found: Any, name: str) -> Any:
        import h5py

        if not isinstance(found, h5py.Dataset):
            raise self._fault(f"{name} must be an array, but is none")
        made = found.id.get_create_plist()
        if made.get_layout() == h5py.h5d.VIRTUAL or made.get_external_count():
            raise self._fault(f"{name} must lie in the file, but refers to another")
        if _filters(found) not in ((), (_DEFLATE,), (_SHUFFLE, _DEFLATE)):
            raise self._fault(f"{name} must be packed by deflate, but is by filters {_filters(found)}")
        return found

    def _small(self, array: Any, most: int) -> Any:
        # The library inflates these by itself, so what is stored must bound what it takes.
        chunk = math.prod(array.chunks or ()) * array.dtype.itemsize
        if array.size > most or max(chunk, array.id.get_storage_size()) > _MOST_WORD_BYTES:
            raise self._fault(f"{array.name} must have at most {most} items, but has shape {array.shape}")
        return array

    def _assembled(self, array: Any, index: int) -> NDArray[Any]:
        """An entry, from the chunks that hold its parts."""
        depth, *steps = array.chunks
        count = math.prod(-(-extent // step) for extent, step in zip(array.shape[1:], steps, strict=True))
        size = math.prod(array.chunks) * array.dtype.itemsize
        if count > _MOST_CHUNKS or size > _MOST_CHUNK_BYTES or count * size > _MOST_INFLATED_BYTES:
            raise self._fault(
                f"{array.name} must have an entry in at most {_MOST_CHUNKS} chunks of {_MOST_INFLATED_BYTES} bytes "
                f"in all, but has it in {count} of {size} bytes"
            )
        out = np.empty(array.shape[1:], array.dtype)
        for corner in product(*map(range, (0,) * len(steps), out.shape, steps)):
            chunk = self._chunk(array, (index - index % depth, *corner), size)[index % depth]
            target = out[tuple(slice(at, at + step) for at, step in zip(corner, steps, strict=True))]
            target[...] = chunk[tuple(map(slice, target.shape))]
        return out

    def _chunk(self, array: Any, corner: tuple[int, ...], size: int) -> NDArray[Any]:
        stored, filters = array.id.get_chunk_info_by_coord(corner), _filters(array)
        data, ended = b"", True
        # Deflate adds little to what it cannot compress.
        if 0 < stored.size <= size + size // 100 + 1024 and not stored.filter_mask:
            _, data = array.id.read_direct_chunk(corner)
        if _DEFLATE in filters:
            # Not by the library, which would inflate to the very end, however far that is.
            inflater = zlib.decompressobj()
            data = inflater.decompress(data, size + 1)
            ended = inflater.eof
        if len(data) != size or not ended:
            raise self._fault(f"chunk {corner} of {array.name} must hold {size} bytes, but does not")
        numbers = np.frombuffer(data, np.uint8)
        if _SHUFFLE in filters:
            numbers = np.ascontiguousarray(numbers.reshape(array.dtype.itemsize, -1).T).reshape(-1)
        whole: NDArray[Any] = numbers.view(array.dtype).reshape(array.chunks)
        return whole

    def _fault(self, what: str) -> FrameError:
        return FrameError(f"{self.path}: {what}; copy the file again.")


@contextmanager
def open_arrays(path: Path) -> Iterator[ArrayFile]:
    """Open an HDF5 file for reading.

    Raises:
        FrameError: it is none; or, in the body, anything that the library makes of damaged bytes.
    """
    import h5py

    try:
        # Network drives often know no locks, and nothing writes to a published file.
        with h5py.File(path, "r", locking=False) as file:
            yield ArrayFile(path, file)
    except FrameError:
        raise
    except Exception as error:  # h5py passes on what the library says as nearly any kind
        said = " ".join(str(error).split())
        raise FrameError(
            f"{path}: must be a whole HDF5 file, but cannot be read ({said}); copy it again."
        ) from error


def _filters(array: Any) -> tuple[int, ...]:
    made = array.id.get_create_plist()
    return tuple(made.get_filter(i)[0] for i in range(made.get_nfilters()))
