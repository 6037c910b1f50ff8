"""Which gaps close, and with what."""

from __future__ import annotations

import pytest
import torch

from blockstab.segments.gaps import enclosed, fill_gaps, without_gaps


@pytest.mark.parametrize(("width", "closes"), [(1, True), (6, True), (7, False)])
def test_a_gap_closes_up_to_twice_the_reach(width: int, closes: bool) -> None:
    mask = torch.ones(30, 40, dtype=torch.bool)
    mask[:, 10 : 10 + width] = False
    assert bool(without_gaps(mask).all()) is closes


def test_the_outside_of_a_shape_does_not_grow() -> None:
    mask = torch.zeros(40, 40, dtype=torch.bool)
    mask[12:28, 10:30] = True
    assert torch.equal(without_gaps(mask), mask)


def test_a_gap_is_filled_from_the_nearer_label() -> None:
    label = torch.zeros(20, 12, dtype=torch.int64)
    label[:, :4], label[:, 8:] = 7, 300
    filled = fill_gaps(label)
    assert bool((filled[:, 4:6] == 7).all())
    assert bool((filled[:, 6:8] == 300).all())
    assert torch.equal(filled[label > 0], label[label > 0])


def test_filling_leaves_its_input_alone() -> None:
    label = torch.ones(9, 9, dtype=torch.int64)
    label[4, 4] = 0
    before = label.clone()
    assert bool((fill_gaps(label) == 1).all())
    assert torch.equal(label, before)


def test_an_image_without_labels_stays_empty() -> None:
    assert not fill_gaps(torch.zeros(8, 8, dtype=torch.int64)).any()


def test_what_touches_the_rim_of_the_image_is_not_enclosed() -> None:
    mask = torch.zeros(12, 12, dtype=torch.bool)
    mask[0, :4] = mask[3:6, 3:6] = mask[6, 6] = mask[8:, 8:] = (
        True  # the single pixel touches by corners alone
    )
    wanted = torch.zeros_like(mask)
    wanted[3:6, 3:6] = wanted[6, 6] = True
    assert torch.equal(enclosed(mask), wanted)
