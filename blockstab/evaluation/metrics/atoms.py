"""Boundary adherence of an over-segmentation to the true regions."""

from __future__ import annotations

import torch
from torch import Tensor

from blockstab.evaluation.metrics.borders import borders, near
from blockstab.evaluation.metrics.overlap import contingency


def undersegmentation_error(truth: Tensor, atoms: Tensor) -> float:
    """Share of pixels that leak: in atoms that reach across a true border.

    For every true region and every atom that meets it, the part of the atom inside the region or the part outside
    counts, whichever is smaller (Neubert and Protzel 2012, eq. 3). The older error of Levinshtein et al. (2009)
    counts all that is outside, and so punishes large atoms that leak by a pixel.

    Args:
        truth, atoms: (H, W) int64 label images, 0 = none. A pixel that has no label in either is left out.

    Returns:
        between 0 and 1, lower is better; NaN where no pixel is left.

    Raises:
        ValueError: the images differ in size.
    """
    inside = contingency(truth, atoms).pixels
    outside = inside.sum(dim=0, keepdim=True) - inside
    return float(torch.minimum(inside, outside).sum().double() / inside.sum())


def boundary_recall(true_boundary: Tensor, atoms: Tensor, tolerance_px: float = 3.0) -> float:
    """Share of the true boundary that the borders of the atoms follow (Martin et al. 2004).

    Args:
        true_boundary: (H, W) bool, as `inner_border` of the true objects.
        atoms: (H, W) int64 label image; the pixels on both sides of a border are on it, 0 is a label like others.
        tolerance_px: how far off, in straight line, a border may be.

    Returns:
        between 0 and 1; NaN without a boundary.

    Raises:
        ValueError: the images differ in size.
    """
    if true_boundary.shape != atoms.shape:
        raise ValueError(
            f"Images must be of one size, but the boundary has {tuple(true_boundary.shape)}, "
            f"the atoms {tuple(atoms.shape)}; take both from one image."
        )
    return float(near(true_boundary.nonzero(), borders(atoms).nonzero(), tolerance_px).double().mean())
