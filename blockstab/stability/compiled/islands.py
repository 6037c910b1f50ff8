"""Relations and verdicts of islands, each in one call of machine code, which is kept on disk."""

from __future__ import annotations

import hashlib
from pathlib import Path

from numba import njit

from blockstab.stability.compiled.balance import balanced
from blockstab.stability.compiled.relations import candidate_relations
from blockstab.stability.compiled.things import measured
from blockstab.stability.compiled.trimming import needed

_PACKAGE = Path(__file__).resolve().parents[2]


def _fingerprint():
    """Of all the files that the machine code is made from."""
    files = [_PACKAGE / "geometry" / "polygons.py", *sorted((_PACKAGE / "stability").rglob("*.py"))]
    return int.from_bytes(hashlib.sha256(b"".join(file.read_bytes() for file in files)).digest()[:7])


def _kept_while(fingerprint):
    """The two functions of islands; their machine code is made again when the fingerprint is another."""

    # Of itself numba only sees when the file of a function changes. What it names from outside is part of what it is
    # known by.
    @njit(cache=True, error_model="numpy")
    def candidates(given, pairs, limits):
        _ = fingerprint
        return candidate_relations(measured(given, limits), pairs, limits)

    @njit(cache=True, error_model="numpy")
    def judged(bodies, relations):
        _ = fingerprint
        kept = needed(bodies, relations)
        return kept, balanced(bodies, relations, kept)

    return candidates, judged


candidates, judged = _kept_while(_fingerprint())
