"""The header of a .pcd file: which fields a point has, how many points there are, and how they are stored."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import accumulate
from typing import BinaryIO, NamedTuple

_MOST_POINTS = 64_000_000
_MOST_BYTES = 32 * _MOST_POINTS
_MOST_HEADER_BYTES = 8192
_MOST_FIELDS = 64
_DTYPES = {"F4": "<f4", "F8": "<f8"} | {f"{k}{n}": f"<{k.lower()}{n}" for k in "IU" for n in (1, 2, 4, 8)}
_WANTED = {
    **dict.fromkeys(("x", "y", "z"), ("F4", "F8")),
    **dict.fromkeys(("rgb", "rgba"), ("F4", "U4")),
    "label": ("U1", "U2", "U4"),
}


class Field(NamedTuple):
    """One of those that are used, and where it lies: `values` and `size` (bytes) are those before it."""

    name: str
    dtype: str
    values: int
    size: int


class Header(NamedTuple):
    """The fields of the header; `values` and `size` (bytes) are of one point."""

    fields: list[Field]
    values: int
    size: int
    width: int
    height: int
    data: str


def read_header(file: BinaryIO) -> Header:
    """Read up to the points, and check all sizes.

    Raises:
        ValueError: it is no header of an organised cloud, lacks a field that is needed, or tells of over 64
            million points or 2 GB; the message goes on from "but".
    """
    entries: dict[str, list[str]] = {}
    while "DATA" not in entries:
        line = file.readline(_MOST_HEADER_BYTES)
        if not line.endswith(b"\n") or file.tell() > _MOST_HEADER_BYTES:
            raise ValueError(f"its first {_MOST_HEADER_BYTES} bytes hold no line DATA")
        key, *words = line.decode("latin-1").split("#")[0].split() or ["#"]
        entries[key] = words
    (width,), (height,), (points,) = (_numbers(entries, key, 1) for key in ("WIDTH", "HEIGHT", "POINTS"))
    if width < 2 or height < 2:
        raise ValueError("it has no rows and columns (WIDTH and HEIGHT of 2 and more)")
    if width * height != points or points > _MOST_POINTS:
        raise ValueError("its POINTS are not WIDTH times HEIGHT, or over 64 million")
    fields, values, size = _read_fields(entries)
    if size * points > _MOST_BYTES:
        raise ValueError("its points take over 2 GB")
    if entries["DATA"] not in (["ascii"], ["binary"], ["binary_compressed"]):
        raise ValueError("its DATA is neither ascii nor binary nor binary_compressed")
    return Header(fields, values, size, width, height, entries["DATA"][0])


def _read_fields(entries: Mapping[str, list[str]]) -> tuple[list[Field], int, int]:
    """The fields that are used, and the values and bytes of a point."""
    names, kinds = entries.get("FIELDS", []), entries.get("TYPE", [])
    if not len(names) == len(kinds) <= _MOST_FIELDS:
        raise ValueError(f"its FIELDS and TYPE are not as many, or over {_MOST_FIELDS}")
    sizes = _numbers(entries, "SIZE", len(names))
    counts = _numbers(entries, "COUNT", len(names)) if "COUNT" in entries else [1] * len(names)
    values_before = [0, *accumulate(counts)]
    size_before = [0, *accumulate(size * count for size, count in zip(sizes, counts, strict=True))]
    fields = []
    for i, (name, kind) in enumerate(zip(names, kinds, strict=True)):
        if f"{kind}{sizes[i]}" not in _DTYPES:
            raise ValueError(f"field {i + 1} has no known TYPE and SIZE")
        if name in _WANTED:
            if f"{kind}{sizes[i]}" not in _WANTED[name] or counts[i] != 1:
                raise ValueError(f"its field {name} is not one value of type {' or '.join(_WANTED[name])}")
            fields.append(Field(name, _DTYPES[f"{kind}{sizes[i]}"], values_before[i], size_before[i]))
    found = [field.name for field in fields]
    if not {"x", "y", "z"} <= set(found) or not {"rgb", "rgba"} & set(found) or len(set(found)) < len(found):
        raise ValueError("its FIELDS do not give x, y, z and rgb or rgba, once each")
    return fields, values_before[-1], size_before[-1]


def _numbers(entries: Mapping[str, list[str]], key: str, count: int) -> list[int]:
    words = entries.get(key, [])
    # Nine digits hold every size that is allowed, and no product of them is long to work out.
    if len(words) != count or not all(w.isascii() and w.isdecimal() and len(w) < 10 for w in words):
        raise ValueError(f"its {key} is not {count} whole number{'s' * (count > 1)}")
    return [int(word) for word in words]
