"""The figure to turn by hand."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest
import torch

from blockstab.output.figures.boxes import CLOUD_POINTS, boxes_figure
from blockstab.output.figures.marks import RED
from blockstab.parsing.parsed import Parsed
from blockstab.rgbd.cloud import Cloud
from tests.output.figures.drawn import checked
from tests.table_scene import BLOCK, parsed_table


@pytest.fixture
def parsed() -> Parsed:
    return parsed_table()


def test_each_object_has_a_wireframe_that_is_red_where_unstable(parsed: Parsed) -> None:
    frames = {t.name: t for t in checked(boxes_figure)(parsed).data if t.name.startswith("box")}
    assert set(frames) == {"box 2", "box 40", "box 5"}
    assert [name for name, trace in frames.items() if trace.line.color == RED] == ["box 40"]


def test_a_wireframe_is_the_twelve_edges_of_its_box(parsed: Parsed) -> None:
    trace = _named(checked(boxes_figure)(parsed), "box 2")
    lines = torch.stack([torch.as_tensor(getattr(trace, axis)) for axis in "xyz"], dim=1).unflatten(
        0, (12, 3)
    )
    assert bool(lines[:, 2].isnan().all())
    expected = parsed.scene.boxes[[BLOCK]].edges()[0]
    torch.testing.assert_close(lines[:, :2].double(), expected, atol=1e-6, rtol=0)  # drawn in float32


def test_the_first_view_is_from_the_side_of_the_camera(parsed: Parsed) -> None:
    scene = checked(boxes_figure)(parsed).layout.scene
    middle = torch.tensor([sum(getattr(scene, f"{a}axis").range) / 2 for a in "xyz"]).double()
    eye = torch.tensor([getattr(scene.camera.eye, a) for a in "xyz"]).double()
    cosine = torch.nn.functional.cosine_similarity(eye, -middle, dim=0)
    assert math.degrees(math.acos(float(cosine))) < 12
    up = scene.camera.up
    assert (up.x, up.y, up.z) == (0, 1, 0)
    assert (
        len({round(r[1] - r[0], 9) for r in (scene.xaxis.range, scene.yaxis.range, scene.zaxis.range)}) == 1
    )


def test_a_large_cloud_is_thinned(parsed: Parsed) -> None:
    high, wide = 480, 640
    points = parsed.scene.boxes.center[BLOCK].expand(high, wide, 3)
    valid = torch.ones(high, wide, dtype=torch.bool)
    large = replace(
        parsed,
        cloud=Cloud(points, torch.zeros_like(points), valid, torch.ones(high, wide).double()),
        frame=replace(parsed.frame, color=torch.zeros(high, wide, 3, dtype=torch.uint8)),
    )
    count = len(_named(checked(boxes_figure)(large), "cloud").x)
    assert CLOUD_POINTS / 2 < count <= 1.05 * CLOUD_POINTS


def test_the_cloud_far_from_the_objects_is_left_out(parsed: Parsed) -> None:
    points = parsed.cloud.points.clone()
    points[12, 0] = torch.tensor([50.0, 0.0, 0.0])
    figure = checked(boxes_figure)(replace(parsed, cloud=replace(parsed.cloud, points=points)))
    assert float(max(_named(figure, "cloud").x)) < 10


def _named(figure: Any, name: str) -> Any:
    return next(trace for trace in figure.data if trace.name.startswith(name))
