"""What surfaces send to the eye under a known lamp."""

from __future__ import annotations

import pytest
import torch

from blockstab.simulation.appearance.lighting import draw_lamps, gloss, lit
from blockstab.simulation.appearance.noise import SolidNoise
from tests.simulation.scenery import lamps_at, of_one_part, scenery, standing


def test_what_faces_the_lamp_is_brighter_and_the_sky_lights_what_is_in_shadow() -> None:
    lamps, white = lamps_at(1.0), torch.ones(3, 3)
    normals = torch.tensor([[0.7071, 0.7071, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    share = torch.tensor([[1.0, 1, 1, 1], [1.0, 1, 1, 1], [0.0, 0, 1, 1]])
    light = lit(white, normals, torch.zeros(3, 3), share, lamps)[:, 0]
    assert light[0] > light[1] > light[2]
    assert float(light[2]) == pytest.approx(0.2, abs=1e-5)
    assert float(light[1]) == pytest.approx(0.2 + 0.7071, abs=1e-3)


def test_gloss_is_strongest_where_the_lamp_is_mirrored(generator: torch.Generator) -> None:
    lamps, eye = lamps_at(1.0), torch.tensor([-1.0, 1.0, 0.0])
    points = torch.tensor([[0.0, 0.0, 0.0], [0.4, 0.0, 0.0], [0.0, 0.0, 0.0]])
    finish = torch.tensor([[1.0, 80.0, 0.0], [1.0, 80.0, 0.0], [0.0, 80.0, 0.0]])
    up = torch.tensor([[0.0, 1.0, 0.0]]).expand(3, 3)
    light = gloss(torch.ones(3, 3), finish, up, points, eye, torch.ones(3, 4), lamps, SolidNoise(generator))[
        :, 0
    ]
    assert light[0] > 2 * light[1] > 0
    assert light[2] == 0


def test_without_variety_the_light_is_white_and_the_same_every_time() -> None:
    scene = scenery(standing((of_one_part("box", (0.05, 0.1, 0.05), "block"), 0.0, 0.0)), 2)
    middle = torch.zeros(3, dtype=torch.float64)
    first, second = (draw_lamps(scene.view, middle, 0.0, torch.Generator().manual_seed(s)) for s in (1, 2))
    assert torch.equal(first.position, second.position)
    assert first.color[0].tolist() == [1.0, 1.0, 1.0]
    assert first.color[1].sum() == 0
    varied = [draw_lamps(scene.view, middle, 1.0, torch.Generator().manual_seed(s)) for s in range(20)]
    assert all(float(lamps.position[:, 1].min()) > 0.5 for lamps in varied)
    reds = torch.stack([lamps.color[0, 0] / lamps.color[0, 2] for lamps in varied])
    assert reds.min() < 0.9
    assert reds.max() > 1.4
