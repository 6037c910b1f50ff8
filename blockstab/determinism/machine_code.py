"""Names of machine code on disk, which is made again where what it comes from has changed."""

from __future__ import annotations

import hashlib
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]


def fingerprint_of(*rooms: str) -> int:
    """A number that changes with any file in folders of the package.

    Of itself numba only sees when the file of a function changes. What that names from outside, such as this number,
    is part of what its machine code is known by.
    """
    files = [file for room in rooms for file in sorted((_PACKAGE / room).rglob("*.py"))]
    return int.from_bytes(hashlib.sha256(b"".join(file.read_bytes() for file in files)).digest()[:7])
