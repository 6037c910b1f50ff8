"""From examples to the four potentials of one head, and the weight of boundaries."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import torch
from torch import Tensor

from blockstab.features.columns import COLUMNS, FeatureSet
from models.calibration import platt
from models.checkpoint import Potentials, chosen_columns
from models.examples import KINDS, Examples, Rows, joined_rows
from models.heads import HeadFactory, Potential
from models.parsing import ParsingPotentials, choosing
from models.potential import GOOD, choose_c, fit_potential
from models.structured import fit_structured

TARGETS = ("overlap", "bit")


class Fitted(NamedTuple):
    """Potentials by kind, the weight of boundaries, and what is worth knowing of their making."""

    potentials: dict[str, Potential]
    weight: float
    facts: dict[str, Any]

    def ready(self, name: str) -> ParsingPotentials:
        """For a search."""
        return choosing(
            Potentials(**self.potentials, weight=self.weight, name=name, sha256="", provenance={})
        )


def fit_all(
    examples: Sequence[Examples],
    head: HeadFactory,
    features: FeatureSet,
    target: str,
    structured: bool,
    most_rows: int,
    seed: int,
    jobs: int,
) -> Fitted:
    """Train and calibrate the potentials of every kind.

    Args:
        examples: of each image.
        head: of all kinds alike.
        features: which columns they see.
        target: "overlap": what a segment lacks to an overlap of 1, weighed by the root of its pixels; "bit": whether
            it lacks more than a tenth, good and bad rows weighing the same (the paper's).
        structured: learn on from whole segmentations, see `StructuredFit`; else boundaries weigh nothing.
        most_rows: of a kind; of more, as many are drawn.

    Raises:
        ValueError: naming what is wrong.
    """
    if target not in TARGETS:
        raise ValueError(f"The target is overlap or bit, but it is {target!r}; choose one.")
    potentials, facts = dict[str, Potential](), dict[str, Any]()
    for kind in KINDS:
        rows, group = _drawn([getattr(e, kind) for e in examples], most_rows, seed)
        potentials[kind], facts[kind] = _fit(kind, rows, group, head, features, target, seed, jobs)
    weight = 0.0
    if structured:
        columns = tuple(chosen_columns(potentials[k], COLUMNS[k]) for k in ("unary", "pairwise"))
        states = [e.states for e in examples]
        weight = fit_structured(potentials["unary"], potentials["pairwise"], columns, states, seed)  # type: ignore[arg-type]
        rows, _ = _drawn([e.unary for e in examples], most_rows, seed)
        _calibrate(potentials["unary"], rows, columns[0])
    return Fitted(potentials, weight, {**facts, "weight": round(weight, 5)})


def _fit(
    kind: str,
    rows: Rows,
    group: Tensor,
    head: HeadFactory,
    features: FeatureSet,
    target: str,
    seed: int,
    jobs: int,
) -> tuple[Potential, dict[str, Any]]:
    columns = features.of(kind)
    chosen = torch.tensor([COLUMNS[kind].index(name) for name in columns])
    seen = rows.features[:, chosen].double()
    as_bit = target == "bit" and kind in ("unary", "pairwise")
    wanted = (rows.target > GOOD).double() if as_bit else rows.target
    weight = None if as_bit else rows.pixels.sqrt() / rows.pixels.sqrt().mean()
    found = choose_c(seen, wanted, group, columns, head, weight=weight, seed=seed, jobs=jobs)
    potential = fit_potential(
        seen, wanted, group, columns, head, c=found.c, weight=weight, seed=seed, jobs=jobs
    )
    loss = found.held_out_loss.get(found.c)
    return potential, {
        "rows": len(wanted),
        "bad_share": round(float((rows.target > GOOD).double().mean()), 4),
        "c": found.c,
        "held_out_loss": None if loss is None else round(loss, 5),
    }


def _drawn(parts: Sequence[Rows], most: int, seed: int) -> tuple[Rows, Tensor]:
    """The rows of all images, or as many of them, in order; and the image that each is from."""
    rows = joined_rows(parts)
    group = torch.arange(len(parts)).repeat_interleave(torch.tensor([len(p.target) for p in parts]))
    if len(group) > most:
        generator = torch.Generator().manual_seed(seed)
        chosen = torch.randperm(len(group), generator=generator)[:most].sort().values
        rows, group = Rows(*(column[chosen] for column in rows)), group[chosen]
    return rows, group


def _calibrate(potential: Potential, rows: Rows, columns: Tensor) -> None:
    """Platt's numbers anew, for a potential that has learned on since."""
    a, b = platt(potential(rows.features[:, columns].double()).detach(), (rows.target > GOOD).double())
    potential.a.fill_(a)
    potential.b.fill_(b)
