"""Recall of the flat things on a table: pens, cutlery, sheets, that depth hardly shows."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn.functional import max_pool2d

from blockstab.datasets.truth import Truth
from blockstab.evaluation.metrics.overlap import intersection_over_union
from blockstab.evaluation.scoring.prediction import Prediction, Score, object_ids
from blockstab.rgbd.cloud import cloud_from_frame
from blockstab.rgbd.frame import Frame

FLAT = 0.02  # metres above what is around it, up to which a thing is flat
_AROUND_PX = 20
_LEAST_PX = 60  # of an object with depth, and of the background around it
_TOP = 0.8  # share of an object's points that count: the rest may be noise at edges
_FOUND = 0.5  # intersection over union


def flat_found(prediction: Prediction, frame: Frame, truth: Truth) -> Score:
    """Flat objects of which one segment has at least half, by intersection over union."""
    assert frame.label is not None
    flat = flat_objects(frame, object_ids(frame, truth))
    if not flat:
        return Score(0.0, 0)
    share, true_ids = intersection_over_union(frame.label, prediction.label)
    found = (share[torch.isin(true_ids, torch.tensor(flat))] >= _FOUND).any(dim=1)
    return Score(float(found.sum()), len(flat))


def flat_objects(frame: Frame, objects: tuple[int, ...]) -> list[int]:
    """Those objects whose points hardly rise above the plane of the background around them.

    Args:
        frame: with labels.
        objects: the ids to choose from.
    """
    assert frame.label is not None
    cloud = cloud_from_frame(frame)
    ground = torch.isin(frame.label, torch.tensor(frame.background_ids)) & cloud.valid
    flat = []
    for one in objects:
        inside = frame.label == one
        own, around = cloud.points[inside & cloud.valid], cloud.points[_widened(inside) & ground]
        if min(len(own), len(around)) >= _LEAST_PX and _rise(own, around) <= FLAT:
            flat.append(one)
    return flat


def _widened(mask: Tensor) -> Tensor:
    """A mask (H, W), and all that is near it; first along columns, then along rows."""
    width, pad = 2 * _AROUND_PX + 1, _AROUND_PX
    tall = max_pool2d(mask[None].float(), (width, 1), stride=1, padding=(pad, 0))
    wide: Tensor = max_pool2d(tall, (1, width), stride=1, padding=(0, pad))[0] > 0
    return wide


def _rise(own: Tensor, around: Tensor) -> float:
    """Distance within which most points (M, 3) lie from the plane through others (N, 3), metres."""
    center = around.mean(dim=0)
    normal = torch.linalg.eigh((around - center).T @ (around - center)).eigenvectors[:, 0]
    return float(((own - center) @ normal).abs().quantile(_TOP))
