"""Machine code made ahead of its first use."""

from __future__ import annotations

import torch

from blockstab.boxes.fitting import MinimumSurface
from blockstab.boxes.separation import Separation
from blockstab.stability.judges import TrimmedSupports
from blockstab.stability.relating import related
from blockstab.stability.support import SupportRules


def warm_up() -> None:
    """Fit, relate and judge one box, so that the machine code is on disk when it is wanted."""
    points = torch.rand(1, 20, 3, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    count, seed, up = torch.tensor([20]), torch.tensor([0]), torch.tensor([[0.0, 1.0, 0.0]]).double()
    box = MinimumSurface()(points, count, seed).boxes
    MinimumSurface()(points, count, seed, up)
    none, zero, true = torch.empty(0, dtype=torch.long), points.new_zeros(1), torch.tensor([True])
    apart = Separation(points.new_empty(0), points.new_empty(0, 3))
    candidates = related(box, (none, none), apart, zero, true, ~true, SupportRules())
    TrimmedSupports()(box, true, candidates, zero)
