"""What is printed on round things."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray

from blockstab.simulation.appearance import wraps
from blockstab.simulation.appearance.covers import Palette
from blockstab.simulation.appearance.lettering import Sheet
from blockstab.simulation.appearance.meshes import Patch
from blockstab.simulation.appearance.wraps import METAL

PALETTE = Palette((150, 40, 44), (196, 152, 62), (46, 66, 112))


def tones(sheet: Sheet) -> NDArray[np.int64]:
    return np.asarray(sheet.image).astype(np.int64)


def test_the_label_of_a_tin_has_its_front_twice_and_a_metal_rim(generator: torch.Generator) -> None:
    label = tones(wraps.label_round(Patch("cylinder", 0, 0.24, 0.1), PALETTE, generator))
    half = label.shape[1] // 2
    assert (label[:, :half] == label[:, half : 2 * half]).all()
    assert (label[0] == METAL).all()
    assert (label[-1] == METAL).all()


def test_a_bottle_has_a_label_round_its_body_and_a_cap_on_its_neck(generator: torch.Generator) -> None:
    body, shoulder, neck = (
        Patch("cylinder", 0, 0.25, 0.2),
        Patch("hull", 0, 0.25, 0.05),
        Patch("cylinder", 0, 0.1, 0.05),
    )
    label, plain, cap = (
        tones(wraps.bottle(patch, patch is neck, PALETTE, generator)) for patch in (body, shoulder, neck)
    )
    assert len(np.unique(label.reshape(-1, 3), axis=0)) > 2
    assert (label[0] == PALETTE.ground).all()
    assert (plain == PALETTE.ground).all()
    assert (cap[0] == PALETTE.third).all()
    assert (cap[-1] == PALETTE.ground).all()


def test_a_ball_has_seams_that_are_dark_and_thin(generator: torch.Generator) -> None:
    sheet = tones(wraps.ball(Patch("sphere", 0, 0.4, 0.2), PALETTE, generator))
    seam = (sheet.sum(axis=2) < 0.5 * min(sum(PALETTE.ground), sum(PALETTE.accent))).mean()
    assert 0.005 < seam < 0.12
