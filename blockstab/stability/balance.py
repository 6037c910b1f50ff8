"""The paper's top-down stability rule (section 6)."""

from __future__ import annotations

from dataclasses import dataclass

from torch import Tensor


@dataclass(frozen=True)
class Balance:
    """Which of N boxes stand.

    Args:
        stable: (N,) bool, the box with everything resting on it ("global stability").
        stable_alone: (N,) bool, the box by itself over its own support.
        margin: (N,) metres from the projected centre of mass to the border of the support hull, positive
            inside; NaN where nothing supports the box, +inf for background.
        mass_center: (N, 3) metres, centre of mass of the box and all that rests on it (Eq. 1).
        support_center: (N, 2) centre (x, z) of the support hull, metres; NaN where nothing supports the box.
    """

    stable: Tensor
    stable_alone: Tensor
    margin: Tensor
    mass_center: Tensor
    support_center: Tensor
