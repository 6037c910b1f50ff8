"""Parts of a simulation by name: ours, and classes and values of one's own by their path."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import TypeVar

Part = TypeVar("Part")


def named(kind: str, name: str, ours: Mapping[str, Part]) -> Part:
    """The part of that name, or what `package.module.Name` is: a part, or a class of which one is made.

    Args:
        kind: for messages.

    Raises:
        ValueError: there is none.
    """
    if name in ours:
        return ours[name]
    try:
        module, _, own = name.rpartition(".")
        found = getattr(import_module(module), own)
        made: Part = found() if isinstance(found, type) else found
    except (ImportError, AttributeError, ValueError, TypeError) as error:
        raise ValueError(
            f"There is no {kind} {name!r}; choose from: {', '.join(ours)}, or name one of your own ({error})."
        ) from None
    return made
