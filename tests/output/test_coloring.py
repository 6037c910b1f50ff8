"""Pictures of segments and depth."""

from __future__ import annotations

import torch

from blockstab.output.coloring import (
    DEPTH_RAMP,
    QUALITY_RAMP,
    borders_colored,
    depth_colored,
    depth_range,
    outlined,
    quality_colored,
    tinted,
)

WHITE, RED = [255, 255, 255], [255, 0, 0]
PALETTE = torch.tensor([[0, 0, 0], RED, WHITE], dtype=torch.uint8)


def test_an_outline_lies_just_inside_its_segment() -> None:
    label = torch.zeros(9, 9, dtype=torch.int64)
    label[2:7, 2:7] = 1
    picture = outlined(torch.full((9, 9, 3), 50, dtype=torch.uint8), label, PALETTE, width_px=1)
    red = (picture == PALETTE[1]).all(dim=-1)
    expected = label == 1
    expected[3:6, 3:6] = False
    assert torch.equal(red, expected)
    assert bool((picture[~expected] == 50).all())


def test_segments_that_touch_keep_their_own_colours() -> None:
    label = torch.tensor([[1, 1, 1, 2, 2, 2]]).repeat(4, 1)
    picture = outlined(torch.zeros(4, 6, 3, dtype=torch.uint8), label, PALETTE, width_px=1)
    assert picture[1].tolist() == [[0, 0, 0], [0, 0, 0], RED, WHITE, [0, 0, 0], [0, 0, 0]]


def test_the_border_of_the_image_is_no_outline() -> None:
    color = torch.full((5, 5, 3), 50, dtype=torch.uint8)
    assert torch.equal(outlined(color, torch.ones(5, 5, dtype=torch.int64), PALETTE), color)


def test_drawing_leaves_the_image_as_it_was() -> None:
    color = torch.full((4, 6, 3), 50, dtype=torch.uint8)
    outlined(color, torch.tensor([[1, 1, 1, 2, 2, 2]]).repeat(4, 1), PALETTE)
    assert bool((color == 50).all())


def test_depth_runs_along_the_ramp_and_missing_depth_is_black() -> None:
    depth = torch.tensor([[0.0, 1.0, 1.2, 2.0, 5.0]], dtype=torch.float64)
    missing, near, second, far, beyond = depth_colored(depth, 1.0, 2.0)[0].tolist()
    assert missing == [0, 0, 0]
    assert near == list(DEPTH_RAMP[0])
    assert second == list(DEPTH_RAMP[1])  # a fifth of the way: the ramp has five steps
    assert far == beyond == list(DEPTH_RAMP[-1])


def test_nearer_is_lighter() -> None:
    depth = torch.linspace(1, 2, 50, dtype=torch.float64)[None]
    lightness = depth_colored(depth, 1.0, 2.0).double() @ torch.tensor([0.2126, 0.7152, 0.0722]).double()
    assert bool((lightness.diff(dim=1) < 0).all())


def test_a_stray_depth_does_not_stretch_the_range() -> None:
    depth = torch.linspace(1, 2, 1000, dtype=torch.float64)
    depth[0], depth[-1] = 0.01, 90.0
    near, far = depth_range(depth)
    assert 1.0 <= near < 1.02
    assert 1.98 < far <= 2.0


def test_an_image_without_depth_has_a_range_all_the_same() -> None:
    empty = torch.zeros(3, 3, dtype=torch.float64)
    assert depth_range(empty) == (0.0, 1.0)
    assert not bool(depth_colored(empty, *depth_range(empty)).any())


def test_a_flat_depth_image_has_one_colour() -> None:
    flat = torch.full((3, 3), 1.5, dtype=torch.float64)
    assert len(depth_colored(flat, *depth_range(flat)).flatten(0, 1).unique(dim=0)) == 1


def test_good_is_blue_and_bad_is_red() -> None:
    found = quality_colored(torch.tensor([-0.2, 0.0, 1.0, 1.7], dtype=torch.float64)).tolist()
    assert found == [list(QUALITY_RAMP[0])] * 2 + [list(QUALITY_RAMP[-1])] * 2


def test_a_tint_lies_over_its_segment_alone() -> None:
    color = torch.full((1, 3, 3), 100, dtype=torch.uint8)
    picture = tinted(color, torch.tensor([[0, 1, 2]]), PALETTE, share=0.5)
    assert picture.tolist() == [[[100, 100, 100], [178, 50, 50], [178, 178, 178]]]


def test_a_border_has_the_colour_of_its_pair() -> None:
    label = torch.tensor([[1, 1, 1, 2, 2, 2, 3, 3, 3, 0, 0]]).repeat(3, 1)
    palette = torch.zeros(4, 4, 3, dtype=torch.uint8)
    palette[1, 2] = palette[2, 1] = torch.tensor(RED, dtype=torch.uint8)
    picture = borders_colored(torch.full((3, 11, 3), 50, dtype=torch.uint8), label, palette, width_px=1)
    red = (picture == PALETTE[1]).all(dim=-1)
    assert red[1].tolist() == [False, True, True, True] + [False] * 7
    assert bool((picture[~red] == 50).all())
