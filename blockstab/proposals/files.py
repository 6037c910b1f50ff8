"""Regions from a label image: the scene's own, or that of any other segmenter."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from blockstab.percept import Percept
from blockstab.proposals import Proposed
from blockstab.rgbd.frame import Frame
from blockstab.rgbd.reading import label_file


@dataclass(frozen=True)
class LabelFile:
    """Take the regions as they are, ids kept.

    Args:
        path: PNG of one channel of 8 or 16 bits with a region id in every pixel, 0 = none. Without it the
            scene's own `label.png` is taken, whose `background_ids` tell background from objects.
    """

    path: str | Path | None = None

    def __call__(self, percept: Percept) -> Proposed:
        """Read the regions.

        Raises:
            ValueError: if the file is not such an image or has not the size of the frame; or, without a path,
                if the scene has no labels.
        """
        frame = percept.frame
        if self.path is not None:
            return Proposed(_read(Path(self.path), frame))
        if frame.label is None:
            raise ValueError(
                f"{frame.name} has no label.png; add one, name another label image, or use another proposal."
            )
        ids = torch.unique(frame.label).tolist()
        return Proposed(frame.label, {region: region in frame.background_ids for region in ids if region > 0})


def _read(path: Path, frame: Frame) -> Tensor:
    """(H, W) int64 region ids."""
    file = label_file(path)
    height, width = frame.depth.shape
    if (file.width, file.height) != (width, height):
        raise ValueError(
            f"{path}: must have the {width} x {height} pixels of {frame.name}, but has "
            f"{file.width} x {file.height}; make it from the same image, without resampling its ids."
        )
    return torch.from_numpy(np.asarray(file.decode()).astype(np.int64))
