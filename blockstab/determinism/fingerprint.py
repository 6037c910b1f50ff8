"""Fingerprints of results, in one word: the configuration, the sources of the packages, those of plug-ins."""

from __future__ import annotations

import copyreg
import math
import pickle
import sys
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cached_property
from pathlib import PurePath
from types import FunctionType, ModuleType
from typing import Any, NoReturn

import numpy as np
import torch
from torch import Tensor

from blockstab.determinism.sources import hashed, own_sources, source_of

_MOST_PARTS = 100_000  # of one fingerprint: what refers to itself in many ways would never come to an end
_PLAIN = (type(None), bool, int, float, complex, str, bytes, type(Ellipsis), type(NotImplemented))


def fingerprint(*parts: object) -> str:
    """A word, hexadecimal, that changes whenever the code does or one of `parts`, and with nothing else.

    It is the same in every process. A part is described by what `pickle` would keep of it: containers, numbers and
    tensors by what they hold, objects by their class and attributes, functions and classes by their name. The
    sources of this package and of `models` always count, whole; of any other module that a class or function comes
    from, its own source and, where it belongs to a package, those beside it; but an installed library by its version.

    Convention:
        Two things do not count: fields of a dataclass that are declared with `compare=False`, and cached properties.
        A plug-in leaves out more with a `__getstate__` of its own.

    Raises:
        ValueError: naming what cannot be told apart in another process, such as a lambda or an open file.
    """
    try:
        return _Description().of((own_sources(), parts)).hex()
    except RecursionError:
        raise ValueError("A fingerprint needs parts that are not nested so deep; make them flat.") from None


class _Description:
    """Digests parts, and what they are made of, one inside the other."""

    def __init__(self) -> None:
        self.where = "one of its parts"  # the attribute at hand, for messages
        self.open: dict[int, int] = {}  # how deep an object lies that is being described, by its id
        self.lowest: float = math.inf  # the least deep of those that the object at hand leads back to
        self.done: dict[int, tuple[object, bytes]] = {}  # objects are kept, so that no other gets their id
        self.sources: dict[str, bytes] = {}  # by module
        self.count = 0

    def of(self, part: object) -> bytes:
        """The digest of one part."""
        if type(part) in _PLAIN:
            return hashed(type(part).__name__, part if isinstance(part, bytes) else repr(part))
        if id(part) in self.done:
            return self.done[id(part)][1]
        depth = len(self.open)
        if id(part) in self.open:
            self.lowest = min(self.lowest, self.open[id(part)])
            return hashed("again", str(depth - self.open[id(part)]))
        self.count += 1
        if self.count > _MOST_PARTS:
            self._refuse("leads to too many things", "give its class a __getstate__ that keeps what matters")
        around, self.lowest = self.lowest, math.inf
        self.open[id(part)] = depth
        found = self._described(part)
        del self.open[id(part)]
        # What leads back to something around it is described by the way there, and may look different elsewhere.
        if self.lowest >= depth:
            self.done[id(part)] = part, found
            self.lowest = math.inf
        self.lowest = min(self.lowest, around)
        return found

    def _described(self, part: Any) -> bytes:
        kind = type(part)
        if kind.__module__.startswith("omegaconf."):
            # It knows the configuration around it too, most of which says nothing about it.
            return self.of(dict(part) if isinstance(part, Mapping) else list(part))
        match part:
            case Enum():
                return hashed("member", self.of(kind), str(part.name))
            case type():
                return hashed("class", *(self._named(base, base.__qualname__) for base in part.__mro__))
            case FunctionType():
                return self._named(part, part.__qualname__)
            case ModuleType():
                return hashed("module", part.__name__, self._source(part.__name__))
            case PurePath():
                return hashed("path", str(part))
            case Tensor():
                flat = part.detach().cpu().contiguous().reshape(-1).view(torch.uint8)
                return hashed("tensor", str(part.dtype), str(tuple(part.shape)), flat.numpy().tobytes())
            case np.ndarray() | np.generic() if not part.dtype.hasobject:
                return hashed("array", str(part.dtype), str(part.shape), part.tobytes())
            case list() | tuple() if kind in (list, tuple):
                return hashed(kind.__name__, *map(self.of, part))
            case dict() if kind is dict:
                return hashed("dict", *(self.of(one) for pair in part.items() for one in pair))
            case set() | frozenset():
                return hashed("set", self.of(kind), *sorted(map(self.of, part)))
        return self._reduced(part)

    def _reduced(self, part: Any) -> bytes:
        """As `pickle` takes objects apart: what makes them anew, of what, their state, and what they contain."""
        reduce = copyreg.dispatch_table.get(type(part))
        try:
            found = reduce(part) if reduce else part.__reduce_ex__(4)
        except (TypeError, pickle.PicklingError):
            self._refuse(
                f"is or holds a {type(part).__name__}, whose content cannot be told",
                "open it where it is used, or leave it out of what __getstate__ returns",
            )
        if isinstance(found, str):
            return self._named(part, found)
        make, arguments, state, items, pairs = (*found, None, None, None)[:5]
        states = state if isinstance(state, tuple) and len(state) == 2 else (state,)
        return hashed(
            "object",
            *(self.of(one) for one in (make, *arguments)),
            *(self._state(part, one) for one in states),
            *(self.of(list(content or ())) for content in (items, pairs)),
        )

    def _state(self, part: Any, state: object) -> bytes:
        if type(state) is not dict:
            return self.of(state)
        left_out = (
            {field.name for field in fields(part) if not field.compare} if is_dataclass(part) else set()
        )
        digests, before = [], self.where
        for name in sorted(state, key=str):
            if name in left_out or isinstance(getattr(type(part), str(name), None), cached_property):
                continue
            self.where = f"{type(part).__name__}.{name}"
            digests += [self.of(name), self.of(state[name])]
        self.where = before
        return hashed("state", *digests)

    def _named(self, part: Any, name: str) -> bytes:
        module = getattr(part, "__module__", None) or "builtins"
        # In a worker, the script that was started is another than the one that the part comes from.
        strange = module == "__main__" and not hasattr(sys.modules[module], name.partition(".")[0])
        if "<" in name or strange:
            self._refuse(
                f"is or holds {module}.{name}, which cannot be found by that name",
                "write it in a module, outside of any function",
            )
        return hashed("name", module, name, self._source(module))

    def _source(self, name: str) -> bytes:
        if name not in self.sources:
            self.sources[name] = source_of(name)
        return self.sources[name]

    def _refuse(self, what: str, remedy: str) -> NoReturn:
        raise ValueError(f"A result is kept under what it was made by, but {self.where} {what}; {remedy}.")
