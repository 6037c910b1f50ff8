"""The compression of point clouds."""

from __future__ import annotations

import pytest

from blockstab.datasets.formats.lzf import decompress
from tests.datasets.pcd_files import literal_lzf


def test_a_reference_may_repeat_what_it_writes_itself() -> None:
    # "ab", then 7 bytes from 2 back: ababababa; then, in the long form, 9 + 3 bytes from 1 back.
    assert decompress(bytes([1, 97, 98, 5 << 5, 1]), 9) == b"ababababa"
    assert decompress(bytes([0, 97, 7 << 5, 3, 0]), 13) == b"a" * 13
    # A reference can go back 8192 bytes, no further.
    far = bytes(range(256)) * 32
    assert decompress(literal_lzf(far) + bytes([1 << 5 | 31, 255]), 8195) == far + far[:3]


@pytest.mark.parametrize(
    ("data", "fault"),
    [
        (bytes([1 << 5, 0]), "before the data"),
        (bytes([0, 97, 1 << 5]), "within a reference"),
        (bytes([5, 97]), "does not yield the 9"),
        (bytes([0, 97, 7 << 5, 255, 0]), "does not yield the 9"),
    ],
)
def test_damaged_compression_is_refused(data: bytes, fault: str) -> None:
    with pytest.raises(ValueError, match=fault):
        decompress(data, 9)
