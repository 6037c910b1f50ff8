"""Loss of depth where so little of the light comes back that nothing can be matched."""

from __future__ import annotations

import torch
from torch import Tensor

from blockstab.simulation.sensors.patches import patchy_noise

_ENOUGH = 0.5  # share of the light from which on all is measured
_AT_MOST = 0.95  # share of a surface that is lost
# Black screens lose depth in patches the size of a thumb, with frayed borders.
_WIDE, _FINE = (21, 21), (5, 5)
_FRAYED = 0.6  # strength of the fine noise against the wide


def swallowed(echo: Tensor, generator: torch.Generator) -> Tensor:
    """Pixels (H, W) without depth, as too little light comes back from them.

    Args:
        echo: (H, W) share of the light that comes back; from half of it on nothing is lost, and with less the more.
    """
    wide, fine = (patchy_noise(echo.shape, window, generator) for window in (_WIDE, _FINE))
    fate = (wide + _FRAYED * fine) / (1.0 + _FRAYED**2) ** 0.5
    share = (1.0 - echo / _ENOUGH).clamp(0.0, _AT_MOST)
    lost: Tensor = fate < torch.special.ndtri(share)
    return lost
