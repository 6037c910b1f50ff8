"""Rest, contact and falls of piles small enough to be worked out by hand."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence

import pytest
import torch

from blockstab.boxes.box import Boxes
from blockstab.datasets.physics import carried_share, falls, settle

pytest.importorskip("mujoco", reason="the extra `sim` is not installed")

CARRIED = 0.01  # share of a weight; averaged over 0.05 s at rest
Upright = Callable[[Sequence[tuple[float, ...]]], Boxes]


def settled(boxes: Boxes) -> Boxes:
    resting = settle(boxes)
    assert resting is not None
    return resting


@pytest.fixture
def tower(upright: Upright) -> Boxes:
    rows = [(0.0, 0.041, 0.0, 0.06, 0.04, 0.05), (0.01, 0.122, 0.0, 0.05, 0.04, 0.05)]
    return settled(upright([*rows, (0.0, 0.203, 0.01, 0.04, 0.04, 0.05)]))


@pytest.fixture
def bridge(upright: Upright) -> Boxes:
    pillars = [(x, 0.051, 0.0, 0.03, 0.05, 0.05) for x in (-0.08, 0.08)]
    return settled(upright([*pillars, (0.0, 0.132, 0.0, 0.12, 0.03, 0.05)]))


@pytest.fixture
def seesaw(upright: Upright) -> Boxes:
    """A beam that reaches so far out that only the block on its inner end holds it."""
    base, beam = (0.0, 0.051, 0.0, 0.05, 0.05, 0.05), (0.07, 0.132, 0.0, 0.12, 0.03, 0.04)
    return settled(upright([base, beam, (-0.01, 0.233, 0.0, 0.04, 0.07, 0.04)]))


def test_blocks_settle_where_they_are_put(tower: Boxes) -> None:
    expected = torch.tensor([0.04, 0.12, 0.2], dtype=torch.float64)
    assert torch.allclose(tower.center[:, 1], expected, atol=0.0005)


def test_a_block_too_far_over_the_edge_does_not_stay(upright: Upright) -> None:
    boxes = upright([(0.0, 0.051, 0.0, 0.05, 0.05, 0.05), (0.08, 0.152, 0.0, 0.06, 0.05, 0.05)])
    resting = settle(boxes)
    assert resting is None or float((resting.center - boxes.center).norm(dim=1).max()) > 0.05


def test_what_still_falls_after_four_seconds_is_not_at_rest(upright: Upright) -> None:
    assert settle(upright([(0.0, 100.0, 0.0, 0.05, 0.05, 0.05)])) is None


def test_each_layer_of_a_tower_carries_all_above(tower: Boxes) -> None:
    volume = tower.volume()
    above = volume.flip(0).cumsum(0).flip(0)
    expected = torch.zeros(4, 3, dtype=torch.float64)
    expected[3, 0], expected[0, 1], expected[1, 2] = (above / volume).tolist()
    assert torch.allclose(carried_share(tower), expected, atol=CARRIED)


def test_two_pillars_share_a_bridge(bridge: Boxes) -> None:
    share = carried_share(bridge)
    assert torch.allclose(share[:2, 2], torch.full((2,), 0.5, dtype=torch.float64), atol=CARRIED)
    assert share[3, 2] == 0
    assert (share[2] == 0).all()


def test_blocks_side_by_side_carry_nothing_of_each_other(upright: Upright) -> None:
    share = carried_share(settled(upright([(x, 0.051, 0.0, 0.05, 0.05, 0.05) for x in (0.0, 0.1001)])))
    assert (share[:2] < CARRIED).all()
    assert torch.allclose(share[2], torch.ones(2, dtype=torch.float64), atol=CARRIED)


def test_the_table_carries_the_weight_of_all(seesaw: Boxes) -> None:
    volume = seesaw.volume()
    assert float((carried_share(seesaw)[-1] * volume).sum() / volume.sum()) == pytest.approx(1.0, abs=CARRIED)


def test_all_above_a_removed_layer_falls(tower: Boxes) -> None:
    assert falls(tower).tolist() == [[False, True, True], [False, False, True], [False, False, False]]


def test_a_bridge_falls_with_either_pillar_but_the_other_pillar_stays(bridge: Boxes) -> None:
    assert falls(bridge).tolist() == [[False, False, True], [False, False, True], [False, False, False]]


def test_a_beam_falls_without_its_counterweight_though_that_is_above_it(seesaw: Boxes) -> None:
    assert falls(seesaw)[2].tolist() == [False, True, False]


def test_the_missing_engine_is_named_with_the_command_that_installs_it(
    upright: Upright, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(ModuleNotFoundError, match=r"pip install 'blockstab\[sim\]'"):
        settle(upright([(0.0, 0.05, 0.0, 0.05, 0.05, 0.05)]))
