"""Segments of a parse against the true ones (paper, Table 4; Xie et al. 2020)."""

from __future__ import annotations

from collections.abc import Callable

import torch

from blockstab.datasets.truth import Truth
from blockstab.evaluation.metrics import ObjectScores, object_scores, overlap_score, touching
from blockstab.evaluation.metrics.overlap import Weighting
from blockstab.evaluation.scoring.prediction import Prediction, Score, object_ids
from blockstab.rgbd.frame import Frame


def overlap(prediction: Prediction, frame: Frame, truth: Truth) -> Score:
    """The pixel-wise segmentation score of the image, over its objects, weighted by their areas."""
    return _overlap(prediction, frame, truth, "area")


def overlap_plain(prediction: Prediction, frame: Frame, truth: Truth) -> Score:
    """The same, every object counting alike."""
    return _overlap(prediction, frame, truth, "region")


def overlap_touching(prediction: Prediction, frame: Frame, truth: Truth) -> Score:
    """The same as `overlap`, in images in which two objects touch; nothing in others."""
    assert frame.label is not None
    met = touching(frame.label, frame.depth, object_ids(frame, truth))
    return overlap(prediction, frame, truth) if met else Score(0.0, 0)


def _overlap(prediction: Prediction, frame: Frame, truth: Truth, weighting: Weighting) -> Score:
    assert frame.label is not None
    objects = object_ids(frame, truth)
    if not objects:
        return Score(0.0, 0)
    return Score(overlap_score(frame.label, prediction.label, objects, weighting), 1)


def overlap_f(prediction: Prediction, frame: Frame, truth: Truth) -> Score:
    """F-measure of the pixels of matched objects in the image (Xie et al. 2020)."""
    return _of_objects(prediction, frame, truth, lambda scores: scores.overlap.f_measure)


def boundary_f(prediction: Prediction, frame: Frame, truth: Truth) -> Score:
    """F-measure of the outlines of matched objects in the image."""
    return _of_objects(prediction, frame, truth, lambda scores: scores.boundary.f_measure)


def detected(prediction: Prediction, frame: Frame, truth: Truth) -> Score:
    """Share of the objects of the image whose match has an F-measure of at least 0.75."""
    return _of_objects(prediction, frame, truth, lambda scores: scores.detected)


def _of_objects(
    prediction: Prediction, frame: Frame, truth: Truth, part: Callable[[ObjectScores], float]
) -> Score:
    assert frame.label is not None
    objects = object_ids(frame, truth)
    if not objects:
        return Score(0.0, 0)
    true = torch.where(torch.isin(frame.label, torch.tensor(objects)), frame.label, 0)
    # What is hardly seen is neither missed nor found in vain.
    hardly_seen = torch.tensor([o.id for o in truth.objects if o.id not in objects], dtype=torch.int64)
    found = torch.where(torch.isin(frame.label, hardly_seen), 0, prediction.label)
    background = [s["id"] for s in prediction.record["segments"] if s["background"]]
    return Score(part(object_scores(true, found, found_background=background)), 1)
