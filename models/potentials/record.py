"""The JSON half of a checkpoint: which heads, over which columns, and where they come from."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Set
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch

from models.potentials.heads import HEADS, Potential

FORMAT = 2
_KINDS = {"unary", "pairwise", "alone", "background"}  # of potentials


class CheckpointError(ValueError):
    """A checkpoint that cannot be used; the message names the file and the reason."""


@dataclass(frozen=True)
class Record:
    """Content of the JSON of a checkpoint.

    Args:
        sha256: of the safetensors file, in hexadecimal.
        potentials: by kind; as read, their tensors have a shape but no memory.
        weight: of boundaries in the expected loss, 0 or more.
        provenance: what the maker wrote down.
    """

    sha256: str
    potentials: dict[str, Potential]
    weight: float
    provenance: dict[str, Any]

    def __post_init__(self) -> None:
        _check_keys("the potentials", self.potentials, _KINDS)

    def text(self) -> str:
        """The JSON; ValueError if a head's class has no name of its own."""
        record = {
            "format": FORMAT,
            "sha256": self.sha256,
            "potentials": {kind: _description(p) for kind, p in self.potentials.items()},
            "weight": self.weight,
            "provenance": self.provenance,
        }
        return json.dumps(record, indent=1, allow_nan=False) + "\n"


def read_record(path: Path, content: bytes, heads: Mapping[str, type[Any]] = HEADS) -> Record:
    """The record in the bytes of `path`, of these heads; CheckpointError, naming `path`, if there is none."""
    try:
        record = json.loads(content)
        if isinstance(record, dict) and record.get("format", FORMAT) != FORMAT:
            raise ValueError(f"it has format {record['format']!r:.80}, but this version reads {FORMAT}")
        _check_keys("the file", record, {"format", "sha256", "potentials", "weight", "provenance"})
        _check_keys("potentials", record["potentials"], _KINDS)
        weight = record["weight"]
        if isinstance(weight, bool) or not isinstance(weight, (int, float)) or not 0 <= weight < 1e6:
            raise ValueError(f"weight must be a number of 0 or more, but is {weight!r:.80}")
        if not re.fullmatch("[0-9a-f]{64}", str(record["sha256"])):
            raise ValueError(f"sha256 must be 64 hexadecimal digits, but is {record['sha256']!r:.80}")
        if not isinstance(record["provenance"], dict):
            raise ValueError(f"provenance must be an object, but is {record['provenance']!r:.80}")
        potentials = {kind: _empty(kind, given, heads) for kind, given in record["potentials"].items()}
    except (ValueError, RecursionError) as error:
        raise CheckpointError(f"{path} is not the record of a checkpoint: {error}.") from error
    return Record(str(record["sha256"]), potentials, float(weight), record["provenance"])


def _description(potential: Potential) -> dict[str, Any]:
    head = potential.head
    name = vars(type(head)).get("name")  # that of a base class would make another head of it when it is read
    if not isinstance(name, str) or not name:
        raise ValueError(
            f"The head {type(head).__name__} has no name to be stored under; give the class a `name`."
        )
    return {"head": name, "arguments": head.arguments, "columns": list(potential.columns)}


def _empty(kind: str, given: object, heads: Mapping[str, type[Any]]) -> Potential:
    """A potential as described, on the meta device: room for any size, and no random number is drawn."""
    description = _check_keys(kind, given, {"head", "arguments", "columns"})
    name, arguments, columns = description["head"], description["arguments"], description["columns"]
    if not isinstance(name, str) or name not in heads:
        raise ValueError(
            f"the {kind} head is {name!r:.80}, but must be one of {', '.join(heads)}; "
            "say `heads=[module.Class]` for one of your own"
        )
    if not isinstance(columns, list) or not columns or not all(isinstance(c, str) for c in columns):
        raise ValueError(f"the {kind} columns must be a list of names, but are {columns!r:.80}")
    try:
        with torch.device("meta"):
            head = heads[name](len(columns), **arguments)
            return Potential(columns, head, torch.empty(len(columns)), torch.empty(len(columns)))
    except (TypeError, RuntimeError, OverflowError) as error:
        raise ValueError(f"the {kind} head {name!r} does not take the arguments {arguments!r:.80}") from error


def _check_keys(where: str, value: object, needed: Set[str]) -> dict[str, Any]:
    """`value`, if it is a dict with all keys needed and no others."""
    if not isinstance(value, dict):
        raise ValueError(f"{where} must be an object, but is {value!r:.80}")
    missing, surplus = sorted(needed - value.keys()), sorted(value.keys() - needed)
    if missing or surplus:
        raise ValueError(
            f"{where} must hold {sorted(needed)}: {missing} are missing, {surplus!r:.80} are unknown"
        )
    return value
