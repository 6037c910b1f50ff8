"""Masks as run lengths, the way COCO and Segment Anything write them."""

from __future__ import annotations

from reprlib import repr as shown
from typing import Any

import numpy as np
from numpy.typing import NDArray

from blockstab.rgbd.reading import FrameError

Runs = NDArray[np.int64]
_SHOWN = 80  # letters of what came
_LONGEST = 6  # letters of one number: 30 bits, more than a difference of two counts can need


def run_lengths(segmentation: object, height: int, width: int, where: str) -> Runs:
    """The checked run lengths of a mask, before its pixels take memory.

    Args:
        segmentation: {"size": [height, width], "counts": ...}; counts are a list of whole numbers, or the string
            that COCO compresses it to.
        height, width: of the image; no other size is accepted.
        where: the file and the mask in it, to begin a message with.

    Returns:
        (R,) int64 lengths of runs outside the mask and inside it in turn, down the columns from the left.

    Raises:
        FrameError: the segmentation is none of that, or its runs do not add up to the image.
    """
    if not isinstance(segmentation, dict) or not {"size", "counts"} <= segmentation.keys():
        came = "polygons" if isinstance(segmentation, list) else shown(segmentation)
        raise FrameError(
            f"{where}: segmentation must be run lengths, an object with size and counts, but it is "
            f"{came[:_SHOWN]}; encode it with pycocotools."
        )
    size, counts = segmentation["size"], segmentation["counts"]
    if size != [height, width]:
        raise FrameError(
            f"{where}: size must be that of the image, [{height}, {width}] (height, width), but it is "
            f"{shown(size)[:_SHOWN]}; segment the same image, at its full size."
        )
    total = height * width
    runs = _numbers(counts) if isinstance(counts, str) else _listed(counts, total)
    if runs is None or len(runs) > total + 1 or not bool((runs >= 0).all()) or int(runs.sum()) != total:
        came = shown(counts) if runs is None else f"{len(runs)} that add up to {int(runs.sum())}"
        raise FrameError(
            f"{where}: counts must be run lengths from 0 that add up to the {total} pixels of the image, but they "
            f"are {came[:_SHOWN]}; write the file again."
        )
    return runs


def inside(runs: Runs, height: int, width: int) -> NDArray[np.bool_]:
    """(height, width) the pixels of a mask, from its checked run lengths."""
    turns = np.arange(len(runs)) % 2 == 1
    return np.repeat(turns, runs).reshape(width, height).T


def _listed(counts: Any, total: int) -> Runs | None:
    """The counts of a list; None where they are no run lengths."""
    if not isinstance(counts, list) or not all(
        type(count) is int and 0 <= count <= total for count in counts
    ):
        return None
    return np.array(counts, dtype=np.int64)


def _numbers(text: str) -> Runs | None:
    """The counts that a string stands for; None where it stands for none.

    Each letter, less 48, holds five bits of a number, the lowest first, and a sixth that says whether another letter
    follows; the highest of the last five is the sign. From the fourth on, a number is the difference to the count
    two before (`rleToString` of the COCO API).
    """
    if not text or not text.isascii():
        return None
    letters = np.frombuffer(text.encode(), dtype=np.uint8) - np.uint8(48)
    last = letters & 32 == 0
    ends = np.flatnonzero(last)
    lengths = np.diff(ends, prepend=-1)
    if int(letters.max()) > 63 or not last[-1] or int(lengths.max()) > _LONGEST:
        return None
    starts = (ends - lengths + 1).astype(np.int32)
    place = np.arange(len(letters), dtype=np.int32) - np.repeat(starts, lengths)
    numbers = np.add.reduceat((letters & 31).astype(np.int32) << 5 * place, starts, dtype=np.int64)
    numbers -= (letters[ends] & 16 > 0) * (np.int64(1) << 5 * lengths)
    numbers[1::2] = numbers[1::2].cumsum()
    numbers[2::2] = numbers[2::2].cumsum()
    return numbers
