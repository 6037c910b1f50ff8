"""Scores of potentials at telling good segments from bad ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import torch
from scipy.stats import spearmanr
from sklearn.metrics import average_precision_score, roc_auc_score
from torch import Tensor

from blockstab.evaluation.scoring.bootstrap import drawn_images, percentiles
from models.potentials.parsing import ParsingPotentials
from models.potentials.rows import Examples, Rows

RESAMPLES = 200
BINS = 15  # of probabilities, equally wide


def judged(
    potentials: Mapping[str, ParsingPotentials], examples: Sequence[Examples], seed: int
) -> list[dict[str, Any]]:
    """A row of `results.json` for each of several potentials, judging the same segments.

    `auc` and `average_precision`: of telling segments of an overlap below 0.9, by the unary potential;
    `calibration_error`: of the probability that it gives; `rank_correlation`: Spearman's, of the potential and what
    the overlap lacks to 1; `auc_alone`: as `auc`, by the potential that sees them by themselves. For the intervals,
    images are drawn with replacement.

    Args:
        potentials: by name.
        examples: of each image.
    """
    return [_row(name, one, examples, seed) for name, one in potentials.items()]


def calibration_error(badness: Tensor, bad: Tensor) -> float:
    """The expected calibration error: how far, on average, a share of bad rows lies from the probability given.

    Args:
        badness: (N,) probabilities; bad: (N,) bool. In `BINS` bins of probability (Naeini et al. 2015).
    """
    place = (badness * BINS).long().clamp(max=BINS - 1)
    off = torch.zeros(BINS, dtype=torch.float64).index_add(0, place, badness.double() - bad.double())
    return float(off.abs().sum() / len(bad))


def _row(name: str, potentials: ParsingPotentials, examples: Sequence[Examples], seed: int) -> dict[str, Any]:
    unary, alone = ([getattr(e, kind) for e in examples] for kind in ("unary", "alone"))
    phi = [potentials.unary(rows.features) for rows in unary]
    badness = [potentials.unary.badness(rows.features) for rows in unary]
    single = [potentials.alone(rows.features) for rows in alone]
    scores: dict[str, Callable[[list[int]], float]] = {
        "auc": lambda drawn: _of(roc_auc_score, phi, unary, drawn),
        "average_precision": lambda drawn: _of(average_precision_score, phi, unary, drawn),
        "calibration_error": lambda drawn: calibration_error(
            torch.cat([badness[k] for k in drawn]), torch.cat([unary[k].bad for k in drawn])
        ),
        "rank_correlation": lambda drawn: float(
            spearmanr(
                torch.cat([phi[k] for k in drawn]), torch.cat([unary[k].target for k in drawn])
            ).statistic
        ),
        "auc_alone": lambda drawn: _of(roc_auc_score, single, alone, drawn),
    }
    everything = list(range(len(examples)))
    draws = drawn_images(len(examples), seed, RESAMPLES).tolist()
    return {
        "method": name,
        "potential": potentials.name,
        "scores": {score: of(everything) for score, of in scores.items()},
        "ci95": {
            score: percentiles(torch.tensor([of(drawn) for drawn in draws], dtype=torch.float64))
            for score, of in scores.items()
        },
        "segments": sum(len(rows.target) for rows in unary),
    }


def _of(score: Callable[..., float], judged: list[Tensor], rows: list[Rows], drawn: list[int]) -> float:
    """A score of telling bad rows from good ones, over some images."""
    bad = torch.cat([rows[k].bad for k in drawn])
    return float(score(bad.numpy(), torch.cat([judged[k] for k in drawn]).numpy()))
