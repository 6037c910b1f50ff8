"""The segmentation scores as torchmetrics: means over images, gathered over processes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import torch
from torch import Tensor
from torchmetrics import Metric

from blockstab.evaluation.metrics.objects import object_scores
from blockstab.evaluation.metrics.overlap import Unlabelled, Weighting, overlap_score

_OBJECT_SCORES = (
    *("overlap_precision", "overlap_recall", "overlap_f", "boundary_precision", "boundary_recall"),
    *("boundary_f", "detected"),
)


class _MeanOverImages(Metric):
    """The mean of rows of scores, one row an image."""

    is_differentiable = False
    higher_is_better = True
    full_state_update = False
    total: Tensor
    images: Tensor

    def __init__(self, scores: int, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.add_state("total", torch.zeros(scores, dtype=torch.float64), dist_reduce_fx="sum")
        self.add_state("images", torch.tensor(0), dist_reduce_fx="sum")

    def _add(self, scores: Sequence[float]) -> None:
        self.total += self.total.new_tensor(scores)
        self.images += 1


class OverlapScore(_MeanOverImages):
    """Mean over images of `overlap_score`; an image without scored regions does not count.

    Args:
        weighting, unlabelled: as in `overlap_score`.
        **kwargs: those of torchmetrics.
    """

    def __init__(
        self, weighting: Weighting = "area", unlabelled: Unlabelled = "penalise", **kwargs: Any
    ) -> None:
        super().__init__(1, **kwargs)
        self.weighting, self.unlabelled = weighting, unlabelled

    def update(self, preds: Tensor, target: Tensor, regions: Sequence[int] | None = None) -> None:
        """Add one image: predicted and true label images (H, W), and the true ids that are scored."""
        score = overlap_score(target, preds, regions, self.weighting, self.unlabelled)
        if score == score:
            self._add([score])

    def compute(self) -> Tensor:
        """Scalar float64; NaN without images."""
        return (self.total / self.images)[0]


class ObjectAverages(_MeanOverImages):
    """Means over images of `object_scores`: each image counts once, as Xie et al. (2020) average them.

    The F-measures too are means over images, and not those of the mean precision and recall.

    Args:
        tolerance_px: as in `object_scores`.
        **kwargs: those of torchmetrics.
    """

    def __init__(self, tolerance_px: float = 3.0, **kwargs: Any) -> None:
        super().__init__(len(_OBJECT_SCORES), **kwargs)
        self.tolerance_px = tolerance_px

    def update(
        self,
        preds: Tensor,
        target: Tensor,
        found_background: Sequence[int] = (),
        true_background: Sequence[int] = (),
    ) -> None:
        """Add one image: predicted and true label images (H, W), and the ids in each that are no objects."""
        scores = object_scores(target, preds, true_background, found_background, self.tolerance_px)
        overlap, boundary = scores.overlap, scores.boundary
        self._add([*overlap, overlap.f_measure, *boundary, boundary.f_measure, scores.detected])

    def compute(self) -> dict[str, Tensor]:
        """Scalars float64 by name: precision, recall and F of overlap and of boundary, and share detected."""
        return dict(zip(_OBJECT_SCORES, self.total / self.images, strict=True))
