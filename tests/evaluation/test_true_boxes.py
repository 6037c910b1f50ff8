"""Judges asked about true boxes are right where the truth is worked by hand."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from blockstab.datasets.truth import ObjectTruth, Truth
from blockstab.evaluation.scoring.prediction import Score
from blockstab.evaluation.true_boxes import arrangement_of, removals
from blockstab.stability.judges import StaticEquilibrium, TrimmedSupports
from blockstab.testing import worlds
from blockstab.testing.worlds import Block, build

JUDGES = {"paper": TrimmedSupports(), "equilibrium": StaticEquilibrium()}


def truth_of(blocks: tuple[Block, ...], falls: dict[int, tuple[int, ...]]) -> Truth:
    """The blocks, seen by a camera whose y axis points down, numbered from 2."""
    turn = torch.diag(torch.tensor([1.0, -1.0, -1.0], dtype=torch.float64))
    boxes, _ = build(*blocks)
    seen = boxes.rotated(turn)
    objects = []
    for k in range(len(seen)):
        pose = torch.eye(4, dtype=torch.float64)
        pose[:3, :3], pose[:3, 3] = seen.rotation[k], seen.center[k]
        objects.append(
            ObjectTruth(k + 2, "box", seen.half_extent[k], pose, falls_if_removed=falls.get(k + 2, ()))
        )
    return Truth((1,), tuple(objects), torch.tensor([0.0, -1.0, 0.0], dtype=torch.float64), True)


def test_a_stack_is_judged_right_by_all_but_who_says_that_nothing_falls():
    found = removals(truth_of(worlds.STACK, {2: (3,)}), JUDGES)
    right = {"falls_any": Score(2.0, 2), "falls_set": Score(2.0, 2)}
    assert found["paper"] == found["equilibrium"] == found["What can be reached"] == right
    assert found["Nothing falls"]["falls_any"] == Score(1.0, 2)


def test_a_counterweight_is_missed_by_a_search_in_the_graph():
    truth = truth_of(worlds.COUNTERWEIGHT, {2: (3, 4), 3: (4,), 4: (3,)})
    found = removals(truth, JUDGES)
    assert found["paper"]["falls_any"] == found["equilibrium"]["falls_any"] == Score(3.0, 3)
    assert found["What can be reached"]["falls_any"] == Score(2.0, 3)


def test_boxes_stand_on_the_plane_of_the_lowest_corner():
    asked = arrangement_of(truth_of(worlds.STACK, {}))
    assert asked.ground_height == pytest.approx(0.0, abs=1e-12)


def test_truth_without_poses_is_refused():
    truth = truth_of(worlds.STACK, {})
    with pytest.raises(ValueError, match="pose of every object"):
        arrangement_of(replace(truth, objects=(replace(truth.objects[0], pose_camera=None),)))
