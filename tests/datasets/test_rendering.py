"""The picture of a pile that is known."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pytest
import torch

from blockstab.boxes.box import Boxes
from blockstab.datasets.rendering import TABLE, photograph
from blockstab.datasets.viewpoint import draw_view
from blockstab.rgbd.frame import Frame

Upright = Callable[[Sequence[tuple[float, ...]]], Boxes]


@pytest.fixture(scope="module")
def pictures(upright: Upright) -> list[Frame]:
    """One block by itself, from four sides."""
    pile = upright([(0.0, 0.1, 0.0, 0.05, 0.1, 0.05)])
    generators = [torch.Generator().manual_seed(seed) for seed in range(4)]
    return [photograph("one", pile, draw_view(g, pile), g) for g in generators]


def test_the_block_has_label_2_and_covers_the_middle(pictures: list[Frame]) -> None:
    for frame in pictures:
        assert frame.label is not None
        assert frame.label[240, 320] == 2
        assert 2 not in frame.background_ids
        assert frame.background_ids[0] == TABLE
        assert set(frame.background_ids) in ({1, 3}, {1, 3, 4})


def test_the_projector_s_shadow_falls_to_the_left_of_the_block(pictures: list[Frame]) -> None:
    left = right = 0  # holes on the right are faces seen at a grazing angle
    for frame in pictures:
        assert frame.label is not None
        rows, columns = (frame.label == 2).nonzero().unbind(dim=1)
        beside = frame.depth[rows.min() : rows.max(), columns.min() - 40 : columns.max() + 40] == 0
        across = torch.arange(beside.shape[1]) + columns.min() - 40 - columns.double().mean()
        left += int(beside[:, across < 0].sum())
        right += int(beside[:, across > 0].sum())
    assert left > 2 * right


def test_equal_generators_take_equal_pictures(upright: Upright) -> None:
    pile = upright([(0.0, 0.1, 0.0, 0.05, 0.1, 0.05)])
    view = draw_view(torch.Generator().manual_seed(1), pile)
    first, second = (photograph("one", pile, view, torch.Generator().manual_seed(2)) for _ in range(2))
    assert torch.equal(first.depth, second.depth)
    assert torch.equal(first.color, second.color)
