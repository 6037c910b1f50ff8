"""Files of a parse, written by hand, against the truth of a scene."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from PIL import Image
from torch import Tensor

from blockstab.datasets.folder import read_truth, write_scene
from blockstab.datasets.truth import MIN_VISIBLE_PX, ObjectTruth, Truth
from blockstab.evaluation.scoring import SCORES, Score, score_scene
from blockstab.rgbd.frame import Camera, Frame, read_scene

TABLE, BLOCK, UPPER, SPECK = 1, 2, 3, 4
ALL = tuple(SCORES)


def picture() -> Tensor:
    """A table, a block of 400 pixels, one of 120 on it, and a speck of 25."""
    label = torch.full((40, 40), TABLE)
    label[15:35, 5:25], label[5:15, 8:20], label[30:35, 30:35] = BLOCK, UPPER, SPECK
    label[0] = 0
    return label


def pose(degrees: float) -> Tensor:
    """At one metre, turned about the optical axis."""
    cos, sin = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    rows = [[cos, -sin, 0, 0], [sin, cos, 0, 0], [0, 0, 1, 1], [0, 0, 0, 1]]
    return torch.tensor(rows, dtype=torch.float64)


TRUTH = Truth(
    background_ids=(TABLE,),
    objects=(
        ObjectTruth(BLOCK, "box", pose_camera=pose(20.0), supported_by=(TABLE,)),
        ObjectTruth(UPPER, "box", pose_camera=pose(0.0), supported_by=(BLOCK,)),
        ObjectTruth(SPECK, "box", pose_camera=pose(70.0), supported_by=(TABLE,)),
    ),
    up_camera=None,
    support_annotated=True,
)
SUPPORTS = ((0, BLOCK, "surface"), (BLOCK, UPPER, "surface"), (0, SPECK, "surface"))


@pytest.fixture
def folders(tmp_path: Path) -> tuple[Path, Path]:
    """The scene, and a parse of it that is right in everything."""
    write_truth(tmp_path / "scene", TRUTH)
    write_parse(tmp_path / "parsed")
    return tmp_path / "scene", tmp_path / "parsed"


def write_truth(folder: Path, truth: Truth, label: Tensor | None = None) -> None:
    depth = torch.ones(40, 40, dtype=torch.float64)
    color = torch.zeros(40, 40, 3, dtype=torch.uint8)
    given = picture() if label is None else label
    write_scene(folder, Frame("scene", color, depth, Camera(40.0, 40.0, 20.0, 20.0), given), truth, {})


def write_parse(
    folder: Path,
    label: Tensor | None = None,
    supports: tuple[tuple[int, int, str], ...] = SUPPORTS,
    falls: dict[int, list[int]] | None = None,
    **changes: dict[int, Any],
) -> None:
    """Write labels.png and scene.json; `changes` sets a key of some segments, by id."""
    folder.mkdir(exist_ok=True)
    label = picture() if label is None else label
    Image.fromarray(label.numpy().astype(np.uint16)).save(folder / "labels.png")
    segments = [
        {
            "id": i,
            "background": i == TABLE,
            "stable": True,
            "verdict": "background" if i == TABLE else "stable",
            "box": {"rotation": pose(degrees)[:3, :3].tolist()},
        }
        for i, degrees in ((TABLE, 0.0), (BLOCK, 20.0), (UPPER, 0.0), (SPECK, 70.0))
    ]
    for key, values in changes.items():
        for segment in segments:
            segment[key] = values.get(segment["id"], segment[key])
    edges = [{"supporter": a, "supported": b, "type": kind} for a, b, kind in supports]
    told = {str(i): fallen for i, fallen in (falls or {}).items()}
    record = {"segments": segments, "supports": edges, "falls_if_removed": told}
    (folder / "scene.json").write_text(json.dumps(record))


def scores_of(folders: tuple[Path, Path], names: tuple[str, ...]) -> dict[str, Score]:
    scene, parsed = folders
    return score_scene(read_scene(scene), read_truth(scene), parsed, names)


def scored(folders: tuple[Path, Path], name: str) -> Score:
    return scores_of(folders, (name,))[name]


def test_a_parse_that_is_right_gets_full_marks_for_what_is_seen_well(folders):
    scores = scores_of(folders, ALL)
    assert scores["axis_error_deg"].total == pytest.approx(0.0, abs=1e-5)
    assert scores["axis_error_deg"].things == 2  # the speck is too small to be scored
    for name in ("support_accuracy", "support_below", "stable_share"):
        assert scores[name] == Score(2.0, 2)
    assert scores["overlap"] == Score(1.0, 1)
    assert int((picture() == SPECK).sum()) < MIN_VISIBLE_PX


def test_only_the_scores_asked_for_are_computed(folders):
    assert list(scores_of(folders, ("overlap", "stable_share"))) == ["overlap", "stable_share"]


def test_axis_errors_are_summed(folders):
    turned = {i: {"rotation": pose(degrees)[:3, :3].tolist()} for i, degrees in ((BLOCK, 29.0), (UPPER, 6.0))}
    write_parse(folders[1], box=turned)
    assert scored(folders, "axis_error_deg").total == pytest.approx((9.0 + 6.0) * 2 / 3)


def test_what_is_no_box_or_has_no_pose_has_no_axes(folders):
    block, upper, speck = TRUTH.objects
    objects = (replace(block, kind="cylinder"), replace(upper, pose_camera=None), speck)
    write_truth(folders[0], replace(TRUTH, objects=objects))
    assert scored(folders, "axis_error_deg") == Score(0.0, 0)


@pytest.mark.parametrize(
    ("supports", "right"),
    [
        (((TABLE, BLOCK, "surface"), (BLOCK, UPPER, "surface")), 2),  # the table is the ground
        (((0, BLOCK, "surface"), (BLOCK, UPPER, "partial")), 2),
        (((0, BLOCK, "surface"), (BLOCK, UPPER, "surface"), (0, UPPER, "surface")), 1),  # one too many
        (((0, BLOCK, "surface"),), 1),  # one missed
        (((UPPER, BLOCK, "surface"), (BLOCK, UPPER, "side")), 1),
        ((), 0),
    ],
)
def test_an_object_is_right_if_all_that_bears_it_is_found_and_nothing_else(folders, supports, right):
    write_parse(folders[1], supports=supports)
    assert scored(folders, "support_accuracy") == Score(float(right), 2)


def test_a_side_support_is_wrong_where_all_supports_count_and_not_where_those_from_below_do(folders):
    write_parse(
        folders[1], supports=((0, BLOCK, "surface"), (BLOCK, UPPER, "surface"), (SPECK, UPPER, "side"))
    )
    assert scored(folders, "support_accuracy") == Score(1.0, 2)
    assert scored(folders, "support_below") == Score(2.0, 2)


def test_what_the_parse_takes_for_background_is_the_ground_too(folders):
    write_parse(
        folders[1], supports=((SPECK, BLOCK, "surface"), (BLOCK, UPPER, "surface")), background={SPECK: True}
    )
    assert scored(folders, "support_accuracy") == Score(2.0, 2)


def test_supports_are_scored_only_where_they_are_annotated(folders):
    write_truth(folders[0], replace(TRUTH, support_annotated=False))
    assert scored(folders, "support_accuracy") == Score(0.0, 0)


def test_what_the_truth_marks_as_hardly_seen_is_not_scored(folders):
    write_truth(
        folders[0], replace(TRUTH, objects=(*TRUTH.objects[:1], replace(TRUTH.objects[1], hardly_seen=True)))
    )
    assert scored(folders, "support_accuracy") == Score(1.0, 1)


def test_unstable_objects_are_counted(folders):
    write_parse(folders[1], stable={UPPER: False, SPECK: False})
    assert scored(folders, "stable_share") == Score(1.0, 2)


def test_what_is_carried_unseen_is_counted_apart(folders):
    write_parse(folders[1], verdict={UPPER: "hidden_support"})
    assert scored(folders, "carried_unseen") == Score(1.0, 2)
    assert scored(folders, "stable_share") == Score(2.0, 2)


def test_a_spoilt_scene_is_found_where_anything_is_unstable(folders):
    assert scored(folders, "spoilt_found") == Score(0.0, 0)
    moving = [replace(one, moves=one.id == UPPER) for one in TRUTH.objects]
    write_truth(folders[0], replace(TRUTH, objects=tuple(moving)))
    assert scored(folders, "spoilt_found") == Score(0.0, 1)
    write_parse(folders[1], stable={BLOCK: False})
    assert scored(folders, "spoilt_found") == Score(1.0, 1)


def test_what_falls_is_compared_thing_by_thing_and_set_by_set(folders):
    fallen = {BLOCK: (UPPER,), UPPER: (), SPECK: ()}
    objects = tuple(replace(one, falls_if_removed=fallen[one.id]) for one in TRUTH.objects)
    write_truth(folders[0], replace(TRUTH, objects=objects))
    write_parse(folders[1], falls={BLOCK: [UPPER]})
    for name in ("falls_any", "falls_set", "reachable_any", "reachable_set"):
        assert scored(folders, name) == Score(2.0, 2)
    assert scored(folders, "nothing_any") == Score(1.0, 2)
    write_parse(folders[1], falls={UPPER: [BLOCK]})
    assert scored(folders, "falls_any") == Score(0.0, 2)
    write_parse(folders[1], falls={BLOCK: [UPPER, SPECK], UPPER: []})
    assert scored(folders, "falls_set") == Score(2.0, 2)  # the speck is hardly seen, and not asked about


def test_segments_stand_for_the_things_that_they_share_half_with(folders):
    objects = tuple(
        replace(one, falls_if_removed=(UPPER,) if one.id == BLOCK else ()) for one in TRUTH.objects
    )
    write_truth(folders[0], replace(TRUTH, objects=objects))
    renamed = torch.tensor([0, TABLE, UPPER, BLOCK, SPECK])[picture()]
    write_parse(folders[1], label=renamed, falls={UPPER: [BLOCK]})
    assert scored(folders, "falls_set") == Score(2.0, 2)
    write_parse(folders[1], label=torch.where(picture() == TABLE, TABLE, SPECK), falls={SPECK: []})
    assert scored(folders, "falls_any") == Score(1.0, 2)  # of what no segment stands for, nothing is told


def test_overlap_is_over_objects_not_background(folders):
    label = picture()
    label[label == UPPER] = BLOCK  # 400 of 520, and 120 of 520
    write_parse(folders[1], label=label)
    best = 400 * 400 / 520 + 120 * 120 / 520
    assert scored(folders, "overlap") == Score(pytest.approx(best / 520), 1)


def test_images_in_which_nothing_touches_are_left_out_of_what_touches(folders):
    assert scored(folders, "overlap_touching") == scored(folders, "overlap") == Score(1.0, 1)
    apart = picture()
    apart[14] = TABLE
    write_truth(folders[0], TRUTH, apart)
    assert scored(folders, "overlap_touching") == Score(0.0, 0)
    assert scored(folders, "overlap").things == 1


def test_a_scene_without_labels_cannot_be_scored(folders):
    (folders[0] / "label.png").unlink()
    with pytest.raises(ValueError, match="scene has no labels"):
        scores_of(folders, ALL)


def test_a_scene_without_listed_objects_is_scored_by_its_labels_alone(folders):
    write_truth(folders[0], replace(TRUTH, objects=()))
    scores = scores_of(folders, ALL)
    by_labels = {
        "overlap",
        "overlap_plain",
        "overlap_touching",
        "overlap_f",
        "boundary_f",
        "detected",
        "flat_found",
    }
    assert {name for name, score in scores.items() if score.things} == by_labels


def test_what_is_found_perfectly_scores_one_and_background_is_no_wrong_object(folders):
    names = ("overlap", "overlap_plain", "overlap_f", "boundary_f", "detected")
    assert [scored(folders, name) for name in names] == [Score(pytest.approx(1.0), 1)] * 5
