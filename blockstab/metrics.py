"""Scores: segments by overlap, boxes by their axes, supports by exact sets (paper, section 8)."""

from __future__ import annotations

from itertools import permutations

import torch
from torch import Tensor


def overlap_score(truth: Tensor, predicted: Tensor, objects: tuple[int, ...]) -> float:
    """Pixel-wise segmentation score of one image (Hoiem et al. 2011; Silberman et al. 2012).

    Each true object is matched with the predicted segment of greatest intersection over union; the mean is weighted
    by the objects' areas. A predicted segment's unlabelled pixels count in the union.

    Args:
        truth, predicted: (H, W) int64 label images, 0 = none.
        objects: the true ids that are scored.

    Returns:
        between 0 and 1; NaN without objects.
    """
    if truth.shape != predicted.shape:
        raise ValueError(
            f"Label images must be of one size, but the truth has {tuple(truth.shape)}, "
            f"the prediction {tuple(predicted.shape)}."
        )
    iou, ids = intersection_over_union(truth, predicted)
    scored = torch.isin(ids, torch.tensor(objects, dtype=ids.dtype))
    area = torch.stack([(truth == i).sum() for i in ids]).to(torch.float64) if len(ids) else iou.new_zeros(0)
    best = iou.amax(dim=1) if iou.shape[1] else iou.new_zeros(len(ids))
    return float((area * best)[scored].sum() / area[scored].sum())


def intersection_over_union(truth: Tensor, predicted: Tensor) -> tuple[Tensor, Tensor]:
    """Table of intersection over union.

    Returns:
        (G, S) float64 for the G true ids and S predicted ids above 0, each in ascending order; and the true ids (G,).
    """
    true_ids, t = torch.unique(truth, return_inverse=True)
    found_ids, f = torch.unique(predicted, return_inverse=True)
    joint = torch.bincount((t * len(found_ids) + f).flatten(), minlength=len(true_ids) * len(found_ids))
    both = joint.view(len(true_ids), len(found_ids)).to(torch.float64)
    union = both.sum(dim=1, keepdim=True) + both.sum(dim=0, keepdim=True) - both
    return (both / union)[true_ids > 0][:, found_ids > 0], true_ids[true_ids > 0]


def axis_error_deg(rotation: Tensor, truth: Tensor) -> Tensor:
    """How far the axes of boxes are from the true ones.

    Axes have no sign and no order: of all one-to-one matches, the one of least summed angle counts.

    Args:
        rotation, truth: (N, 3, 3), columns are axes, in one frame.

    Returns:
        (N,) the mean of the three angles, degrees.
    """
    cosine = (rotation.transpose(1, 2) @ truth).abs().clamp(max=1.0)
    angle = torch.rad2deg(torch.acos(cosine))
    each = [angle[:, list(order), range(3)].mean(dim=1) for order in permutations(range(3))]
    return torch.stack(each).amin(dim=0)


def support_accuracy(truth: dict[int, set[int]], predicted: dict[int, set[int]]) -> float:
    """Share of objects whose supporters are exactly the true ones (the paper's "all its supporting objects").

    Args:
        truth: the supporters of each scored object; predicted: those found, by the same ids.

    Returns:
        between 0 and 1; NaN without objects.
    """
    if not truth:
        return float("nan")
    return sum(predicted.get(identity, set()) == below for identity, below in truth.items()) / len(truth)
