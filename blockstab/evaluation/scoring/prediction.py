"""The files of a parse, and which objects of a scene are scored."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from PIL import Image
from torch import Tensor

from blockstab.datasets.truth import MIN_VISIBLE_PX, ObjectTruth, Truth
from blockstab.rgbd.frame import Frame


class Score(NamedTuple):
    """A sum over what was scored in one image, and how many things that were."""

    total: float
    things: int


@dataclass(frozen=True)
class Prediction:
    """Output of a parse: `record` is its scene.json, `label` (H, W) its labels.png."""

    record: dict[str, Any]
    label: Tensor

    @staticmethod
    def read(folder: Path) -> Prediction:
        """Read the files of one parsed scene."""
        record = json.loads((folder / "scene.json").read_text())
        label = np.asarray(Image.open(folder / "labels.png")).astype(np.int64)
        return Prediction(record, torch.from_numpy(label))


def seen(frame: Frame, truth: Truth) -> list[ObjectTruth]:
    """The objects of which the camera sees enough to be scored."""
    assert frame.label is not None
    clear = [o for o in truth.objects if not o.hardly_seen]
    return [o for o in clear if int((frame.label == o.id).sum()) >= MIN_VISIBLE_PX]


def object_ids(frame: Frame, truth: Truth) -> tuple[int, ...]:
    """Of the objects that are scored; where only labels are known, all that are not background."""
    assert frame.label is not None
    if truth.objects:
        return tuple(o.id for o in seen(frame, truth))
    ids = [i for i in torch.unique(frame.label).tolist() if i > 0 and i not in frame.background_ids]
    return tuple(i for i in ids if int((frame.label == i).sum()) >= MIN_VISIBLE_PX)
