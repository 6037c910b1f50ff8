"""All cues of an edge that an image gives, side by side."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import torch
import torch.nn.functional as F
from torch import Tensor

from blockstab.boundaries.gradients import COLOR_GRADIENTS, color_gradients
from blockstab.boundaries.relief import RELIEF, relief
from blockstab.rgbd.frame import Frame
from blockstab.segments.gaps import without_gaps

CUES = (*COLOR_GRADIENTS, *RELIEF, "rim")


@dataclass(frozen=True)
class Cues:
    """Cues of an edge at each pixel and orientation.

    Args:
        values: (8, 4, H, W) float32, 0 to 1, in the order of `CUES`; orientations as in `BoundaryMap`. Colours are
            those of `color_gradients`, depth and creases those of `relief`; `rim` is 1, whichever way it runs, along
            large areas without depth and in them, most of which are the shadow beside an object.
    """

    values: Tensor

    def __getitem__(self, name: str) -> Tensor:
        """(4, H, W) one of the cues."""
        return self.values[CUES.index(name)]


def cues_of(frame: Frame) -> Cues:
    """Look for every cue of an edge, in colour and in depth side by side where torch may use several threads."""
    with ThreadPoolExecutor(min(2, torch.get_num_threads())) as pool:
        color, depth = pool.submit(color_gradients, frame.color), pool.submit(relief, frame)
        rim = _rim(without_gaps(frame.depth > 0)).expand(4, -1, -1)
        return Cues(torch.cat([color.result(), depth.result(), rim[None]]))


def _rim(mask: Tensor) -> Tensor:
    """(H, W) float32, 1 outside the mask and on the pixels of it that touch the outside."""
    return F.max_pool2d(1.0 - mask.float()[None], 3, stride=1, padding=1)[0]
