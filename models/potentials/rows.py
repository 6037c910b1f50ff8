"""Training data of potentials: rows of segments and boundaries, and whole segmentations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import torch
from torch import Tensor

from blockstab.energy.overlap import Parts

KINDS = ("unary", "pairwise", "alone", "background")
GOOD = 0.1  # the loss up to which something is good: "a positive training sample if score(s) >= 90%" (section 7.1)


class Rows(NamedTuple):
    """N rows to learn from.

    Args:
        features: (N, F) float32.
        target: (N,) float64, a loss between 0, good, and 1, bad.
        bad: (N,) bool, whether the paper calls it bad (section 7.1).
        pixel_count: (N,) float64 that each stands for.
    """

    features: Tensor
    target: Tensor
    bad: Tensor
    pixel_count: Tensor


class States(NamedTuple):
    """Whole segmentations of one image: S of them, N segments and M boundaries in all.

    Args:
        unary: (N, F); pairwise: (M, G) float32.
        loss: (N,) the true loss of each segment.
        error: (S,) the true loss of each segmentation; the first is the truth.
        parts: what their energies need beside potentials.
    """

    unary: Tensor
    pairwise: Tensor
    loss: Tensor
    error: Tensor
    parts: Parts


class Examples(NamedTuple):
    """Rows for each potential, and whole segmentations for the structured loss."""

    unary: Rows
    pairwise: Rows
    alone: Rows
    background: Rows
    states: States


def joined_rows(parts: Sequence[Rows]) -> Rows:
    """The rows of all parts, in order."""
    return Rows(*(torch.cat(columns) for columns in zip(*parts, strict=True)))


def joined_parts(parts: Sequence[Parts]) -> Parts:
    """Several segmentations as one table."""
    start = torch.tensor([0, *(p.count for p in parts)]).cumsum(0).tolist()
    return Parts(
        area=torch.cat([p.area for p in parts]),
        background=torch.cat([p.background for p in parts]),
        lost=torch.cat([p.lost for p in parts]),
        smaller=torch.cat([p.smaller for p in parts]),
        segment_of=torch.cat([p.segment_of + k for p, k in zip(parts, start, strict=False)]),
        boundary_of=torch.cat([p.boundary_of + k for p, k in zip(parts, start, strict=False)]),
        count=start[-1],
    )


def joined(parts: Sequence[Examples]) -> Examples:
    """The examples of all parts, in order; of whole segmentations, the truth of the first part comes first."""
    states = [p.states for p in parts]
    rows = {kind: joined_rows([getattr(p, kind) for p in parts]) for kind in KINDS}
    return Examples(
        **rows,
        states=States(
            unary=torch.cat([s.unary for s in states]),
            pairwise=torch.cat([s.pairwise for s in states]),
            loss=torch.cat([s.loss for s in states]),
            error=torch.cat([s.error for s in states]),
            parts=joined_parts([s.parts for s in states]),
        ),
    )
