"""The price of leaving a start: what is paid for, and what is not."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from blockstab.energy.caution import Caution
from blockstab.segments.segmentation import Segmentation
from tests.box_scene import scene_of
from tests.energy.test_overlap import ROW
from tests.tolerance import EXACT

PIXELS = [300, 120, 80]
TOTAL = sum(PIXELS)


def scene(parts, background):
    """A scene of these sets of the atoms 0, 1 and 2, and which of them are background."""
    segments = tuple(frozenset(part) for part in parts)
    sizes = [sum(PIXELS[atom] for atom in part) for part in segments]
    made = scene_of(*ROW[: len(segments)], pixels=sizes)
    told = frozenset(zip(segments, background, strict=True))
    return replace(made, segmentation=Segmentation(segments, told), background=torch.tensor(background))


def price(start, after):
    return Caution(start.segmentation, PIXELS, caution=0.1, turning=0.3)(after) * TOTAL


APART = scene([{0}, {1}, {2}], [False, False, False])
ON_TABLE = scene([{0}, {1}, {2}], [True, False, False])


def test_the_start_is_free():
    assert price(APART, APART) == price(ON_TABLE, ON_TABLE) == 0.0


def test_an_object_that_the_start_does_not_have_costs_caution():
    assert price(APART, scene([{0}, {1, 2}], [False, False])) == pytest.approx(0.1 * 200, abs=EXACT)
    assert price(APART, scene([{0, 1, 2}], [False])) == pytest.approx(0.1 * TOTAL, abs=EXACT)


def test_a_thing_that_becomes_background_costs_turning_and_background_that_becomes_a_thing_caution():
    assert price(APART, ON_TABLE) == pytest.approx(0.3 * 300, abs=EXACT)
    assert price(ON_TABLE, APART) == pytest.approx(0.1 * 300, abs=EXACT)


def test_of_background_that_takes_a_thing_in_only_the_thing_is_paid_for():
    assert price(ON_TABLE, scene([{0, 1}, {2}], [True, False])) == pytest.approx(0.3 * 120, abs=EXACT)


def test_what_is_left_of_background_that_a_thing_is_carved_from_is_free():
    start = scene([{0, 1}, {2}], [True, False])
    carved = scene([{0}, {1}, {2}], [True, False, False])
    assert price(start, carved) == pytest.approx(0.1 * 120, abs=EXACT)
    assert price(start, scene([{0}, {1}, {2}], [True, True, False])) == 0.0


def test_the_price_is_a_share_of_all_pixels_and_nothing_has_no_price():
    half = Caution(APART.segmentation, PIXELS, caution=0.5, turning=0.0)
    assert half(scene([{0, 1, 2}], [False])) == pytest.approx(0.5, abs=EXACT)
