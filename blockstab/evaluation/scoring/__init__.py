"""Score the files of a parse against a scene's truth."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from blockstab.datasets.truth import Truth
from blockstab.evaluation.scoring.flat import flat_found
from blockstab.evaluation.scoring.prediction import Prediction, Score
from blockstab.evaluation.scoring.removals import agreement, any_falls, exact_set, falls, nothing, reachable
from blockstab.evaluation.scoring.scenes import (
    axis_error,
    carried_unseen,
    spoilt_found,
    stable,
    support,
    support_below,
)
from blockstab.evaluation.scoring.segments import (
    boundary_f,
    detected,
    overlap,
    overlap_f,
    overlap_plain,
    overlap_touching,
)
from blockstab.rgbd.frame import Frame

__all__ = ["SCORES", "Prediction", "Score", "score_scene"]

SCORES: dict[str, Callable[[Prediction, Frame, Truth], Score]] = {
    "axis_error_deg": axis_error,
    "support_accuracy": support,
    "support_below": support_below,
    "stable_share": stable,
    "carried_unseen": carried_unseen,
    "spoilt_found": spoilt_found,
    "falls_any": agreement(falls, any_falls),
    "falls_set": agreement(falls, exact_set),
    "reachable_any": agreement(reachable, any_falls),
    "reachable_set": agreement(reachable, exact_set),
    "nothing_any": agreement(nothing, any_falls),
    "nothing_set": agreement(nothing, exact_set),
    "overlap": overlap,
    "overlap_plain": overlap_plain,
    "overlap_touching": overlap_touching,
    "overlap_f": overlap_f,
    "boundary_f": boundary_f,
    "detected": detected,
    "flat_found": flat_found,
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
