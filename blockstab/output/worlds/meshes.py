"""Boxes as meshes: GLB (binary glTF 2.0) and PLY; metres, y up, the ground at y = 0."""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from blockstab.boxes.box import Boxes
from blockstab.output.coloring import WORLD_COLORS
from blockstab.output.worlds.poses import quaternion_of
from blockstab.stability.arrangement import Arrangement

_FLOAT, _SHORT = 5126, 5123  # as glTF numbers its types
_VERTICES, _INDICES = 34962, 34963


def glb(asked: Arrangement, name: str) -> bytes:
    """A binary glTF scene: a node for each box, with its name, place, rotation and size, of one cube."""
    boxes = _on_ground(asked)
    corners, normals, triangles = _cube()
    parts = [some.tobytes() for some in (corners, normals, triangles)]
    starts = np.cumsum([0, *map(len, parts)]).tolist()
    count = len(asked.ids)
    document: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": "blockstab"},
        "scene": 0,
        "scenes": [{"name": name, "nodes": list(range(count))}],
        "nodes": [
            {
                "name": own,
                "mesh": i,
                "translation": boxes.center[i].tolist(),
                "rotation": [*quaternion_of(boxes.rotation[i])[1:], quaternion_of(boxes.rotation[i])[0]],
                "scale": boxes.half_extent[i].tolist(),
            }
            for i, own in enumerate(asked.ids)
        ],
        "meshes": [
            {
                "name": own,
                "primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": i}],
            }
            for i, own in enumerate(asked.ids)
        ],
        "materials": [_material(i) for i in range(count)],
        "buffers": [{"byteLength": starts[-1]}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": start, "byteLength": len(part), "target": target}
            for start, part, target in zip(starts, parts, (_VERTICES, _VERTICES, _INDICES), strict=False)
        ],
        "accessors": [
            {**_accessor(0, len(corners), "VEC3", _FLOAT), "min": [-1.0] * 3, "max": [1.0] * 3},
            _accessor(1, len(normals), "VEC3", _FLOAT),
            _accessor(2, triangles.size, "SCALAR", _SHORT),
        ],
    }
    text, binary = json.dumps(document).encode(), b"".join(parts)
    chunks = [
        (text.ljust(-(-len(text) // 4) * 4), b"JSON"),
        (binary.ljust(-(-len(binary) // 4) * 4, b"\0"), b"BIN\0"),
    ]
    body = b"".join(struct.pack("<I4s", len(chunk), kind) + chunk for chunk, kind in chunks)
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


def _chunk(content: bytes, kind: bytes) -> bytes:
    return struct.pack("<I4s", len(content), kind) + content


def ply(asked: Arrangement) -> str:
    """A PLY mesh of all boxes in text: eight corners and twelve triangles each, in a colour of its own."""
    boxes = _on_ground(asked)
    corners, triangles = boxes.corners().tolist(), _TRIANGLES.tolist()
    header = [
        "ply",
        "format ascii 1.0",
        *(f"comment box {k}: {own}" for k, own in enumerate(asked.ids)),
        f"element vertex {8 * len(corners)}",
        *(f"property double {axis}" for axis in "xyz"),
        *(f"property uchar {color}" for color in ("red", "green", "blue")),
        f"element face {12 * len(corners)}",
        "property list uchar int vertex_indices",
        "end_header",
    ]
    vertices = [
        " ".join(f"{value:.9g}" for value in (*corner, *WORLD_COLORS[k % len(WORLD_COLORS)]))
        for k, some in enumerate(corners)
        for corner in some
    ]
    faces = [f"3 {a + 8 * k} {b + 8 * k} {c + 8 * k}" for k in range(len(corners)) for a, b, c in triangles]
    return "\n".join([*header, *vertices, *faces]) + "\n"


def _on_ground(asked: Arrangement) -> Boxes:
    center = asked.boxes.center.clone()
    center[:, 1] -= asked.ground_height
    return Boxes(center, asked.boxes.rotation, asked.boxes.half_extent)


# Corners as `Boxes.corners` numbers them; counter-clockwise, seen from outside.
_FACES = np.array([[4, 6, 7, 5], [0, 1, 3, 2], [2, 3, 7, 6], [0, 4, 5, 1], [1, 5, 7, 3], [0, 2, 6, 4]])
_TRIANGLES = np.concatenate([_FACES[:, [0, 1, 2]], _FACES[:, [0, 2, 3]]])


def _cube() -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.uint16]]:
    """Corners (24, 3), normals (24, 3) and triangles (12, 3) of the cube from -1 to 1; its faces share no corner."""
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float32)
    normals = np.repeat(
        np.array([[s * (k == a) for k in range(3)] for a in range(3) for s in (1, -1)]), 4, axis=0
    )
    first = 4 * np.arange(6)[:, None]
    triangles = np.concatenate([first + np.array([0, 1, 2]), first + np.array([0, 2, 3])])
    return signs[_FACES.ravel()], normals.astype(np.float32), triangles.astype(np.uint16)


def _accessor(view: int, count: int, kind: str, component: int) -> dict[str, Any]:
    return {"bufferView": view, "componentType": component, "count": count, "type": kind}


def _material(i: int) -> dict[str, Any]:
    color = [(part / 255) ** 2.2 for part in WORLD_COLORS[i % len(WORLD_COLORS)]]  # glTF's factors are linear
    return {"pbrMetallicRoughness": {"baseColorFactor": [*color, 1.0], "metallicFactor": 0.0}}
