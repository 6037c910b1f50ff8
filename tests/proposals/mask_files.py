"""Files of masks, as segmenters write them, and a small set of them to be damaged."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from PIL import Image

from blockstab.proposals.annotations import annotated_masks
from blockstab.proposals.arrays import stored_masks
from blockstab.proposals.masks import painted
from blockstab.rgbd.reading import label_file
from tests.fuzzing.reader import Reader

Masks = Sequence[NDArray[np.bool_]]
SMALL = (30, 40)  # height and width


def runs_of(mask: NDArray[np.bool_]) -> list[int]:
    """Run lengths of a mask, counted pixel by pixel."""
    runs, inside = [0], False
    for pixel in mask.T.flatten().tolist():
        if pixel != inside:
            runs.append(0)
            inside = pixel
        runs[-1] += 1
    return runs


def letters_of(runs: Sequence[int]) -> str:
    """The string that COCO compresses run lengths to, number by number."""
    text = ""
    for i, run in enumerate(runs):
        number, more = run - (runs[i - 2] if i > 2 else 0), True
        while more:
            bits, number = number & 31, number >> 5
            more = number != (-1 if bits & 16 else 0)
            text += chr(48 + bits + 32 * more)
    return text


def write_coco(path: Path, masks: Masks, scores: Sequence[float], compressed: bool = True) -> None:
    """Results, in the way of COCO: a list, run lengths as strings or as lists."""
    counts = [letters_of(runs_of(m)) if compressed else runs_of(m) for m in masks]
    results = [
        {"image_id": 7, "category_id": 1, "segmentation": {"size": [*m.shape], "counts": c}, "score": score}
        for m, c, score in zip(masks, counts, scores, strict=True)
    ]
    path.write_text(json.dumps(results))


def write_sam(path: Path, masks: Masks, scores: Sequence[float]) -> None:
    """What Segment Anything returns of an image, in an object as in its data set."""
    listed: list[dict[str, Any]] = []
    for mask, score in zip(masks, scores, strict=True):
        rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
        box = [columns[0], rows[0], np.ptp(columns), np.ptp(rows)]
        listed.append(
            {
                "segmentation": {"size": [*mask.shape], "counts": letters_of(runs_of(mask))},
                "area": int(mask.sum()),
                "bbox": [float(side) for side in box],
                "predicted_iou": score,
                "point_coords": [[box[0] + 0.5, box[1] + 0.5]],
                "stability_score": 0.97,
                "crop_box": [0, 0, mask.shape[1], mask.shape[0]],
            }
        )
    path.write_text(json.dumps({"image": {"image_id": 1}, "annotations": listed}))


def write_arrays(path: Path, masks: Masks, scores: Sequence[float], name: str = "scores") -> None:
    """An .npz of dense masks."""
    np.savez_compressed(path, masks=np.stack(masks), **{name: np.array(scores, dtype=np.float32)})


def write_labels(path: Path, masks: Masks) -> None:
    """A label image; later masks lie over earlier ones."""
    label = np.zeros(masks[0].shape, dtype=np.uint16)
    for number, mask in enumerate(masks, start=1):
        label[mask] = number
    Image.fromarray(label).save(path)


def nested() -> list[NDArray[np.bool_]]:
    """A whole, a part of it, and something that overlaps both; a rim is in none."""
    masks = np.zeros((3, *SMALL), dtype=bool)
    masks[0, 2:22, 3:33] = True
    masks[1, 5:15, 5:15] = True
    masks[2, 12:28, 12:36] = True
    return list(masks)


def write_masks(root: Path) -> None:
    """The same masks in every kind of file."""
    masks, scores = nested(), (0.9, 0.8, 0.95)
    write_coco(root / "coco.json", masks, scores)
    write_coco(root / "lists.json", masks, scores, compressed=False)
    write_sam(root / "sam.json", masks, scores)
    write_arrays(root / "masks.npz", masks, scores)
    write_labels(root / "labels.png", masks)


def read_masks(root: Path) -> None:
    """Read and paint all of them."""
    for name in ("coco.json", "lists.json", "sam.json"):
        painted(annotated_masks(root / name, *SMALL), *SMALL)
    painted(stored_masks(root / "masks.npz", *SMALL), *SMALL)
    file = label_file(root / "labels.png")
    torch.from_numpy(np.asarray(file.decode()).astype(np.int64))


# The path is the user's own, so that links may lead anywhere.
MASKS = Reader("masks", write_masks, read_masks, confined=False)
