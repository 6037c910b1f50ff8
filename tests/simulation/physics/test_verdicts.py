"""Boxes that are let go, what the engine saw, and what the rule says."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import torch

from blockstab.boxes.box import Boxes
from blockstab.simulation.physics.verdicts import draw_verdict, judged, read_verdict, write_verdicts
from blockstab.stability.judges import StabilityJudge, StaticEquilibrium, TrimmedSupports

pytest.importorskip("mujoco", reason="the extra `sim` is not installed")


def stack(*rows: tuple[float, float, float, float]) -> Boxes:
    """Upright boxes from x, height of the lower face, half width and half height, metres."""
    values = torch.tensor(rows, dtype=torch.float64)
    x, bottom, wide, tall = values.unbind(dim=1)
    zero = torch.zeros_like(x)
    axes = torch.eye(3, dtype=torch.float64).repeat(len(values), 1, 1)
    return Boxes(torch.stack([x, bottom + tall, zero], dim=1), axes, torch.stack([wide, tall, wide], dim=1))


EACH = pytest.mark.parametrize(
    "judge", [TrimmedSupports(), StaticEquilibrium()], ids=lambda j: type(j).__name__
)


@EACH
def test_a_box_stands_whose_centre_is_over_the_one_below_and_no_other(judge: StabilityJudge) -> None:
    base = (0.0, 0.0, 0.05, 0.05)
    assert judged(stack(base, (0.049, 0.1, 0.05, 0.05)), judge).tolist() == [True, True]
    assert judged(stack(base, (0.051, 0.1, 0.05, 0.05)), judge).tolist() == [True, False]


@EACH
def test_boxes_a_centimetre_apart_do_not_hold_each_other(judge: StabilityJudge) -> None:
    assert judged(stack((0.0, 0.0, 0.05, 0.05), (0.0, 0.11, 0.05, 0.05)), judge).tolist() == [True, False]


def test_static_equilibrium_says_of_nearly_all_boxes_what_the_engine_sees_and_more_than_the_rule() -> None:
    verdicts = [draw_verdict(3, i) for i in range(40)]
    agreeing = [
        torch.cat([judged(v.boxes, judge) != v.moved for v in verdicts]).double().mean()
        for judge in (TrimmedSupports(), StaticEquilibrium())
    ]
    assert agreeing[1] >= 0.97 > agreeing[0]


def test_a_verdict_survives_the_disk_and_a_second_run_keeps_it(tmp_path: Path) -> None:
    first, second = write_verdicts(tmp_path, 2, seed=5)
    drawn, read = draw_verdict(5, 1), read_verdict(second)
    assert torch.equal(read.boxes.center, drawn.boxes.center)
    assert torch.equal(read.boxes.rotation, drawn.boxes.rotation)
    assert torch.equal(read.moved, drawn.moved)
    kept = first.stat().st_ino
    write_verdicts(tmp_path, 2, seed=5)
    assert first.stat().st_ino == kept
    write_verdicts(tmp_path, 1, seed=6)
    assert first.stat().st_ino != kept


def test_verdicts_do_not_depend_on_the_number_of_jobs(tmp_path: Path) -> None:
    one, two = write_verdicts(tmp_path / "1", 3, seed=2), write_verdicts(tmp_path / "2", 3, seed=2, jobs=2)
    assert [f.read_bytes() for f in one] == [f.read_bytes() for f in two]


def test_some_arrangements_fall_and_some_stand() -> None:
    fallen = [bool(draw_verdict(1, i).moved.any()) for i in range(20)]
    assert 4 <= sum(fallen) <= 16


@pytest.mark.parametrize(
    "change",
    [
        {"moved": [True]},
        {"center": "x"},
        {"half_extent": [[0, 0, 0]]},
        {"rotation": None},
        {"center": [10**400]},
    ],
)
def test_a_damaged_verdict_is_one_line(tmp_path: Path, change: dict[str, object]) -> None:
    (file,) = write_verdicts(tmp_path, 1, seed=5)
    file.write_text(json.dumps({**json.loads(file.read_text()), **change}))
    with pytest.raises(ValueError, match=r"verdict_0000\.json: must hold boxes") as caught:
        read_verdict(file)
    assert "\n" not in str(caught.value)


def test_another_file_is_not_overwritten(tmp_path: Path) -> None:
    (tmp_path / "verdict_0000.json").write_text('{"mine": 1}')
    with pytest.raises(ValueError, match="exists and is no arrangement"):
        write_verdicts(tmp_path, 1, seed=5)
