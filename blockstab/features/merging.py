"""Features of a merge: each criterion before, after, and the difference; how the two look (paper, section 6.1)."""

from __future__ import annotations

import torch
from torch import Tensor

from blockstab.features.appearance import APPEARANCE_COLUMNS
from blockstab.features.unary import SCALAR_COLUMNS

MERGE_COLUMNS = (
    *(
        f"{name}_{when}"
        for when in ("larger", "smaller", "merged", "merged_minus_larger", "merged_minus_smaller")
        for name in SCALAR_COLUMNS
    ),
    *APPEARANCE_COLUMNS,
)


def merge_features(
    before: Tensor, larger: Tensor, smaller: Tensor, merged: Tensor, appearance: Tensor
) -> Tensor:
    """Features of K possible merges, (K, 121) float64, in the order of `MERGE_COLUMNS`.

    Args:
        before: (N, 30) unary features of the scene as it is; larger, smaller: (K,) the two segments of each merge.
        merged: (K, 30) unary features of the merged segment, in the scene after the merge.
        appearance: (K, 51) how the two look, in the order of `APPEARANCE_COLUMNS`.
    """
    n = len(SCALAR_COLUMNS)
    first, second, after = before[larger, :n], before[smaller, :n], merged[:, :n]
    return torch.cat([first, second, after, after - first, after - second, appearance], dim=1)
