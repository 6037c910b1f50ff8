"""What a box says of its segment: by hand, and against the outline of the box drawn in the image."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
import torch
from shapely import MultiPoint
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.features.box_shape import BOX_SHAPE_COLUMNS, box_shape
from blockstab.rgbd.frame import Camera
from blockstab.rgbd.ground import Ground, world_from_camera
from tests.tolerance import COMPANY, EXACT

CAMERA = Camera(200.0, 220.0, 80.0, 60.0)
TILT = torch.tensor(0.5, dtype=torch.float64)
UP = torch.stack([TILT * 0.0, -TILT.cos(), -TILT.sin()])
GROUND = Ground(UP, world_from_camera(UP), -0.6, 1.0)


def boxes_before_the_camera(count: int, generator: torch.Generator) -> Boxes:
    """Boxes of any direction and size, some way off, in the world frame."""
    rotation = torch.linalg.qr(torch.randn(count, 3, 3, generator=generator, dtype=torch.float64)).Q
    rotation = rotation * rotation.det()[:, None, None].sign()
    place = torch.rand(count, 3, generator=generator, dtype=torch.float64) - 0.5
    center = (place + place.new_tensor([0.0, 0.0, 2.0])) @ GROUND.world_from_camera.T
    half = 0.02 + 0.2 * torch.rand(count, 3, generator=generator, dtype=torch.float64)
    return Boxes(center, rotation, half)


def named(boxes: Boxes, pixels: Tensor, ground: Ground = GROUND) -> dict[str, Tensor]:
    return dict(zip(BOX_SHAPE_COLUMNS, box_shape(boxes, pixels, CAMERA, ground).T, strict=True))


def test_every_column_of_boxes_worked_by_hand():
    down = torch.diag(torch.tensor([1.0, -1.0, -1.0], dtype=torch.float64))
    level = Ground(down[1], down, -0.6, 1.0)
    center, half = torch.tensor([[[0.0, -0.5, -2.0]], [[0.2, 0.1, 0.05]]], dtype=torch.float64)
    box = Boxes(center, torch.eye(3, dtype=torch.float64)[None], half)
    values = named(box, torch.tensor([300]), level)
    assert [float(values[f"size_{n}"]) for n in ("least", "middle", "greatest")] == pytest.approx(
        [0.1, 0.2, 0.4]
    )
    assert float(values["volume_log"]) == pytest.approx(math.log(0.1 * 0.2 * 0.4))
    assert [float(values[n]) for n in ("bottom", "top")] == pytest.approx([0.0, 0.2], abs=EXACT)
    # Seen from above, at y -0.4 and -0.6: from the far upper edge, 2.05 m off, to the near lower one.
    left, right = (200 * 0.2 / d for d in (2.05, 1.95))
    upper, near, lower = 220 * 0.4 / 2.05, 220 * 0.4 / 1.95, 220 * 0.6 / 1.95
    covered = (left + right) * (near - upper) + 2 * right * (lower - near)
    assert float(values["fill_of_box"]) == pytest.approx(300 / covered)


def test_the_outline_of_a_box_in_the_image_is_the_hull_of_its_corners(generator):
    boxes = boxes_before_the_camera(12, generator)
    pixels = torch.arange(100, 112)
    fill = named(boxes, pixels)["fill_of_box"]
    for k, corners in enumerate(boxes.corners()):
        seen = corners @ GROUND.world_from_camera
        u = CAMERA.fx * seen[:, 0] / seen[:, 2] + CAMERA.cx
        v = CAMERA.fy * seen[:, 1] / seen[:, 2] + CAMERA.cy
        outline = MultiPoint(torch.stack([u, v], dim=1).numpy()).convex_hull
        assert float(fill[k]) == pytest.approx(float(pixels[k]) / outline.area)


def test_turning_the_world_about_the_vertical_changes_nothing(generator):
    boxes, pixels = boxes_before_the_camera(12, generator), torch.full((12,), 500)
    turn = torch.tensor([[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [-0.8, 0.0, 0.6]], dtype=torch.float64)
    ground = replace(GROUND, world_from_camera=turn @ GROUND.world_from_camera)
    before, after = (
        box_shape(b, pixels, CAMERA, g) for b, g in ((boxes, GROUND), (boxes.rotated(turn), ground))
    )
    torch.testing.assert_close(after, before, rtol=0.0, atol=EXACT)


def test_neither_the_names_of_axes_nor_the_company_of_boxes_matter(generator):
    boxes, pixels = boxes_before_the_camera(12, generator), torch.full((12,), 500)
    order = torch.tensor([1, 2, 0])
    renamed = replace(boxes, rotation=boxes.rotation[:, :, order], half_extent=boxes.half_extent[:, order])
    rows = box_shape(boxes, pixels, CAMERA, GROUND)
    torch.testing.assert_close(box_shape(renamed, pixels, CAMERA, GROUND), rows, rtol=0.0, atol=EXACT)
    alone = [box_shape(boxes[k : k + 1], pixels[:1], CAMERA, GROUND) for k in range(12)]
    torch.testing.assert_close(torch.cat(alone), rows, rtol=0.0, atol=COMPANY)


def test_without_a_ground_heights_are_those_of_the_world_frame(generator):
    boxes, pixels = boxes_before_the_camera(5, generator), torch.full((5,), 500)
    adrift = named(boxes, pixels, replace(GROUND, height=None))
    level = named(boxes, pixels)
    for name in ("bottom", "top"):
        torch.testing.assert_close(adrift[name], level[name] - 0.6, rtol=0.0, atol=EXACT)


def test_a_box_around_the_camera_or_of_no_volume_has_finite_columns():
    eye = torch.eye(3, dtype=torch.float64)
    half = torch.tensor([[3.0, 3.0, 3.0], [1e-9, 1e-9, 1e-9]], dtype=torch.float64)
    rows = box_shape(
        Boxes(torch.zeros(2, 3).double(), eye.expand(2, 3, 3), half), torch.ones(2), CAMERA, GROUND
    )
    assert bool(rows.isfinite().all())
