"""Relations and verdicts of islands in one call of machine code, which is kept on disk."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
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
    """The function that judges islands; its machine code is made again when the fingerprint is another."""

    @njit(cache=True, error_model="numpy")
    def judged(given, pairs, limits, trimming):
        # Of itself numba only sees when the file of this function changes. What a function names from outside is part
        # of what it is known by.
        _ = fingerprint
        things = measured(given, limits)
        candidates = candidate_relations(things, pairs, limits)
        kept = needed(things, candidates) if trimming else np.ones(len(candidates.type), dtype=np.bool_)
        return candidates, kept, balanced(things, candidates, kept)

    return judged


judged = _kept_while(_fingerprint())
