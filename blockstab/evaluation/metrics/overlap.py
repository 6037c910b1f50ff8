"""Overlap of segments with the true regions of an image."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import torch
from torch import Tensor

Weighting = Literal["area", "region"]
Unlabelled = Literal["penalise", "mask"]


class Contingency(NamedTuple):
    """Pixel counts that G true regions share with S predicted ones; all int64."""

    pixels: Tensor  # (G, S)
    true_ids: Tensor  # (G,) above 0, ascending
    found_ids: Tensor  # (S,) above 0, ascending
    true_px: Tensor  # (G,) area, where nothing was predicted too
    found_px: Tensor  # (S,) area, where there is no true label too


def contingency(truth: Tensor, predicted: Tensor) -> Contingency:
    """Count the pixels that regions of two label images share.

    Args:
        truth, predicted: (H, W) int64 label images, 0 = none.

    Raises:
        ValueError: the images differ in size.
    """
    if truth.shape != predicted.shape:
        raise ValueError(
            f"Label images must be of one size, but the truth has {tuple(truth.shape)}, "
            f"the prediction {tuple(predicted.shape)}; resample neither, parse the image that was labelled."
        )
    true_ids, t = torch.unique(truth, return_inverse=True)
    found_ids, f = torch.unique(predicted, return_inverse=True)
    size = (len(true_ids), len(found_ids))
    shared = torch.bincount((t * size[1] + f).flatten(), minlength=size[0] * size[1]).view(size)
    labelled, found = true_ids > 0, found_ids > 0
    return Contingency(
        shared[labelled][:, found],
        true_ids[labelled],
        found_ids[found],
        shared.sum(dim=1)[labelled],
        shared.sum(dim=0)[found],
    )


def overlap_score(
    truth: Tensor,
    predicted: Tensor,
    regions: Sequence[int] | None = None,
    weighting: Weighting = "area",
    unlabelled: Unlabelled = "penalise",
) -> float:
    """Pixel-wise segmentation score of one image (Hoiem et al. 2011; Silberman et al. 2012).

    Each true region is matched with the predicted segment of greatest intersection over union, and their mean is
    taken. One segment may be the best for several regions. The score of a data set is the mean over its images.

    Args:
        truth, predicted: (H, W) int64 label images, 0 = none.
        regions: the true ids that are scored; all where not given. The paper scores objects alone.
        weighting: "area" weights regions by their pixels; "region" counts each once.
        unlabelled: pixels of a segment without a true label: "penalise" leaves them in the union, as Silberman's
            evaluation does; "mask" does not see them.

    Returns:
        between 0 and 1; NaN without regions.

    Raises:
        ValueError: the images differ in size, or a choice is none of those above.
    """
    if weighting not in ("area", "region") or unlabelled not in ("penalise", "mask"):
        raise ValueError(
            f"Weighting must be area or region, and unlabelled penalise or mask, but they are {weighting} "
            f"and {unlabelled}; choose from these."
        )
    table = contingency(truth, predicted)
    found_px = table.found_px if unlabelled == "penalise" else table.pixels.sum(dim=0)
    iou = _over_union(table.pixels, table.true_px, found_px)
    best = iou.amax(dim=1) if iou.shape[1] else iou.new_zeros(len(iou))
    weight = table.true_px.double() if weighting == "area" else torch.ones_like(best)
    if regions is not None:
        scored = torch.isin(table.true_ids, torch.tensor(regions, dtype=torch.int64, device=best.device))
        best, weight = best[scored], weight[scored]
    return float((weight * best).sum() / weight.sum())


def intersection_over_union(truth: Tensor, predicted: Tensor) -> tuple[Tensor, Tensor]:
    """Table of intersection over union.

    Returns:
        (G, S) float64 for the G true ids and S predicted ids above 0, each in ascending order; and the true ids (G,).
    """
    table = contingency(truth, predicted)
    return _over_union(table.pixels, table.true_px, table.found_px), table.true_ids


def _over_union(pixels: Tensor, true_px: Tensor, found_px: Tensor) -> Tensor:
    return pixels.double() / (true_px[:, None] + found_px - pixels)
