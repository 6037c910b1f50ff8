"""What is to be seen on the furniture."""

from __future__ import annotations

import numpy as np
import torch

from blockstab.simulation.appearance import furniture
from blockstab.simulation.appearance.meshes import Patch

PLAIN = (180, 160, 140)
TOP = Patch("box", 2, 1.6, 1.2)


def shares(images: list[np.ndarray]) -> list[float]:
    """The share of each image that is not plain."""
    return [float((np.asarray(image) != PLAIN).any(axis=-1).mean()) for image in images]


def test_most_tables_are_bare_and_some_have_flat_things_on_them(generator: torch.Generator) -> None:
    tops = shares([furniture.table_top(TOP, PLAIN, generator).image for _ in range(30)])
    assert 5 < sum(share > 0 for share in tops) < 25
    assert max(tops) < 0.25


def test_a_floor_repeats_without_a_seam_of_its_own(generator: torch.Generator) -> None:
    for _ in range(6):
        tones = np.asarray(furniture.floor(PLAIN, generator).image).astype(int)
        assert tones.shape[0] == tones.shape[1]
        # Boards run along the rows: from the right edge on to the left one they keep their tone.
        across = np.abs(tones[:, -4] - tones[:, 3]).max(axis=-1)
        assert (across > 12).mean() < 0.35


def test_walls_and_cabinets_are_mostly_of_their_own_colour(generator: torch.Generator) -> None:
    fronts = [furniture.drawers(Patch("box", 4, 1.0, 0.8), PLAIN, generator).image for _ in range(5)]
    for share in shares(fronts):
        assert 0.01 < share < 0.3
    wall = np.asarray(furniture.wall(Patch("box", 4, 8.0, 4.0), PLAIN, generator).image).astype(int)
    assert (np.abs(wall - PLAIN).max(axis=-1) < 90).mean() > 0.8
