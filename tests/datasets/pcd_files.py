"""Writes organised clouds, independently of what reads them."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from blockstab.rgbd.frame import Camera

POINT = [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("rgb", "<u4"), ("label", "<u4")]


def seen(depth: NDArray[np.float64], camera: Camera) -> NDArray[np.float64]:
    """(H, W, 3): the point of every pixel of a depth image, NaN where that is 0."""
    v, u = np.indices(depth.shape)
    z = np.where(depth > 0, depth, np.nan)
    return np.stack([(u - camera.cx) * z / camera.fx, (v - camera.cy) * z / camera.fy, z], axis=-1)


def table_of(
    points: NDArray[np.float64], color: NDArray[np.uint8], label: NDArray[np.int64]
) -> NDArray[np.void]:
    """(H, W): one record for each pixel."""
    table = np.zeros(label.shape, POINT)
    table["x"], table["y"], table["z"] = np.moveaxis(points, -1, 0)
    red, green, blue = np.moveaxis(color.astype(np.uint32), -1, 0)
    table["rgb"] = red << 16 | green << 8 | blue
    table["label"] = label
    return table


def header_of(table: NDArray[np.void], data: str, **changed: object) -> bytes:
    """A header for a table (H, W); its entries can be changed by name."""
    height, width = table.shape
    kinds = [table.dtype[name] for name in table.dtype.names]
    entries = {
        "VERSION": "0.7",
        "FIELDS": " ".join(table.dtype.names),
        "SIZE": " ".join(str(kind.base.itemsize) for kind in kinds),
        "TYPE": " ".join(kind.base.kind.upper() for kind in kinds),
        "COUNT": " ".join(str(int(np.prod(kind.shape))) for kind in kinds),
        "WIDTH": width,
        "HEIGHT": height,
        "VIEWPOINT": "0 0 0 1 0 0 0",
        "POINTS": width * height,
        "DATA": data,
    } | changed
    lines = [f"{key} {value}\n" for key, value in entries.items() if value is not None]
    return "".join(["# .PCD v0.7 - Point Cloud Data file format\n", *lines]).encode()


def body_of(table: NDArray[np.void], data: str) -> bytes:
    """The points of a table (H, W), as `data` stores them."""
    if data == "ascii":
        rows = (np.concatenate([np.ravel(value) for value in row]) for row in table.ravel().tolist())
        return "".join(" ".join(f"{value:.9g}" for value in row) + "\n" for row in rows).encode()
    if data == "binary":
        return table.tobytes()
    whole = b"".join(table[name].tobytes() for name in table.dtype.names)
    packed = literal_lzf(whole)
    return struct.pack("<II", len(packed), len(whole)) + packed


def literal_lzf(data: bytes) -> bytes:
    """LZF that refers back to nothing."""
    runs = [data[i : i + 32] for i in range(0, len(data), 32)]
    return b"".join(bytes([len(run) - 1]) + run for run in runs)


def write_cloud(path: Path, table: NDArray[np.void], data: str = "binary", **changed: object) -> Path:
    """Write a table (H, W) as a cloud."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(header_of(table, data, **changed) + body_of(table, data))
    return path
