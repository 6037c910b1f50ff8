"""Rows of a table: what methods scored over all images, how sure that is, and the step from each to the next."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from blockstab.evaluation.scoring.bootstrap import interval, pooled, step
from blockstab.evaluation.scoring.prediction import Score

Record = dict[str, Any]


@dataclass(frozen=True)
class Scored:
    """Scores of one method.

    Args:
        method: its name.
        potential: the name of its potentials.
        names: of its scores.
        scores: by scene, then by name.
    """

    method: str
    potential: str | None
    names: tuple[str, ...]
    scores: Mapping[str, Mapping[str, Score]]

    def of(self, name: str) -> dict[str, Score]:
        """One score, by scene; where nothing was scored, nothing."""
        found = {scene: scores[name] for scene, scores in self.scores.items() if name in scores}
        return {scene: score for scene, score in found.items() if score.things}


def rows_of(methods: Sequence[Scored], seed: int) -> list[Record]:
    """A row of `results.json` for each method; `step` is over the row before, where that has the same scores."""
    above = (None, *methods)
    return [
        _row(scored, before if before is not None and before.names == scored.names else None, seed)
        for before, scored in zip(above, methods, strict=False)
    ]


def _row(scored: Scored, above: Scored | None, seed: int) -> Record:
    parts = {name: scored.of(name) for name in scored.names}
    row: Record = {
        "method": scored.method,
        "potential": scored.potential,
        "scores": {name: pooled(list(found.values())) for name, found in parts.items()},
        "ci95": {name: interval(list(found.values()), seed) for name, found in parts.items()},
        "per_image": {
            scene: {name: s.total / s.things for name, s in scores.items() if s.things}
            for scene, scores in scored.scores.items()
        },
    }
    if above is not None:
        steps = {name: step(above.of(name), found, seed) for name, found in parts.items()}
        row["step"] = {name: found and found.mean for name, found in steps.items()}
        row["step_ci95"] = {name: found and found.ci95 for name, found in steps.items()}
    return row
