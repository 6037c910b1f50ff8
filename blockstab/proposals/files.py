"""Regions that somebody else made: the labels of a scene, or what any segmenter wrote."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from blockstab.determinism.sources import stamp_of_files
from blockstab.observation import Observation
from blockstab.proposals import Proposed
from blockstab.proposals.annotations import annotated_masks
from blockstab.proposals.arrays import stored_masks
from blockstab.proposals.masks import Mask, Painted, painted
from blockstab.rgbd.reading import FrameError, label_file

_MASKS = {".json": annotated_masks, ".npz": stored_masks}
SCENE = "{scene}"


@dataclass(frozen=True)
class LabelFile:
    """The scene's own `label.png`, ids kept; its `background_ids` tell background from objects."""

    def __call__(self, observation: Observation) -> Proposed:
        """Take the regions.

        Raises:
            ValueError: if the scene has no labels.
        """
        frame = observation.frame
        if frame.label is None:
            raise ValueError(
                f"{frame.name} has no label.png; add one, name another label image, or use another proposal."
            )
        ids = torch.unique(frame.label).tolist()
        return Proposed(frame.label, {region: region in frame.background_ids for region in ids if region > 0})


@dataclass(frozen=True)
class MaskFile:
    """File of a segmenter: a label image, or masks that overlap and leave holes.

    A pixel that several masks hold goes to the smallest (`painted`). Of those in none, the ones in the ground plane
    are one region more; the others stay without region.

    Args:
        path: with `{scene}` in place of the scene's name. A .png of one channel of 8 or 16 bits has a region id in
            every pixel, 0 = none; a .json holds COCO annotations or results, or what Segment Anything returns, in
            run lengths; an .npz holds `masks` (N, H, W) and, if there are any, `scores` (N,). The id of a region is
            that of the image, or the place of its mask in the file, from 1.
        least_score: masks of a lower score are left out; one without score is not.
        least_px: a smaller mask is left out, and so is what is left of one under others.
        background_share: a region of which such a share is in the ground plane is known as background.
    """

    path: str | Path
    least_score: float = 0.0
    least_px: int = 100
    background_share: float = 0.5

    def __post_init__(self) -> None:
        if Path(self.path).suffix not in (".png", *_MASKS):
            raise ValueError(
                f"Masks must be a .png, .json or .npz file, but the path is {self.path}; name one."
            )

    def file(self, scene: str) -> Path:
        """The file of a scene."""
        return Path(str(self.path).replace(SCENE, scene))

    def stamp(self, scene: str) -> str:
        """A hash of the file of a scene."""
        return stamp_of_files([self.file(scene)])

    def __call__(self, observation: Observation) -> Proposed:
        """Read the regions.

        Raises:
            FrameError: if the file is none of those above, is damaged, or has not the size of the frame.
        """
        regions = self._regions(observation)
        label = self._large(regions.label)
        free = observation.on_ground & (label == 0)
        label = self._large(torch.where(free, label.max() + 1, label))
        pixels = torch.bincount(label.flatten())
        ground = torch.bincount(label[observation.on_ground], minlength=len(pixels))
        flat = (ground > self.background_share * pixels).nonzero()[:, 0].tolist()
        scores = {
            region: score
            for region, score in regions.scores.items()
            if region < len(pixels) and pixels[region]
        }
        return Proposed(label, {region: True for region in flat if region > 0}, scores)

    def _regions(self, observation: Observation) -> Painted:
        path, (height, width) = self.file(observation.frame.name), observation.frame.depth.shape
        if path.suffix == ".png":
            return Painted(_label_image(path, observation.frame.name, height, width), {})
        masks = _MASKS[path.suffix](path, height, width)
        return painted((mask for mask in masks if self._counts(mask)), height, width)

    def _counts(self, mask: Mask) -> bool:
        sure = mask.score is None or mask.score >= self.least_score
        return sure and int(np.count_nonzero(mask.inside)) >= self.least_px

    def _large(self, label: Tensor) -> Tensor:
        return torch.where(torch.bincount(label.flatten())[label] >= self.least_px, label, 0)


def _label_image(path: Path, scene: str, height: int, width: int) -> Tensor:
    """(H, W) int64 region ids."""
    file = label_file(path)
    if (file.width, file.height) != (width, height):
        raise FrameError(
            f"{path}: must have the {width} x {height} pixels of {scene}, but has "
            f"{file.width} x {file.height}; make it from the same image, without resampling its ids."
        )
    return torch.from_numpy(np.asarray(file.decode()).astype(np.int64))
