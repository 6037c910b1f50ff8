"""Which things are flat, and which of them are found."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor

from blockstab.datasets.truth import Truth
from blockstab.evaluation.scoring import Score
from blockstab.evaluation.scoring.flat import flat_found, flat_objects
from blockstab.evaluation.scoring.prediction import Prediction
from blockstab.rgbd.frame import Camera, Frame

TABLE, PEN, BOX, SHEET = 1, 2, 3, 4
CAMERA = Camera(200.0, 200.0, 79.5, 59.5)
LABEL = torch.full((120, 160), TABLE)
LABEL[20:24, 30:80], LABEL[60:90, 20:60], LABEL[40:80, 100:140] = PEN, BOX, SHEET


def frame(heights: dict[int, float], slope: float = 0.0) -> Frame:
    """Things that rise so far above a table one metre away, which is tilted by so much depth a metre."""
    right = (torch.arange(160).double() - CAMERA.cx) / CAMERA.fx
    depth = (1.0 / (1.0 - slope * right)).repeat(120, 1)
    for one, height in heights.items():
        depth[one == LABEL] -= height
    return Frame("desk", torch.zeros(120, 160, 3, dtype=torch.uint8), depth, CAMERA, LABEL, (TABLE,))


@pytest.mark.parametrize("slope", [0.0, 0.6])
def test_what_rises_by_two_centimetres_at_most_is_flat_on_a_table_however_it_is_turned(slope: float) -> None:
    seen = frame({PEN: 0.008, BOX: 0.1, SHEET: 0.0}, slope)
    assert flat_objects(seen, (PEN, BOX, SHEET)) == [PEN, SHEET]


def test_what_has_no_depth_or_no_table_around_it_is_not_called_flat() -> None:
    seen = frame({PEN: 1.0, SHEET: 0.0})
    assert flat_objects(seen, (PEN, SHEET)) == [SHEET]
    everywhere = Frame("desk", seen.color, seen.depth, CAMERA, torch.full((120, 160), PEN), (TABLE,))
    assert flat_objects(everywhere, (PEN,)) == []


def scored(found: Tensor) -> Score:
    return flat_found(Prediction({}, found), frame({BOX: 0.1}), Truth((TABLE,), (), None, False))


def test_a_flat_thing_is_found_if_one_segment_has_half_of_it_and_little_else() -> None:
    assert scored(LABEL) == Score(2.0, 2)
    assert scored(torch.where(LABEL == PEN, TABLE, LABEL)) == Score(1.0, 2)
    halved = LABEL.clone()
    halved[40:80, 121:140] = 9
    assert scored(halved) == Score(2.0, 2)
    halved[40:80, 119:140] = 9
    halved[40:60, 119:140] = 8
    assert scored(halved) == Score(1.0, 2)


def test_where_no_segment_is_found_no_flat_thing_is() -> None:
    assert scored(torch.zeros_like(LABEL)) == Score(0.0, 2)


def test_where_nothing_is_flat_nothing_is_scored() -> None:
    seen = frame({PEN: 0.1, BOX: 0.1, SHEET: 0.1})
    assert flat_found(Prediction({}, LABEL), seen, Truth((TABLE,), (), None, False)) == Score(0.0, 0)
