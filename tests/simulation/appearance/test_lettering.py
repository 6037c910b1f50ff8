"""What a printer can put on paper."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from blockstab.simulation.appearance.lettering import DOT, Place, Sheet, legible, shaded

WHITE = (255, 255, 255)
MIDDLE = Place(0.25, 0.25, 0.5, 0.5)


def inked(sheet: Sheet) -> np.ndarray:
    """Where (h, w) bool the sheet is no longer white."""
    return (np.asarray(sheet.image) != 255).any(axis=-1)


def test_a_sheet_has_its_size_in_dots() -> None:
    assert Sheet(0.1, 0.2, WHITE).size == (round(0.1 / DOT), round(0.2 / DOT))


@pytest.mark.parametrize("kind", ["word", "small_print", "picture", "bar_code"])
def test_print_stays_in_its_place_and_leaves_ink_there(kind: str, generator: torch.Generator) -> None:
    sheet = Sheet(0.1, 0.1, WHITE)
    if kind in ("word", "small_print"):
        getattr(sheet, kind)(MIDDLE, (0, 0, 0), generator)
    else:
        getattr(sheet, kind)(MIDDLE, generator)
    ink = inked(sheet)
    assert ink[50:151, 50:151].mean() > 0.05
    ink[50:151, 50:151] = False
    assert not ink.any()


def test_rows_of_small_print_have_gaps_between_them_and_ragged_ends(generator: torch.Generator) -> None:
    sheet = Sheet(0.1, 0.1, WHITE)
    sheet.small_print(Place(0.0, 0.0, 1.0, 1.0), (0, 0, 0), generator)
    share = inked(sheet).mean(axis=1)
    rows = np.flatnonzero((share[1:] > 0) & (share[:-1] == 0))
    assert len(rows) > 10
    ends = {int(np.flatnonzero(inked(sheet)[row + 3]).max()) for row in rows}
    assert len(ends) > len(rows) / 3


def test_a_fade_goes_to_the_colour_on_the_side_it_is_turned_to() -> None:
    for turn, (row, column) in enumerate(((-1, 50), (50, -1), (0, 50), (50, 0))):
        sheet = Sheet(0.05, 0.05, WHITE)
        sheet.fade((0, 0, 0), 1.0, turn)
        tones = np.asarray(sheet.image)[..., 0]
        assert tones[row, column] < 10
        assert tones[::-1, ::-1][row, column] > 240


def test_ink_shows_on_its_ground(generator: torch.Generator) -> None:
    for ground in ((20, 20, 20), (230, 220, 210), (150, 40, 44), (46, 66, 112)):
        assert abs(sum(legible(ground, generator)) - sum(ground)) > 200
    assert shaded((100, 200, 10), 1.5) == (150, 255, 15)
