"""The 121 features of a merge: before, after, and the difference; and how the two look."""

from __future__ import annotations

import torch

from blockstab.features.appearance import APPEARANCE_COLUMNS
from blockstab.features.merging import MERGE_COLUMNS, merge_features
from blockstab.features.unary import SCALAR_COLUMNS
from tests.tolerance import EXACT


def column(features: torch.Tensor, name: str) -> torch.Tensor:
    return features[:, MERGE_COLUMNS.index(name)]


def test_there_are_121_columns_each_with_its_own_name():
    assert len(set(MERGE_COLUMNS)) == len(MERGE_COLUMNS) == 5 * 14 + 51 == 121


def test_every_criterion_comes_before_after_and_as_two_differences(generator):
    before = torch.rand(5, 30, generator=generator, dtype=torch.float64)
    merged = torch.rand(2, 30, generator=generator, dtype=torch.float64)
    larger, smaller = torch.tensor([3, 0]), torch.tensor([1, 4])
    looks = torch.rand(2, 51, generator=generator, dtype=torch.float64)
    features = merge_features(before, larger, smaller, merged, looks)
    assert features.shape == (2, 121)
    for k, name in enumerate(APPEARANCE_COLUMNS):
        assert torch.equal(column(features, name), looks[:, k])
    for k, name in enumerate(SCALAR_COLUMNS):
        assert torch.equal(column(features, f"{name}_larger"), before[[3, 0], k])
        assert torch.equal(column(features, f"{name}_smaller"), before[[1, 4], k])
        assert torch.equal(column(features, f"{name}_merged"), merged[:, k])
        for other in ("larger", "smaller"):
            difference = column(features, f"{name}_merged") - column(features, f"{name}_{other}")
            torch.testing.assert_close(
                column(features, f"{name}_merged_minus_{other}"), difference, rtol=0.0, atol=EXACT
            )


def test_no_merge_gives_no_row(generator):
    before = torch.rand(2, 30, generator=generator, dtype=torch.float64)
    none = torch.empty(0, dtype=torch.long)
    assert merge_features(before, none, none, before[:0], torch.empty(0, 51).double()).shape == (0, 121)
