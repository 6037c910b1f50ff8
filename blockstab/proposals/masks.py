"""Masks that overlap and leave holes, made into a label image."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from blockstab.rgbd.reading import FrameError

MOST_MASKS = 4096
MOST_PIXELS = 2**30  # of all masks of a file together


@dataclass(frozen=True)
class Mask:
    """A segmenter's mask of one thing.

    Args:
        number: its place in the file, from 1.
        inside: (H, W) the pixels that belong to it.
        score: how sure the segmenter is, higher is surer; None where it does not say.
    """

    number: int
    inside: NDArray[np.bool_]
    score: float | None = None


@dataclass(frozen=True)
class Painted:
    """A label image that masks were made into.

    Args:
        label: (H, W) int64; 0 = no mask, else the number of the mask that the pixel went to.
        scores: of the masks that have one, by number.
    """

    label: Tensor
    scores: dict[int, float]


def painted(masks: Iterable[Mask], height: int, width: int) -> Painted:
    """Give every pixel to the smallest of the masks that hold it.

    Of masks of one size the surer one gets it, then the earlier one; one without score is the least sure. So a part
    lies over its whole and every outline stays, whatever the order and the scores: where a mask holds a whole pile,
    a search can join the parts again, but could not know where to cut.

    Args:
        masks: at most 4096, each number once; taken one by one, so that no two need be in memory.
        height, width: of the image and of every mask.
    """
    owner = np.zeros((height, width), dtype=np.int16)  # in the order of `masks`; 0 is no mask
    area, score = np.full(1, height * width + 1), np.full(1, -np.inf)
    numbers, scores = [0], {}
    for mask in masks:
        size, own = np.count_nonzero(mask.inside), -np.inf if mask.score is None else mask.score
        over = (area > size) | ((area == size) & (score < own))
        below = owner[mask.inside]
        owner[mask.inside] = np.where(over[below], np.int16(len(numbers)), below)
        area, score = np.append(area, size), np.append(score, own)
        numbers.append(mask.number)
        if mask.score is not None:
            scores[mask.number] = mask.score
    return Painted(torch.tensor(numbers)[torch.from_numpy(owner).int()], scores)


def check_count(path: Path, masks: int, height: int, width: int) -> None:
    """See that a file does not hold more masks than are worth the time.

    Raises:
        FrameError: it does.
    """
    most = min(MOST_MASKS, MOST_PIXELS // (height * width))
    if masks > most:
        raise FrameError(
            f"{path}: must hold at most {most} masks of {width} x {height} pixels, but holds {masks}; "
            "leave out the smallest or the least sure."
        )
