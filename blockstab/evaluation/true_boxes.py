"""Judges asked about true boxes: how far they are right where nothing else is wrong."""

from __future__ import annotations

from collections.abc import Mapping

import torch

from blockstab.boxes.box import Boxes
from blockstab.datasets.sets import SceneSet
from blockstab.datasets.truth import Truth
from blockstab.evaluation.scoring.prediction import Score
from blockstab.evaluation.scoring.removals import agreed, any_falls, exact_set, reached
from blockstab.rgbd.ground import world_from_camera
from blockstab.stability.arrangement import Arrangement
from blockstab.stability.judges import StabilityJudge
from blockstab.stability.removal import falls_if_removed
from blockstab.stability.support import SupportRules

_TOUCH = SupportRules(touch_m=0.003, touch_per_square_m=0.0)  # the engine lets solids sink in by a millimetre


def arrangement_of(truth: Truth) -> Arrangement:
    """The bounding boxes of the objects of a simulated scene, on the plane of the lowest of their corners.

    Raises:
        ValueError: a pose, or the up direction, is not known.
    """
    objects = truth.objects
    if truth.up_camera is None or any(o.pose_camera is None or o.half_extent is None for o in objects):
        raise ValueError(
            "True boxes need the pose of every object and the up direction; use simulated scenes."
        )
    pose = torch.stack([o.pose_camera for o in objects if o.pose_camera is not None])
    half = torch.stack([o.half_extent for o in objects if o.half_extent is not None])
    boxes = Boxes(pose[:, :3, 3], pose[:, :3, :3], half).rotated(world_from_camera(truth.up_camera))
    movable, exact = torch.ones(len(half), dtype=torch.bool), torch.zeros(len(half), dtype=torch.float64)
    ground = float(boxes.corners()[..., 1].amin())
    return Arrangement(tuple(str(o.id) for o in objects), boxes, movable, ground, _TOUCH, exact)


def removals_in(
    data: SceneSet, scene: str, judges: Mapping[str, StabilityJudge]
) -> dict[str, dict[str, Score]]:
    """The same as `removals`, of one scene of a set."""
    torch.set_num_threads(1)
    return removals(data.read(scene)[1], judges)


def removals(truth: Truth, judges: Mapping[str, StabilityJudge]) -> dict[str, dict[str, Score]]:
    """Of each judge, and of simpler guesses, how often it is right about what falls without each thing.

    Returns:
        By name, `falls_any` and `falls_set`, as those of a parse.
    """
    true = [set(o.falls_if_removed or ()) for o in truth.objects]
    asked, ids = arrangement_of(truth), [o.id for o in truth.objects]
    candidates = asked.candidates()
    found: dict[str, list[set[int]]] = {"Nothing falls": [set() for _ in ids]}
    edges = list(zip(candidates.supporter.tolist(), candidates.supported.tolist(), strict=True))
    found["What can be reached"] = [{ids[j] for j in reached(i, edges)} for i in range(len(ids))]
    for name, judge in judges.items():
        stable = judge(asked.boxes, asked.movable, candidates, asked.slack).balance.stable
        table = falls_if_removed(asked.boxes, asked.movable, candidates, stable, asked.slack, judge)
        found[name] = [{ids[j] for j in row.nonzero()[:, 0].tolist()} for row in table]
    return {
        name: {
            "falls_any": agreed(zip(true, told, strict=True), any_falls),
            "falls_set": agreed(zip(true, told, strict=True), exact_set),
        }
        for name, told in found.items()
    }
