"""Damage that keeps a file's outer form, so that what lies behind the first checks is reached."""

from __future__ import annotations

import json
import struct
import zlib
from typing import Any

import numpy as np

from tests.fuzzing.mutations import ANY_FILE, Mutation

PNG = b"\x89PNG\r\n\x1a\n"
_DEEP = b"[" * 100_000
_VALUES: tuple[Any, ...] = (
    *(None, True, False, 0, -1, 1, 2**31, 2**63, 10**400, 1e308, -1e308, float("nan"), float("inf"), 0.5),
    *(
        "",
        "x",
        "x" * 100_000,
        "\x00",
        "\ud800",
        "a\nb",
        "..",
        "../../outside/color.png",
        "/etc/hostname",
        ".",
    ),
    *([], {}, [[]], [None], {"": []}, [0] * 1000, ["1"], {"id": 1}, [[[[1]]]], [1, [2]]),
)
_IHDR = struct.Struct(">IIBBBBB")
_SIZES = (0, 1, 2, 7, 8000, 65535, 2**20, 2**26, 2**31 - 1, 2**31, 2**32 - 1)
_EXTRA = (
    b"acTL",
    b"fcTL",
    b"fdAT",
    b"iCCP",
    b"zTXt",
    b"iTXt",
    b"tEXt",
    b"tRNS",
    b"PLTE",
    b"gAMA",
    b"pHYs",
    b"eXIf",
)


def json_value(data: bytes, random: np.random.Generator) -> bytes:
    """One value of a JSON text changes its type, size or place, or goes."""
    try:
        root = json.loads(data)
    except (ValueError, RecursionError):
        return ANY_FILE[random.integers(len(ANY_FILE))](data, random)
    holders = _holders(root)
    if not holders:
        return json.dumps(_any(_VALUES, random)).encode()
    holder = holders[random.integers(len(holders))]
    key = _any(list(holder) if isinstance(holder, dict) else range(len(holder)), random)
    change = random.integers(6)
    if change == 0:
        del holder[key]
    elif change == 1:
        other = holders[random.integers(len(holders))]
        holder[key] = json.loads(json.dumps(other))
    elif change == 2 and isinstance(holder, dict):
        holder[f"{key}x"] = holder.pop(key)
    elif change == 3 and isinstance(holder, list):
        holder.extend(holder[:] * int(random.integers(1, 50)))
    else:
        holder[key] = _any(_VALUES, random)
    return json.dumps(root).encode()


def json_text(data: bytes, random: np.random.Generator) -> bytes:
    """A JSON text nests too deep, has a key twice, or a number that no float holds."""
    at = data.find(b":", int(random.integers(max(len(data), 1))))
    start = data.rfind(b'"', 0, max(data.rfind(b'"', 0, max(at, 0)), 0))
    if random.integers(3) == 0:
        return data[: at + 1] + _DEEP + (b"]" * len(_DEEP) if random.integers(2) else b"") + data[at + 1 :]
    if random.integers(2) and at > start >= 0:
        return data[: at + 1] + b"1e999, " + data[start : at + 1] + data[at + 1 :]
    return data[: at + 1] + b"9" * 5000 + b"," + data[at + 1 :]


def png_header(data: bytes, random: np.random.Generator) -> bytes:
    """The header of a PNG says something else, and its checksum agrees."""
    chunks = png_chunks(data)
    if not chunks or len(chunks[0][1]) != _IHDR.size:
        return data[:8]
    fields = list(_IHDR.unpack(chunks[0][1]))
    place = int(random.integers(7))
    fields[place] = _any(_SIZES, random) if place < 2 else _any((0, 1, 2, 3, 4, 6, 8, 16, 255), random)
    return png_file([(b"IHDR", _IHDR.pack(*fields)), *chunks[1:]])


def png_resized(data: bytes, width: int, height: int) -> bytes:
    """The same chunks under a header that tells of another size."""
    (_, header), *rest = png_chunks(data)
    return png_file([(b"IHDR", struct.pack(">II", width, height) + header[8:]), *rest])


def png_chunk(data: bytes, random: np.random.Generator) -> bytes:
    """A chunk of a PNG is damaged, lost, doubled, new or swapped with another; all checksums agree."""
    chunks = png_chunks(data)
    if not chunks:
        return data[:8]
    at, change = int(random.integers(len(chunks))), random.integers(5)
    kind, content = chunks[at]
    if change == 0:
        chunks[at] = (kind, ANY_FILE[random.integers(len(ANY_FILE))](content, random))
    elif change == 1:
        del chunks[at]
    elif change == 2:
        chunks.insert(at, (kind, content))
    elif change == 3:
        chunks.insert(at + 1, (_any(_EXTRA, random), _extra(random)))
    else:
        other = int(random.integers(len(chunks)))
        chunks[at], chunks[other] = chunks[other], chunks[at]
    return png_file(chunks)


def png_pixels(data: bytes, random: np.random.Generator) -> bytes:
    """The pixels of a PNG are others, more or fewer, well compressed."""
    chunks = png_chunks(data)
    try:
        rows = zlib.decompress(b"".join(content for kind, content in chunks if kind == b"IDAT"))
    except zlib.error:
        rows = b""
    rows = bytes(10**7) if random.integers(8) == 0 else ANY_FILE[random.integers(len(ANY_FILE))](rows, random)
    kept = [chunk for chunk in chunks if chunk[0] != b"IDAT"]
    return png_file([*kept[:-1], (b"IDAT", zlib.compress(rows)), *kept[-1:]])


def mat_element(data: bytes, random: np.random.Generator) -> bytes:
    """Inside a compressed element of a MATLAB file of version 5 something is damaged, and compressed again."""
    elements, at = [], 128
    while at + 8 <= len(data):
        kind, size = struct.unpack_from("<II", data, at)
        elements.append((kind, data[at + 8 : at + 8 + size]))
        at += 8 + size
    packed = [place for place, (kind, _) in enumerate(elements) if kind == 15]
    if not packed:
        return ANY_FILE[random.integers(len(ANY_FILE))](data, random)
    place = _any(packed, random)
    try:
        inside = zlib.decompress(elements[place][1])
    except zlib.error:
        return data[:at]
    inside = (
        bytes(10**8) if random.integers(20) == 0 else ANY_FILE[random.integers(len(ANY_FILE))](inside, random)
    )
    elements[place] = (15, zlib.compress(inside))
    return data[:128] + b"".join(struct.pack("<II", kind, len(body)) + body for kind, body in elements)


def mutations_for(data: bytes) -> tuple[Mutation, ...]:
    """What can be done to a file that holds `data`; damage that knows its format comes as often as any other."""
    if data.startswith(PNG):
        return ANY_FILE + (png_header, png_chunk, png_pixels) * 3
    if data[:1] in (b"{", b"["):
        return ANY_FILE + (json_value, json_value, json_text) * 3
    if data.startswith(b"MATLAB 5.0"):
        return ANY_FILE + (mat_element,) * 9
    return ANY_FILE


def png_chunks(data: bytes) -> list[tuple[bytes, bytes]]:
    """Kind and content of each whole chunk."""
    chunks, at = [], len(PNG)
    while at + 12 <= len(data):
        size = int.from_bytes(data[at : at + 4], "big")
        chunks.append((data[at + 4 : at + 8], data[at + 8 : at + 8 + size]))
        at += 12 + size
    return chunks


def png_file(chunks: list[tuple[bytes, bytes]]) -> bytes:
    """A PNG of these chunks."""
    return PNG + b"".join(
        struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
        for kind, content in chunks
    )


def _extra(random: np.random.Generator) -> bytes:
    packed = b"name\0\0" + zlib.compress(bytes(10**7))
    return _any((b"", random.bytes(26), bytes(8), b"\xff" * 26, b"\x00\x00\x00\x02" * 7, packed), random)


def _holders(value: Any) -> list[Any]:
    """Every object and list that is not empty."""
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return ([value] if inner else []) + [holder for child in inner for holder in _holders(child)]


def _any(choices: Any, random: np.random.Generator) -> Any:
    return choices[int(random.integers(len(choices)))]
