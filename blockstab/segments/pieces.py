"""Regions that hang together in the image."""

from __future__ import annotations

import numpy as np
import torch
from skimage.measure import label as components
from torch import Tensor


def connected_pieces(label: Tensor) -> Tensor:
    """(H, W) int64: the 4-connected pieces of each label but 0, from 1; 0 elsewhere."""
    return torch.from_numpy(np.asarray(components(label.numpy(), connectivity=1), dtype=np.int64))


def without_small_pieces(label: Tensor, least_px: float) -> Tensor:
    """The (H, W) labels, but 0 on 4-connected pieces of fewer than `least_px` pixels."""
    pieces = connected_pieces(label)
    large = torch.bincount(pieces.flatten()) >= least_px
    return torch.where(large[pieces], label, 0)
