"""Merging in stages: what a stage joins, what holds two regions apart, and in which order."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import pytest
import torch
from torch import Tensor

from blockstab.features.appearance.pair_columns import APPEARANCE_COLUMNS, Variant
from blockstab.observation import Observation
from blockstab.proposals.silberman import Order, Silberman, merged_once
from blockstab.segments.edgelets import trace_edgelets
from tests.block_scene import APART, HEIGHT, TABLE, WIDTH, picture


@dataclass(frozen=True)
class Told:
    """A stage that judges by whatever it is told to."""

    judge: Callable[[Tensor], Tensor]
    threshold: float = 0.5

    def __call__(self, appearance: Tensor) -> Tensor:
        return self.judge(appearance)


@dataclass(frozen=True)
class Learned:
    """Stages as the proposal takes them."""

    stages: Sequence[Told] = field(default_factory=tuple)
    variant: Variant = "fixed"


@pytest.fixture(scope="module")
def observation() -> Observation:
    return picture(APART).observation


def stripes(*columns: int) -> Tensor:
    """Upright regions from 1, each ending at a column of the picture."""
    place = torch.arange(WIDTH).repeat(HEIGHT, 1)
    return torch.bucketize(place, torch.tensor(columns), right=True) + 1


def merge(
    label: Tensor, confidence: Sequence[float], threshold: float, order: Order = "best", seed: int = 0
) -> Tensor:
    edgelets = trace_edgelets(label)
    within = torch.tensor(confidence, dtype=torch.float64)[-len(edgelets) :]
    return merged_once(label, edgelets, within, threshold, order, torch.Generator().manual_seed(seed))


def test_each_stage_of_a_chain_joins_what_reaches_its_threshold() -> None:
    label, left = stripes(80, 160, 240), []
    for threshold in (0.9, 0.8, 0.7):
        label = merge(label, (0.95, 0.85, 0.75), threshold)
        left.append(int(label.max()))
    assert left == [3, 2, 1]


def test_a_threshold_is_reached_by_as_much_and_not_by_less() -> None:
    assert int(merge(stripes(160), (0.7,), 0.7).max()) == 1
    assert int(merge(stripes(160), (0.7,), 0.7000001).max()) == 2


def test_the_regions_of_a_stage_are_numbered_without_gaps_and_cover_what_they_covered() -> None:
    label = stripes(80, 160, 240)
    label[:20] = 0
    merged = merge(label, (0.95, 0.1, 0.75), 0.7)
    assert merged.unique().tolist() == [0, 1, 2]
    assert torch.equal(merged, torch.where(label > 0, (label + 1) // 2, 0))


def ring_and_bridge() -> Tensor:
    """Two regions that share two edgelets, because a third lies on their border."""
    label = stripes(160)
    label[100:140, 140:180] = 3
    return label


def test_one_strong_edgelet_holds_two_regions_apart() -> None:
    label = ring_and_bridge()
    edgelets = trace_edgelets(label)
    between = (edgelets.first == 0) & (edgelets.second == 1)
    assert int(between.sum()) == 2
    sure = torch.where(between, 0.9, 0.0).double()
    assert int(merge(label, sure.tolist(), 0.7).max()) == 2
    sure[between.nonzero()[0]] = 0.6
    assert int(merge(label, sure.tolist(), 0.7).max()) == 3


CORNER_SURE = {(0, 1): 0.95, (0, 2): 0.9, (1, 2): 0.2}


def corner() -> Tensor:
    """Three regions that meet in a point."""
    label = stripes(160)
    label[120:] = 3
    return label


def test_a_merged_region_keeps_the_least_sure_of_its_borders() -> None:
    # 1 and 2 are joined first; 3 is sure to belong to 1, but not to 2, and so not to both.
    label = corner()
    edgelets = trace_edgelets(label)
    sure = [CORNER_SURE[pair] for pair in zip(edgelets.first.tolist(), edgelets.second.tolist(), strict=True)]
    merged = merge(label, sure, 0.7)
    assert int(merged.max()) == 2
    assert torch.equal(merged == 2, label == 3)


def test_the_surest_border_goes_first_and_chance_may_choose_another() -> None:
    label = corner()
    edgelets = trace_edgelets(label)
    sure = [CORNER_SURE[pair] for pair in zip(edgelets.first.tolist(), edgelets.second.tolist(), strict=True)]
    outcomes = {
        tuple(merge(label, sure, 0.7, "random", seed)[[0, 0, -1], [0, -1, 0]].tolist()) for seed in range(20)
    }
    assert outcomes == {(1, 1, 2), (1, 2, 1)}


def test_nothing_is_sure_where_a_single_region_has_no_border() -> None:
    label = torch.ones(HEIGHT, WIDTH, dtype=torch.int64)
    assert torch.equal(merge(label, (), 0.5), label)


def test_a_stage_is_shown_every_edgelet_with_all_its_features(observation: Observation) -> None:
    shown: list[Tensor] = []
    label = ring_and_bridge()
    stage = Told(lambda rows: (shown.append(rows), torch.zeros(len(rows)).double())[1])
    Silberman(Learned([stage]))(replace(observation, fine=label))
    assert shown[0].shape == (len(trace_edgelets(label)), len(APPEARANCE_COLUMNS))
    assert bool(shown[0].isfinite().all())


def test_without_stages_the_atoms_are_the_regions(observation: Observation) -> None:
    assert torch.equal(Silberman(Learned(), least_px=0)(observation).label, observation.fine)


def test_a_speck_joins_its_neighbour_in_the_end(observation: Observation) -> None:
    label = torch.ones(HEIGHT, WIDTH, dtype=torch.int64)
    label[100:110, 100:119] = 2
    seen = replace(observation, fine=label)
    assert Silberman(Learned(), least_px=190)(seen).label.unique().tolist() == [1, 2]
    assert Silberman(Learned(), least_px=191)(seen).label.unique().tolist() == [1]


def test_a_stage_that_is_sure_of_all_leaves_one_region_where_all_hangs_together(
    observation: Observation,
) -> None:
    proposed = Silberman(Learned([Told(lambda rows: torch.ones(len(rows)).double())]))(observation)
    assert proposed.label[observation.fine > 0].unique().tolist() == [1]


def test_the_table_is_known_as_background_and_blocks_are_not(observation: Observation) -> None:
    truth = picture(APART).frame.label
    assert truth is not None
    proposed = Silberman(Learned())(replace(observation, fine=truth))
    assert dict(proposed.is_background) == {TABLE: True}


def test_one_seed_draws_one_order(observation: Observation) -> None:
    seen = replace(observation, fine=(label := corner()))
    edgelets = trace_edgelets(label)
    pairs = zip(edgelets.first.tolist(), edgelets.second.tolist(), strict=True)
    sure = torch.tensor([CORNER_SURE[pair] for pair in pairs], dtype=torch.float64)
    learned = Learned([Told(lambda rows: sure, 0.7)])
    one, again, *others = (Silberman(learned, "random", seed)(seen).label for seed in (1, *range(1, 12)))
    assert torch.equal(one, again)
    assert not all(torch.equal(one, other) for other in others)


def test_an_unknown_order_is_refused() -> None:
    with pytest.raises(ValueError, match="best or random, but it is 'worst'"):
        Silberman(Learned(), "worst")  # type: ignore[arg-type]
