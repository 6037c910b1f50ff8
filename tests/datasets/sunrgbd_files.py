"""A miniature of SUN RGB-D: one image with all that it may have, one with the least."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

WIDTH, HEIGHT = 40, 30
FULL, BARE = Path("kv2/lab/0001"), Path("xtion/home/0002")
TILT = np.array([[1.0, 0.0, 0.0], [0.0, 0.8, -0.6], [0.0, 0.6, 0.8]])  # of a camera that looks down
POLYGONS = {
    "objects": [{"name": "Floor1:truncated"}, {"name": "box"}, None, {"name": "cup"}, {"name": "unseen"}],
    "frames": [
        {
            "polygon": [
                {"object": 0, "x": [0, 39, 39, 0], "y": [20, 20, 29, 29]},
                {"object": 4, "x": [20, 22, 22, 20], "y": [6, 6, 8, 8]},
                {"object": 1, "x": [5, 24, 24, 5], "y": [5, 5, 24, 24]},
                {"object": 3, "x": [10, 14, 14, 10], "y": [10, 10, 14, 14]},
                {"object": 3, "x": [30, 34, 34, 30], "y": [10, 10, 14, 14]},
                {"object": 5, "x": [0, 39, 39, 0], "y": [0, 0, 29, 29]},
                {"object": 3, "x": 3, "y": 3},
                {"object": 3, "x": None, "y": None},
            ]
        }
    ],
}


def write_sunrgbd(root: Path) -> None:
    """Both images."""
    millimetres = np.full((HEIGHT, WIDTH), 1503, dtype="u2")
    for folder, depth in ((root / FULL, "depth"), (root / BARE, "depth_bfx")):
        write_image(folder / "image" / "a.jpg", np.full((HEIGHT, WIDTH, 3), 90, dtype="u1"))
        write_image(folder / depth / "a.png", (millimetres << 3) | (millimetres >> 13))
        write_text(folder / "intrinsics.txt", "40 0 19.5\n0 41 14.5\n0 0 1\n")
        write_text(folder / "annotation2Dfinal/index.json", json.dumps(POLYGONS))
    write_image(root / FULL / "depth_bfx" / "a.png", (millimetres // 2) << 3)
    rows = np.concatenate([TILT, np.zeros((3, 1))], axis=1)
    write_text(
        root / FULL / "extrinsics" / "20140101.txt", "\n".join(" ".join(map(str, row)) for row in rows)
    )


def write_text(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def write_image(path: Path, pixels: Any) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(pixels).save(path)
