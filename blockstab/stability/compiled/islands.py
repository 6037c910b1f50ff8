"""Relations and verdicts of islands, each in one call of machine code, which is kept on disk."""

from __future__ import annotations

from numba import njit

from blockstab.determinism.machine_code import fingerprint_of
from blockstab.stability.compiled.balance import balanced
from blockstab.stability.compiled.relations import candidate_relations
from blockstab.stability.compiled.things import measured
from blockstab.stability.compiled.trimming import needed


def _kept_while(fingerprint):
    """The two functions of islands; their machine code is made again when the fingerprint is another."""

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


candidates, judged = _kept_while(fingerprint_of("geometry", "stability"))
