"""Hand-made piles and a few simulated scenes."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pytest
import torch

from blockstab.boxes.box import Boxes
from blockstab.datasets.truth import Truth
from blockstab.rgbd.frame import Frame
from blockstab.simulation.simulated import Recipe, simulate_scene

Row = tuple[float, float, float, float, float, float]


@pytest.fixture(scope="session")
def upright() -> Callable[[Sequence[Row]], Boxes]:
    """Boxes with axes along x, y and z, from rows of centre and half extent, metres."""

    def make(rows: Sequence[Row]) -> Boxes:
        values = torch.tensor(rows, dtype=torch.float64)
        axes = torch.eye(3, dtype=torch.float64).repeat(len(values), 1, 1)
        return Boxes(values[:, :3], axes, values[:, 3:])

    return make


@pytest.fixture(scope="session")
def scenes() -> list[tuple[Frame, Truth]]:
    pytest.importorskip("mujoco", reason="the extra `sim` is not installed")
    return [simulate_scene(Recipe("blocks", 4), index) for index in range(6)]
