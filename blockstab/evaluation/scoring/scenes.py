"""Boxes, supports and verdicts of a parse against the truth (paper, Tables 2 and 3)."""

from __future__ import annotations

import torch

from blockstab.datasets.truth import Truth
from blockstab.evaluation.metrics import axis_error_deg, support_accuracy
from blockstab.evaluation.scoring.prediction import Prediction, Score, seen
from blockstab.rgbd.frame import Frame

BACKGROUND = 0  # every background id, and the ground plane, where supporters are compared


def axis_error(prediction: Prediction, frame: Frame, truth: Truth) -> Score:
    """Degrees between the axes of the boxes and the true ones, over the boxes whose pose is known."""
    found = {s["id"]: s["box"]["rotation"] for s in prediction.record["segments"]}
    known = [o for o in seen(frame, truth) if o.pose_camera is not None and o.kind == "box" and o.id in found]
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
    scored = [o for o in seen(frame, truth) if o.supported_by is not None]
    if not scored:
        return Score(0.0, 0)
    true = {o.id: {_merged(i, background) for i in o.supported_by or ()} for o in scored}
    return Score(support_accuracy(true, found) * len(scored), len(scored))


def stable(prediction: Prediction, frame: Frame, truth: Truth) -> Score:
    """Objects judged stable; in a photograph everything is."""
    verdicts = {s["id"]: s["stable"] for s in prediction.record["segments"]}
    scored = [o.id for o in seen(frame, truth) if o.id in verdicts]
    return Score(float(sum(verdicts[i] for i in scored)), len(scored))


def carried_unseen(prediction: Prediction, frame: Frame, truth: Truth) -> Score:
    """Objects that are judged stable on something that nobody saw; they count as stable too."""
    verdicts = {s["id"]: s["verdict"] for s in prediction.record["segments"]}
    scored = [o.id for o in seen(frame, truth) if o.id in verdicts]
    return Score(float(sum(verdicts[i] == "hidden_support" for i in scored)), len(scored))


def spoilt_found(prediction: Prediction, frame: Frame, truth: Truth) -> Score:
    """Whether anything is judged unstable in a scene that does not stand; other scenes do not count."""
    if not any(o.moves for o in truth.objects):
        return Score(0.0, 0)
    return Score(float(any(not s["stable"] for s in prediction.record["segments"])), 1)


def _merged(identity: int, background: set[int]) -> int:
    return BACKGROUND if identity in background else identity
