"""The JSON half of a checkpoint: which heads, over which columns, and where they come from."""

from __future__ import annotations

import json
from typing import Any

import torch

from models.heads import HEADS, Potential

FORMAT = 1


class CheckpointError(ValueError):
    """A checkpoint that cannot be used; the message names the file and the reason."""


def _description(potential: Potential) -> dict[str, Any]:
    for name, head in HEADS.items():
        if type(potential.head) is head:
            return {"head": name, "arguments": potential.head.arguments, "columns": list(potential.columns)}
    raise ValueError(
        f"The head {type(potential.head).__name__} has no name to be stored under; add it to models.heads.HEADS."
    )


def _checked_record(path: Path) -> dict[str, Any]:
    """What the JSON file holds, once its keys are those of this format."""
    content = _read(path)
    try:
        record = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise CheckpointError(f"{path} is not a JSON file: {error}.") from error
    if isinstance(record, dict) and record.get("format", FORMAT) != FORMAT:
        raise CheckpointError(f"{path} is of format {record['format']!r}, but this version reads {FORMAT}.")
    _check_keys(path, "the file", record, {"format", "sha256", "potentials", "provenance"})
    _check_keys(path, "potentials", record["potentials"], {"unary", "pairwise"}, {"merge"})
    for kind, description in record["potentials"].items():
        _check_keys(path, kind, description, {"head", "arguments", "columns"})
    return record


def _check_keys(
    path: Path, where: str, value: object, needed: set[str], allowed: Set[str] = frozenset()
) -> None:
    """Raise CheckpointError unless `value` is a dict with all keys needed and none beyond those allowed."""
    if not isinstance(value, dict):
        raise CheckpointError(f"{path}: {where} must be an object, but is {type(value).__name__}.")
    missing, surplus = sorted(needed - value.keys()), sorted(value.keys() - needed - allowed)
    if missing or surplus:
        raise CheckpointError(f"{path}: {where} lacks {missing} and has {surplus} too many.")


def _empty(path: Path, kind: str, description: dict[str, Any]) -> Potential:
    """A potential as described, its tensors without memory."""
    name, columns = description["head"], description["columns"]
    if not isinstance(name, str) or name not in HEADS:
        raise CheckpointError(f"{path}: the {kind} head is {name!r}, but must be one of {', '.join(HEADS)}.")
    if not isinstance(columns, list) or not columns or not all(isinstance(c, str) for c in columns):
        raise CheckpointError(f"{path}: the {kind} columns must be a list of names, but are {columns!r:.80}.")
    try:
        with torch.device("meta"):
            head = HEADS[name](len(columns), **description["arguments"])
            return Potential(columns, head, torch.empty(len(columns)), torch.empty(len(columns)))
    except (TypeError, ValueError, RuntimeError) as error:
        given = f"{description['arguments']!r:.80}"
        raise CheckpointError(
            f"{path}: the {kind} head {name!r} does not take the arguments {given}."
        ) from error


