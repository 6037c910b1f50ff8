"""Score the files of a parse against a scene's truth."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from PIL import Image
from torch import Tensor

from blockstab.datasets.truth import MIN_VISIBLE_PX, ObjectTruth, Truth
from blockstab.metrics import ObjectScores, axis_error_deg, object_scores, overlap_score, support_accuracy
from blockstab.metrics.overlap import Weighting
from blockstab.rgbd.frame import Frame

BACKGROUND = 0  # every background id, and the ground plane, where supporters are compared


class Score(NamedTuple):
    """A sum over what was scored in one image, and how many things that were."""

    total: float
    things: int


@dataclass(frozen=True)
class Prediction:
    """What a parse wrote: `record` is its scene.json, `label` (H, W) its labels.png."""

    record: dict[str, Any]
    label: Tensor

    @staticmethod
    def read(folder: Path) -> Prediction:
        """Read the files of one parsed scene."""
        record = json.loads((folder / "scene.json").read_text())
        label = np.asarray(Image.open(folder / "labels.png")).astype(np.int64)
        return Prediction(record, torch.from_numpy(label))


def axis_error(prediction: Prediction, frame: Frame, truth: Truth) -> Score:
    """Degrees between the axes of the boxes and the true ones, over the boxes whose pose is known."""
    found = {s["id"]: s["box"]["rotation"] for s in prediction.record["segments"]}
    known = [
        o for o in _seen(frame, truth) if o.pose_camera is not None and o.kind == "box" and o.id in found
    ]
    if not known:
        return Score(0.0, 0)
    rotation = torch.tensor([found[o.id] for o in known], dtype=torch.float64)
    true = torch.stack([o.pose_camera[:3, :3] for o in known if o.pose_camera is not None])
    return Score(float(axis_error_deg(rotation, true).sum()), len(known))


def support(prediction: Prediction, frame: Frame, truth: Truth) -> Score:
    """Objects whose supporters, of whatever type, are exactly the true ones (the paper's Table 3)."""
    return _exact_supporters(prediction, frame, truth, frozenset(("surface", "partial", "side")))


def support_below(prediction: Prediction, frame: Frame, truth: Truth) -> Score:
    """The same for truth that names supporters from below only: predicted side supports are left out."""
    return _exact_supporters(prediction, frame, truth, frozenset(("surface", "partial")))


def _exact_supporters(prediction: Prediction, frame: Frame, truth: Truth, types: frozenset[str]) -> Score:
    if not truth.support_annotated:
        return Score(0.0, 0)
    background = {*truth.background_ids, BACKGROUND}
    background |= {s["id"] for s in prediction.record["segments"] if s["background"]}
    found: dict[int, set[int]] = {}
    for edge in prediction.record["supports"]:
        if edge["type"] in types:
            found.setdefault(edge["supported"], set()).add(_merged(edge["supporter"], background))
    scored = [o for o in _seen(frame, truth) if o.supported_by is not None]
    if not scored:
        return Score(0.0, 0)
    true = {o.id: {_merged(i, background) for i in o.supported_by or ()} for o in scored}
    return Score(support_accuracy(true, found) * len(scored), len(scored))


def stable(prediction: Prediction, frame: Frame, truth: Truth) -> Score:
    """Objects judged stable; in a photograph everything is."""
    verdicts = {s["id"]: s["stable"] for s in prediction.record["segments"]}
    scored = [o.id for o in _seen(frame, truth) if o.id in verdicts]
    return Score(float(sum(verdicts[i] for i in scored)), len(scored))


def overlap(prediction: Prediction, frame: Frame, truth: Truth) -> Score:
    """The pixel-wise segmentation score of the image, over its objects, weighted by their areas."""
    return _overlap(prediction, frame, truth, "area")


def overlap_plain(prediction: Prediction, frame: Frame, truth: Truth) -> Score:
    """The same, every object counting alike."""
    return _overlap(prediction, frame, truth, "region")


def _overlap(prediction: Prediction, frame: Frame, truth: Truth, weighting: Weighting) -> Score:
    assert frame.label is not None
    objects = _object_ids(frame, truth)
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
    objects = _object_ids(frame, truth)
    if not objects:
        return Score(0.0, 0)
    true = torch.where(torch.isin(frame.label, torch.tensor(objects)), frame.label, 0)
    # What is hardly seen is neither missed nor found in vain.
    hardly_seen = torch.tensor([o.id for o in truth.objects if o.id not in objects], dtype=torch.int64)
    found = torch.where(torch.isin(frame.label, hardly_seen), 0, prediction.label)
    background = [s["id"] for s in prediction.record["segments"] if s["background"]]
    return Score(part(object_scores(true, found, found_background=background)), 1)


SCORES: dict[str, Callable[[Prediction, Frame, Truth], Score]] = {
    "axis_error_deg": axis_error,
    "support_accuracy": support,
    "support_below": support_below,
    "stable_share": stable,
    "overlap": overlap,
    "overlap_plain": overlap_plain,
    "overlap_f": overlap_f,
    "boundary_f": boundary_f,
    "detected": detected,
}


def score_scene(frame: Frame, truth: Truth, predicted: Path, names: tuple[str, ...]) -> dict[str, Score]:
    """Scores of one parsed scene, whose files are in the folder `predicted`.

    Raises:
        ValueError: if the scene has no labels to score against.
    """
    if frame.label is None:
        raise ValueError(f"{frame.name} has no labels; there is nothing to score against.")
    prediction = Prediction.read(predicted)
    return {name: SCORES[name](prediction, frame, truth) for name in names}


def _seen(frame: Frame, truth: Truth) -> list[ObjectTruth]:
    assert frame.label is not None
    clear = [o for o in truth.objects if not o.hardly_seen]
    return [o for o in clear if int((frame.label == o.id).sum()) >= MIN_VISIBLE_PX]


def _object_ids(frame: Frame, truth: Truth) -> tuple[int, ...]:
    """Of the objects that are scored; where only labels are known, all that are not background."""
    assert frame.label is not None
    if truth.objects:
        return tuple(o.id for o in _seen(frame, truth))
    ids = [i for i in torch.unique(frame.label).tolist() if i > 0 and i not in frame.background_ids]
    return tuple(i for i in ids if int((frame.label == i).sum()) >= MIN_VISIBLE_PX)


def _merged(identity: int, background: set[int]) -> int:
    return BACKGROUND if identity in background else identity
