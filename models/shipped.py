"""Learned things that are one JSON file each, some of which come with this package."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from blockstab.output.export import write_whole
from models.potentials.checkpoint import PRETRAINED
from models.potentials.record import CheckpointError

Learned = TypeVar("Learned")

_SPOILT = (ValueError, TypeError, OverflowError, RecursionError)


def read_learned(
    path: Path | str,
    task: str,
    form: int,
    most_bytes: int,
    make: Callable[[dict[str, Any]], Learned],
) -> Learned:
    """Read what was trained by `train.py task=...`.

    Args:
        path: of the file; or a name without folder and suffix, of one that comes with this package.
        form: the `format` that the file must have.
        most_bytes: of the file.
        make: makes the thing of the object in the file; what it raises of spoilt files becomes one line.

    Raises:
        CheckpointError: naming the file and what is wrong with it.
    """
    file = Path(path)
    if file.parent == Path() and not file.suffix:
        file = PRETRAINED / f"{file.name}.json"
    if not file.is_file():
        raise CheckpointError(f"{file} is not there; train it with `python train.py task={task}`.")
    if file.stat().st_size > most_bytes:
        raise CheckpointError(f"{file} must have at most {most_bytes} bytes, but has {file.stat().st_size}.")
    try:
        record = json.loads(file.read_bytes())
        if not isinstance(record, dict):
            raise ValueError("it must be an object.")
        if record.get("format") != form:
            raise ValueError(f"it must be an object of format {form}.")
        return make(record)
    except KeyError as error:
        raise CheckpointError(f"{file} holds no {task} that can be used: it has no {error}.") from None
    except _SPOILT as error:
        said = " ".join(str(error).split())
        raise CheckpointError(f"{file} holds no {task} that can be used: {said:.200}") from None


def write_learned(path: Path, record: dict[str, Any]) -> None:
    """Write what `read_learned` reads: a JSON file, whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, (json.dumps(record, indent=1, allow_nan=False) + "\n").encode())
