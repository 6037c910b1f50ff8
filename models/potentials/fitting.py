"""From examples to the four potentials of one head, and the weight of boundaries."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import torch
from sklearn.metrics import roc_auc_score
from torch import Tensor

from blockstab.features.columns import FeatureSet, SegmentColumns, computed
from models.potentials.calibration import platt
from models.potentials.checkpoint import Potentials, chosen_columns
from models.potentials.heads import HeadFactory, Potential
from models.potentials.parsing import ParsingPotentials, choosing
from models.potentials.potential import CrossFit, choose_c, cross_fit, fold_of
from models.potentials.rows import KINDS, Examples, Rows, joined_rows
from models.potentials.structured import fit_structured, held_out_weight

TARGETS = ("overlap", "bit")


class Fitted(NamedTuple):
    """Potentials by kind, the weight of boundaries, and what is worth knowing of their making.

    Args:
        unseen: for each fold of the images, see `fold_of`, potentials by kind that had not seen them.
        columns: beside ours, of segments.
    """

    potentials: dict[str, Potential]
    weight: float
    facts: dict[str, Any]
    unseen: tuple[dict[str, Potential], ...]
    columns: Sequence[SegmentColumns] = ()

    def ready(self, fold: int) -> ParsingPotentials:
        """For a search on the images of a fold."""
        return _ready(self.columns, self.unseen[fold], self.weight, f"fold {fold}")


def _ready(
    columns: Sequence[SegmentColumns], potentials: Mapping[str, Potential], weight: float, name: str
) -> ParsingPotentials:
    found = Potentials(**potentials, weight=weight, name=name, sha256="", provenance={})
    return choosing(found, columns)


def fit_all(
    examples: Sequence[Examples],
    head: HeadFactory,
    features: FeatureSet,
    target: str,
    structured: bool,
    weight: float | None,
    most_rows: int,
    folds: int,
    seed: int,
    jobs: int,
    columns: Sequence[SegmentColumns] = (),
) -> Fitted:
    """Train and calibrate the potentials of every kind, and weigh boundaries.

    Args:
        examples: of each image.
        head: of all kinds alike.
        features: which columns they see.
        target: "overlap": what a segment lacks to an overlap of 1, and what two would gain as one, weighed by the
            root of their pixels; "bit": whether it is bad to the paper, good and bad rows weighing the same.
        structured: learn on from whole segmentations, see `StructuredFit`.
        weight: of boundaries; None: that of `held_out_weight`.
        most_rows: of a kind; of more, as many are drawn.
        folds: parts of the images, each of which is judged by what has learned from the others.
        columns: of segments, beside ours, that the examples hold; all are seen.

    Raises:
        ValueError: naming what is wrong.
    """
    if target not in TARGETS:
        raise ValueError(f"The target is overlap or bit, but it is {target!r}; choose one.")
    names = {kind: features.of(kind, columns) for kind in KINDS}
    all_columns = computed(columns)
    fits, facts = dict[str, CrossFit](), dict[str, Any]()
    for kind in KINDS:
        rows, group = _drawn([getattr(e, kind) for e in examples], most_rows, seed)
        fits[kind], facts[kind] = _fit(
            kind, rows, group, head, names[kind], all_columns[kind], target, folds, seed, jobs
        )
    potentials = {kind: fit.potential for kind, fit in fits.items()}
    unseen = tuple({kind: fit.unseen[k] for kind, fit in fits.items()} for k in range(folds))
    states = [e.states for e in examples]
    if weight is None:
        ready = [_ready(columns, one, 0.0, f"fold {k}") for k, one in enumerate(unseen)]
        fold = fold_of(torch.arange(len(states)), folds).tolist()
        weight = held_out_weight([ready[k] for k in fold], states)
    if structured:
        one, two = (chosen_columns(potentials[k], all_columns[k]) for k in ("unary", "pairwise"))
        weight = fit_structured(potentials["unary"], potentials["pairwise"], (one, two), states, weight, seed)
        if next(potentials["unary"].parameters(), None) is not None:
            rows, _ = _drawn([e.unary for e in examples], most_rows, seed)
            _calibrate(potentials["unary"], rows, one)
    return Fitted(potentials, weight, {**facts, "weight": round(weight, 5)}, unseen, columns)


def _fit(
    kind: str,
    rows: Rows,
    group: Tensor,
    head: HeadFactory,
    columns: tuple[str, ...],
    computed_columns: tuple[str, ...],
    target: str,
    folds: int,
    seed: int,
    jobs: int,
) -> tuple[CrossFit, dict[str, Any]]:
    chosen = torch.tensor([computed_columns.index(name) for name in columns])
    seen = rows.features[:, chosen].double()
    as_bit = target == "bit" and kind in ("unary", "pairwise")
    wanted = rows.bad.double() if as_bit else rows.target
    weight = None if as_bit else rows.pixel_count.sqrt() / rows.pixel_count.sqrt().mean()
    found = choose_c(seen, wanted, group, columns, head, weight=weight, folds=folds, seed=seed, jobs=jobs)
    fit = cross_fit(
        seen,
        wanted,
        group,
        columns,
        head,
        c=found.c,
        weight=weight,
        bad=rows.bad,
        folds=folds,
        seed=seed,
        jobs=jobs,
    )
    loss = found.held_out_loss.get(found.c)
    return fit, {
        "rows": len(wanted),
        "bad_share": round(float(rows.bad.double().mean()), 4),
        "c": found.c,
        "held_out_loss": None if loss is None else round(loss, 5),
        "held_out_auc": _auc(rows.bad, fit.held_out),
    }


def _auc(bad: Tensor, potential: Tensor) -> float | None:
    """Nothing where all rows are good, or all bad."""
    if bool(bad.all()) or not bool(bad.any()):
        return None
    return round(float(roc_auc_score(bad.numpy(), potential.numpy())), 4)


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
    a, b = platt(potential(rows.features[:, columns].double()).detach(), rows.bad.double())
    potential.a.fill_(a)
    potential.b.fill_(b)
