"""Moves made at once are the same as one after the other, where they do not touch."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
import torch

from blockstab.search.combining import Exchange, combined, exchange
from blockstab.segments.segmentation import Segmentation

A, B, C, D, E, F = (frozenset({k}) for k in range(6))
START = Segmentation((A, B, C, D, E, F)).telling({A: True})


def rated(segmentation: Segmentation, energy: float):
    """As much of a rating as is looked at."""
    return SimpleNamespace(
        scene=SimpleNamespace(segmentation=segmentation), energy=torch.tensor(energy, dtype=torch.float64)
    )


def merged(i: int, j: int) -> Segmentation:
    return START.merge(i, j)


def test_what_changes_is_what_goes_and_what_comes():
    assert exchange(START, merged(2, 3)) == Exchange(frozenset({C, D}), frozenset({C | D}))
    assert exchange(START, START.telling({B: True})) == Exchange(frozenset({B}), frozenset({B}))
    assert exchange(START, START) == Exchange(frozenset(), frozenset())


def test_moves_that_do_not_touch_are_all_made():
    turned = START.telling({F: True})
    result = combined(
        rated(START, 1.0), [rated(merged(1, 2), 0.9), rated(merged(3, 4), 0.8), rated(turned, 0.7)], 9
    )
    assert result == Segmentation((A, B | C, D | E, F)).telling({A: True, F: True})


def test_of_moves_that_touch_the_one_that_gains_most_is_made():
    one, better, apart = rated(merged(1, 2), 0.9), rated(merged(2, 3), 0.8), rated(merged(4, 5), 0.95)
    assert combined(rated(START, 1.0), [one, better, apart], 9) == START.merge(2, 3).merge(3, 4)


@pytest.mark.parametrize("most", [1, 2, 3])
def test_no_more_moves_are_made_than_allowed(most: int):
    children = [rated(merged(0, 1), 0.9), rated(merged(2, 3), 0.8), rated(merged(4, 5), 0.7)]
    result = combined(rated(START, 1.0), children, most)
    assert (result is None) if most == 1 else (result is not None and len(result) == 6 - most)


def test_moves_that_gain_nothing_are_not_made():
    worse = [rated(merged(1, 2), 1.0), rated(merged(3, 4), 1.1)]
    assert combined(rated(START, 1.0), [*worse, rated(merged(4, 5), 0.9)], 9) is None
    assert combined(rated(START, 1.0), [], 9) is None


def test_what_is_told_of_what_stays_and_of_what_comes_stays_told():
    start = START.telling({B: True, C: True, D: False})
    children = [rated(start.merge(1, 2), 0.5), rated(start.merge(4, 5), 0.6)]
    result = combined(rated(start, 1.0), children, 9)
    assert result is not None
    assert result.background == {A: True, B | C: True, D: False}
