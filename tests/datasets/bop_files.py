"""A miniature in the BOP format: two images of two boxes, one half behind the other."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

WIDTH, HEIGHT = 40, 30
CAMERA = (40.0, 41.0, 19.5, 14.5)
TURN = [0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]  # a quarter about z
SCALE = 0.5  # millimetres
FRONT, BEHIND = (slice(5, 20), slice(5, 20)), (slice(10, 25), slice(20, 35))
SAID = {
    "camera": {"cam_K": [40.0, 0.0, 19.5, 0.0, 41.0, 14.5, 0.0, 0.0, 1.0], "depth_scale": SCALE},
    "gt": [
        {"obj_id": 5, "cam_R_m2c": TURN, "cam_t_m2c": [100.0, -50.0, 800.0]},
        {"obj_id": 7, "cam_R_m2c": np.eye(3).flatten().tolist(), "cam_t_m2c": [0.0, 0.0, 900.0]},
    ],
    "gt_info": [{"px_count_all": 225, "visib_fract": 1.0}, {"px_count_all": 300, "visib_fract": 0.75}],
}
MODELS = {
    "5": {"min_x": -10, "min_y": -20, "min_z": 0, "size_x": 40, "size_y": 60, "size_z": 80, "diameter": 108}
}


def write_bop(root: Path) -> None:
    """The split `test` with one scene."""
    scene = root / "test" / "000003"
    for image in (0, 12):
        write_png(scene / "rgb" / f"{image:06d}.png", np.full((HEIGHT, WIDTH, 3), 90 + image, dtype="u1"))
        write_png(scene / "depth" / f"{image:06d}.png", np.full((HEIGHT, WIDTH), 1600, dtype="u2"))
        for number, place in enumerate((FRONT, BEHIND)):
            mask = np.zeros((HEIGHT, WIDTH), dtype="u1")
            mask[place] = 255
            write_png(scene / "mask_visib" / f"{image:06d}_{number:06d}.png", mask)
    for name, entry in SAID.items():
        write_json(scene / f"scene_{name}.json", {"0": entry, "12": entry})
    write_json(root / "models" / "models_info.json", MODELS)


def write_json(path: Path, value: Any) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(value))


def write_png(path: Path, pixels: np.ndarray) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(pixels).save(path)
