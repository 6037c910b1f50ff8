"""Precision and recall of found objects, by their pixels and by their outlines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import torch
from torch import Tensor

from blockstab.evaluation.metrics.borders import near, outlines
from blockstab.evaluation.metrics.overlap import Contingency, contingency

DETECTED = 0.75  # F-measure of an object that counts as found


class PrecisionRecall(NamedTuple):
    """Shares of what was found that is right, and of what is there that was found."""

    precision: float
    recall: float

    @property
    def f_measure(self) -> float:
        """Harmonic mean of the two; 0 where both are."""
        both = self.precision + self.recall
        return 2 * self.precision * self.recall / both if both else 0.0


@dataclass(frozen=True)
class ObjectScores:
    """Scores of the objects of one image.

    Args:
        overlap: over pixels.
        boundary: over the pixels of outlines.
        detected: share of true objects whose match has an F-measure of at least 0.75.
    """

    overlap: PrecisionRecall
    boundary: PrecisionRecall
    detected: float


def object_scores(
    truth: Tensor,
    predicted: Tensor,
    true_background: Sequence[int] = (),
    found_background: Sequence[int] = (),
    tolerance_px: float = 3.0,
) -> ObjectScores:
    """Score objects as papers on unseen ones do (Dave et al. 2019; Xie et al. 2020, section 5.2).

    Found objects are matched one to one with true ones, so that the sum of the F-measures of the pairs is greatest.
    Then precision is the pixels that pairs share over all pixels of found objects, and recall the same over those of
    true ones. A pixel of the outline of a found object is shared if the outline of its match passes within the
    tolerance; in recall, a pixel of a true outline if that of the match does.

    Args:
        truth, predicted: (H, W) int64 label images, 0 = none.
        true_background, found_background: ids that are no objects in the one and in the other.
        tolerance_px: the published scores allow 0.003 of the image's diagonal, rounded up: 3 pixels at 640 x 480.

    Convention:
        As in the published evaluation, where nothing is found the precision is 1, where nothing is there the recall
        is; then the share detected is 0, or 1 if both hold. Objects that share no pixel are no match, which that
        evaluation leaves to chance.

    Raises:
        ValueError: the images differ in size.
    """
    truth, predicted = _objects(truth, true_background), _objects(predicted, found_background)
    table = contingency(truth, predicted)
    f_measure = 2.0 * table.pixels.double() / (table.true_px[:, None] + table.found_px)
    g, s = _matches(f_measure)
    shared = table.pixels[g, s].sum()
    detected = int((f_measure[g, s] >= DETECTED).sum())
    return ObjectScores(
        PrecisionRecall(_share(shared, table.found_px.sum()), _share(shared, table.true_px.sum())),
        _boundary(outlines(truth), outlines(predicted), table, g, s, tolerance_px),
        detected / len(table.true_ids) if len(table.true_ids) else float(not len(table.found_ids)),
    )


def _objects(label: Tensor, background: Sequence[int]) -> Tensor:
    ids = torch.tensor(background, dtype=label.dtype, device=label.device)
    return torch.where(torch.isin(label, ids), 0, label)


def _matches(f_measure: Tensor) -> tuple[Tensor, Tensor]:
    """Rows and columns of the pairs of greatest sum, each used once, that share a pixel."""
    from scipy.optimize import linear_sum_assignment

    rows, columns = (
        torch.from_numpy(index).to(f_measure.device)
        for index in linear_sum_assignment(f_measure.cpu().numpy(), maximize=True)
    )
    met = f_measure[rows, columns] > 0
    return rows[met], columns[met]


def _boundary(
    true: Tensor, found: Tensor, table: Contingency, g: Tensor, s: Tensor, tolerance_px: float
) -> PrecisionRecall:
    """Precision and recall of outlines, (N, 3) and (M, 3) as `outlines` gives them, of the pairs `g`, `s`."""
    # Pairs lie further apart than the tolerance in a third dimension, so one search serves them all.
    spacing = tolerance_px + 1.0
    one = _paired(true, table.true_ids, g, spacing)
    other = _paired(found, table.found_ids, s, spacing)
    return PrecisionRecall(
        _share(near(other, one, tolerance_px).sum(), torch.tensor(len(found))),
        _share(near(one, other, tolerance_px).sum(), torch.tensor(len(true))),
    )


def _paired(outline: Tensor, ids: Tensor, matched: Tensor, spacing: float) -> Tensor:
    """(K, 3) float64: the outline pixels of matched regions, and `spacing` times the number of their pair."""
    pair = torch.full_like(ids, -1)
    pair[matched] = torch.arange(len(matched), device=ids.device)
    number = pair[torch.searchsorted(ids, outline[:, 0].contiguous())]
    points = torch.cat([outline[:, 1:].double(), number[:, None] * spacing], dim=1)
    return points[number >= 0]


def _share(part: Tensor, whole: Tensor) -> float:
    return int(part) / int(whole) if whole else 1.0
