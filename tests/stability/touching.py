"""Boxes that touch exactly, and where."""

from __future__ import annotations

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.boxes.separation import separation
from blockstab.stability.contacts import Contacts, contacts_of
from blockstab.stability.support import SupportRules, Supports, candidate_supports

EXACTLY = SupportRules(touch_m=1e-4, touch_per_square_m=0.0)


def relations(boxes: Boxes, movable: Tensor) -> Supports:
    """All that may hold boxes up, on the ground at y = 0."""
    n = len(boxes)
    first, second = torch.triu_indices(n, n, offset=1)
    height, nowhere = torch.zeros(n, dtype=torch.float64), torch.zeros(n, dtype=torch.bool)
    apart = separation(boxes, first, second)
    return candidate_supports(boxes, (first, second), apart, height, movable, nowhere, EXACTLY)


def touching(boxes: Boxes, movable: Tensor) -> Contacts:
    """Their contacts."""
    return contacts_of(boxes, relations(boxes, movable), angle_deg=1.0)
