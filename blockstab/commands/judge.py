"""`blockstab judge`: what stands, what falls if a thing is taken away, and where judges disagree."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
import typer
from rich.console import Console
from rich.table import Table
from torch import Tensor

from blockstab.commands.parse import stop
from blockstab.output.export import write_whole
from blockstab.stability.arrangement import Arrangement, read_arrangement
from blockstab.stability.contacts import contacts_of
from blockstab.stability.judges import StabilityJudge, StaticEquilibrium, TrimmedSupports
from blockstab.stability.removal import falls_if_removed
from blockstab.stability.taking_apart import removal_order
from blockstab.stability.tilting import least_tilt
from models.entry import one_line_errors


@dataclass(frozen=True)
class Opinion:
    """Opinion of a judge on N boxes.

    Args:
        stable: (N,) bool; falls: (N, N) bool, [i, j] where j falls without i.
        order: in which all can be taken away while nothing falls; None where there is none.
        asked_for_order: whether it was asked.
    """

    stable: Tensor
    falls: Tensor
    order: tuple[int, ...] | None
    asked_for_order: bool = True


def judge_file(file: Path, by: str, out: Path | None) -> None:
    """Print what judges say of the boxes of a file, and write it where that is asked for."""
    with one_line_errors(stop, str(file)):
        names = [name.strip() for name in by.split(",")]
        unknown = next((name for name in names if name not in JUDGES), None)
        if unknown is not None:
            raise ValueError(f"There is no judge {unknown!r:.80}; choose from: {', '.join(JUDGES)}.")
        asked = read_arrangement(file)
        opinions = {name: JUDGES[name](asked) for name in dict.fromkeys(names)}
        record = record_of(asked, opinions)
        if out is not None:
            write_whole(out, (json.dumps(record, indent=1) + "\n").encode())
    _show(asked, record)


def record_of(asked: Arrangement, opinions: Mapping[str, Opinion]) -> dict[str, Any]:
    """What judges say, as plain values."""
    ids = asked.ids
    objects = asked.movable.nonzero()[:, 0].tolist()

    def named(opinion: Opinion) -> dict[str, Any]:
        falls = {ids[i]: [ids[j] for j in opinion.falls[i].nonzero()[:, 0].tolist()] for i in objects}
        told = {"stable": {ids[i]: bool(opinion.stable[i]) for i in objects}, "falls_if_removed": falls}
        if opinion.asked_for_order:
            told["removal_order"] = None if opinion.order is None else [ids[i] for i in opinion.order]
        return told

    first, *others = opinions.values()
    disputed = [
        ids[i]
        for i in objects
        if any(
            bool(o.stable[i] != first.stable[i]) or not torch.equal(o.falls[i], first.falls[i])
            for o in others
        )
    ]
    contacts = contacts_of(asked.boxes, asked.candidates())
    tilt = least_tilt(asked.boxes, asked.movable, contacts)
    return {
        "judges": {name: named(opinion) for name, opinion in opinions.items()},
        "least_tilt_deg": round(float(tilt.degrees), 6),
        "disputed": disputed,
    }


def by_rule(judge: StabilityJudge) -> Callable[[Arrangement], Opinion]:
    """The opinion of a judge that knows relations alone."""

    def asked(of: Arrangement) -> Opinion:
        candidates = of.candidates()
        stable = judge(of.boxes, of.movable, candidates, of.slack).balance.stable
        scene = of.boxes, of.movable, candidates, stable, of.slack, judge
        return Opinion(stable, falls_if_removed(*scene), removal_order(*scene))

    return asked


def by_physics(of: Arrangement) -> Opinion:
    """The opinion of MuJoCo, which lets the boxes go and looks where they are after one and a half seconds.

    Raises:
        ValueError: some are background, which the engine has not.
        ModuleNotFoundError: it is not installed.
    """
    from blockstab.simulation.physics.settling import moves
    from blockstab.simulation.physics.solids import Pile, box

    if not bool(of.movable.all()):
        raise ValueError(
            "Physics judges things on the ground alone, but some of these are background; leave it out."
        )
    up = torch.tensor([0.0, of.ground_height, 0.0], dtype=torch.float64)
    solids = tuple(box(half) for half in of.boxes.half_extent.tolist())
    pile = Pile(solids, of.boxes.center - up, of.boxes.rotation)
    stable, falls = ~moves(pile), torch.zeros(len(pile), len(pile), dtype=torch.bool)
    # Nothing is left out that touches no box: exact contact may be none to the engine.
    for i in range(len(pile)):
        others = [j for j in range(len(pile)) if j != i]
        falls[i, others] = moves(pile[others])
    return Opinion(stable, falls & stable, None, asked_for_order=False)


JUDGES: dict[str, Callable[[Arrangement], Opinion]] = {
    "paper": by_rule(TrimmedSupports()),
    "equilibrium": by_rule(StaticEquilibrium()),
    "physics": by_physics,
}


def _show(asked: Arrangement, record: dict[str, Any]) -> None:
    judges = record["judges"]
    table = Table("box", *(column for name in judges for column in (name, "falls without it")))
    for k, name in enumerate(asked.ids):
        if bool(asked.movable[k]):
            cells = []
            for told in judges.values():
                cells += [
                    "stands" if told["stable"][name] else "falls",
                    ", ".join(told["falls_if_removed"][name]),
                ]
            table.add_row(name, *cells)
    Console().print(table)
    for name, told in judges.items():
        if "removal_order" in told:
            order = told["removal_order"]
            typer.echo(
                f"{name}: there is no order in which all can be taken away while nothing falls"
                if order is None
                else f"{name}: taken away in this order, nothing falls: {', '.join(order)}"
            )
    typer.echo(f"Gravity may tilt by {record['least_tilt_deg']:.1f} degrees before something moves.")
    if len(judges) > 1:
        typer.echo("The judges disagree about: " + (", ".join(record["disputed"]) or "nothing"))
