"""Damage to the bytes of a file, whatever its format."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

Mutation = Callable[[bytes, np.random.Generator], bytes]

LONGEST = 4096  # bytes of a chunk that is moved, or of noise
HUGE = (0, 1, 2**31, 2**32, 2**40, 2**63, *(2**bits - 1 for bits in (7, 8, 15, 16, 31, 32, 63, 64)))
NUMBERS = (b"", b"0", b"-1", b"1e999", b"-1e999", b"nan", b"1e-320", b"0x10", b"99999", b"4294967296")
NUMBERS += (b"9223372036854775808", b"9" * 400, b"9" * 5000, b"1.5.2", b"70000", b"2147483647", b"true")
_NUMBER = re.compile(rb"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
# Where the formats keep their structure: HDF5's blocks, the matrices and compressed elements of MATLAB.
_LANDMARK = re.compile(
    rb"\x89HDF|OHDR|OCHK|TREE|HEAP|SNOD|GCOL|FRHP|BTHD|\x0e\x00\x00\x00|\x0f\x00\x00\x00|\xff\xd8|\xff[\xc0-\xdb]"
)
_TEXT_HEAD = 65536  # bytes among which numbers are looked for


def flip_bits(data: bytes, random: np.random.Generator) -> bytes:
    """One to eight bits turn over."""
    out = bytearray(data)
    for _ in range(int(random.integers(1, 9)) if data else 0):
        out[_place(data, random)] ^= 1 << int(random.integers(8))
    return bytes(out)


def overwrite(data: bytes, random: np.random.Generator) -> bytes:
    """A run of bytes becomes noise, zeros or ones."""
    at, length = _place(data, random), _length(random)
    fill = (random.bytes(length), bytes(length), b"\xff" * length)[random.integers(3)]
    return data[:at] + fill[: len(data) - at] + data[at + length :]


def truncate(data: bytes, random: np.random.Generator) -> bytes:
    """The end is missing."""
    return data[: _place(data, random)]


def extend(data: bytes, random: np.random.Generator) -> bytes:
    """Noise or a part of itself follows the end."""
    at, length = _place(data, random), _length(random)
    return data + (random.bytes(length) if random.integers(2) else data[at : at + length])


def delete_chunk(data: bytes, random: np.random.Generator) -> bytes:
    """A run of bytes is missing, and the rest moves up."""
    at = _place(data, random)
    return data[:at] + data[at + _length(random) :]


def duplicate_chunk(data: bytes, random: np.random.Generator) -> bytes:
    """A run of bytes comes twice."""
    at, length = _place(data, random), _length(random)
    return data[: at + length] + data[at:]


def swap_chunks(data: bytes, random: np.random.Generator) -> bytes:
    """Two runs of bytes change places."""
    first, second = sorted((_place(data, random), _place(data, random)))
    length = min(_length(random), second - first, len(data) - second)
    one, other = data[first : first + length], data[second : second + length]
    return data[:first] + other + data[first + length : second] + one + data[second + length :]


def huge_number(data: bytes, random: np.random.Generator) -> bytes:
    """An aligned number of 1 to 8 bytes, of either byte order, becomes a border case."""
    size = int(random.choice([1, 2, 4, 8]))
    at = _place(data, random) // size * size
    value = HUGE[random.integers(len(HUGE))] % 2 ** (8 * size)
    order = "little" if random.integers(2) else "big"
    return data[:at] + value.to_bytes(size, order)[: len(data) - at] + data[at + size :]


def written_number(data: bytes, random: np.random.Generator) -> bytes:
    """A decimal number in text, or in the text that a binary file starts with, becomes another."""
    found = list(_NUMBER.finditer(data[:_TEXT_HEAD]))
    if not found:
        return flip_bits(data, random)
    # Half of the time one of the first twenty, which are those of a header.
    match = found[random.integers(min(len(found), 20 if random.integers(2) else len(found)))]
    return data[: match.start()] + NUMBERS[random.integers(len(NUMBERS))] + data[match.end() :]


ANY_FILE: tuple[Mutation, ...] = (
    *(flip_bits, overwrite, truncate, extend, delete_chunk, duplicate_chunk, swap_chunks),
    *(huge_number, huge_number, written_number),
)


def _place(data: bytes, random: np.random.Generator) -> int:
    """Somewhere in the file: anywhere, in its head, or just behind a landmark of its format."""
    if len(data) < 2:
        return 0
    where = random.integers(3)
    if where == 1:
        return int(random.integers(min(len(data), 512)))
    found = [m.start() for m in _LANDMARK.finditer(data)] if where == 2 else []
    if not found:
        return int(random.integers(len(data)))
    return min(found[random.integers(len(found))] + int(random.integers(96)), len(data) - 1)


def _length(random: np.random.Generator) -> int:
    """Of a chunk: as likely short as long."""
    return int(2 ** random.uniform(0, np.log2(LONGEST)))
