"""Scores: segments by overlap and outline, boxes by their axes, supports by exact sets (paper, section 8)."""

from __future__ import annotations

from blockstab.evaluation.metrics.atoms import boundary_recall, undersegmentation_error
from blockstab.evaluation.metrics.borders import inner_border
from blockstab.evaluation.metrics.contact import touching
from blockstab.evaluation.metrics.objects import ObjectScores, PrecisionRecall, object_scores
from blockstab.evaluation.metrics.overlap import intersection_over_union, overlap_score
from blockstab.evaluation.metrics.scene import axis_error_deg, support_accuracy

__all__ = [
    "ObjectScores",
    "PrecisionRecall",
    "axis_error_deg",
    "boundary_recall",
    "inner_border",
    "intersection_over_union",
    "object_scores",
    "overlap_score",
    "support_accuracy",
    "touching",
    "undersegmentation_error",
]
