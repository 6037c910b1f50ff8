"""Bootstrap intervals of the mean over images, and of the step from one method to the next."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import torch
from torch import Tensor

from blockstab.evaluation.scoring.prediction import Score

RESAMPLES = 1000
TAILS = (0.025, 0.975)  # of a 95 % interval


class Step(NamedTuple):
    """Difference of the means of two methods, and its 95 % interval."""

    mean: float
    ci95: list[float]


def pooled(parts: Sequence[Score]) -> float | None:
    """The mean over all things scored; None where there is nothing."""
    things = sum(p.things for p in parts)
    return sum(p.total for p in parts) / things if things else None


def interval(parts: Sequence[Score], seed: int) -> list[float] | None:
    """The 95 % bootstrap interval of the pooled mean, over the images in which something was scored."""
    parts = [p for p in parts if p.things]
    return percentiles(_means(parts, drawn_images(len(parts), seed))) if parts else None


def step(above: Mapping[str, Score], row: Mapping[str, Score], seed: int) -> Step | None:
    """Step of the pooled mean from one method to another, with its paired bootstrap interval.

    Args:
        above, row: what each method scored, by scene. The scenes count in which both have something.

    Convention:
        Scenes are drawn for both methods together: what makes a scene hard for both does not blur the step.
    """
    both = [scene for scene in row if row[scene].things and scene in above and above[scene].things]
    if not both:
        return None
    before, after = [above[scene] for scene in both], [row[scene] for scene in both]
    draws = drawn_images(len(both), seed)
    mean, gone = pooled(after), pooled(before)
    assert mean is not None
    assert gone is not None
    return Step(mean - gone, percentiles(_means(after, draws) - _means(before, draws)))


def drawn_images(images: int, seed: int, resamples: int = RESAMPLES) -> Tensor:
    """(R, I) images drawn with replacement, a line for each resample."""
    generator = torch.Generator().manual_seed(seed)
    return torch.randint(0, images, (resamples, images), generator=generator)


def percentiles(means: Tensor) -> list[float]:
    """The ends of the 95 % interval, from what (R,) resamples give."""
    return [float(means.quantile(q)) for q in TAILS]


def _means(parts: Sequence[Score], draws: Tensor) -> Tensor:
    """(R,) the pooled mean of each resample."""
    total = torch.tensor([p.total for p in parts], dtype=torch.float64)
    count = torch.tensor([p.things for p in parts], dtype=torch.float64)
    return total[draws].sum(dim=1) / count[draws].sum(dim=1)
