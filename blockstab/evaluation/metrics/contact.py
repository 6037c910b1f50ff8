"""Contact between the objects of an image."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor


def touching(
    label: Tensor, depth: Tensor, objects: Sequence[int], gap_m: float = 0.02, least_px: int = 5
) -> bool:
    """True if any two objects touch where the camera sees it: stacked, leaning, or side by side.

    Two do if their pixels lie side by side in several places, with nearly the same depth in each.

    Args:
        label: (H, W) int64, 0 = none.
        depth: (H, W) metres, 0 where not measured.
        objects: ids that count.
        gap_m: greatest difference of depth.
        least_px: places that one pair of objects must have.
    """
    met = [
        _met(label[:, :-1], label[:, 1:], depth[:, :-1], depth[:, 1:], objects, gap_m),
        _met(label[:-1], label[1:], depth[:-1], depth[1:], objects, gap_m),
    ]
    _, count = torch.unique(torch.cat(met), dim=0, return_counts=True)
    return bool((count >= least_px).any())


def _met(
    one: Tensor, other: Tensor, depth: Tensor, other_depth: Tensor, objects: Sequence[int], gap_m: float
) -> Tensor:
    """(N, 2) ids, the smaller first, of two neighbouring pixels on two objects at one depth."""
    ids = torch.tensor(objects, dtype=one.dtype, device=one.device)
    near = ((depth - other_depth).abs() < gap_m) & (depth > 0) & (other_depth > 0)
    pair = near & (one != other) & torch.isin(one, ids) & torch.isin(other, ids)
    return torch.stack([one[pair], other[pair]], dim=1).sort(dim=1).values
