"""What is printed on the faces of cartons and books."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray

from blockstab.simulation.appearance import covers
from blockstab.simulation.appearance.covers import Palette
from blockstab.simulation.appearance.lettering import Sheet
from blockstab.simulation.appearance.meshes import Patch

PALETTE = Palette((150, 40, 44), (196, 152, 62), (46, 66, 112))
FACES = [
    Patch("box", face, *size)
    for face, size in enumerate([(0.03, 0.24)] * 2 + [(0.17, 0.03)] * 2 + [(0.17, 0.24)] * 2)
]


def tones(sheet: Sheet) -> NDArray[np.int64]:
    return np.asarray(sheet.image).astype(np.int64)


def test_a_book_has_two_covers_a_spine_and_pages_on_the_other_three_sides(generator: torch.Generator) -> None:
    sides = [covers.book(patch, (2, 0), PALETTE, generator) for patch in FACES]
    pale = [float(np.median(tones(sheet).min(axis=2))) > 130 for sheet in sides]
    assert pale == [True, False, True, True, False, False]
    # Sheets of paper: stripes that run along the pages, between two thin lines of cover.
    pages = tones(sides[0]).mean(axis=2)
    assert pages.std(axis=1).mean() > 5 * pages.std(axis=0).mean()
    assert (pages[:, [0, -1]] < 100).all()


def test_a_parcel_is_brown_all_round(generator: torch.Generator) -> None:
    for patch in FACES:
        red, _, blue = np.median(tones(covers.parcel(patch, 0.5, PALETTE, generator)).reshape(-1, 3), axis=0)
        assert red > 1.4 * blue
