"""Warming up goes through all machine code that a parse asks for."""

from __future__ import annotations

from blockstab.boxes.compiled.fits import fitted
from blockstab.commands.warm_up import warm_up
from blockstab.features.compiled.members import around, maxima, sums
from blockstab.features.compiled.nearness import labels_near
from blockstab.features.compiled.outlines import outlines
from blockstab.stability.compiled.islands import candidates, judged


def test_all_machine_code_is_made_or_loaded_by_one_parse_of_blocks():
    parsed = warm_up()
    assert len(parsed.ids) > 1
    for function in (fitted, around, maxima, sums, labels_near, outlines, candidates, judged):
        assert len(function.signatures) > 0


def test_a_second_parse_makes_none_anew():
    warm_up()
    functions = (fitted, around, maxima, sums, labels_near, outlines, candidates, judged)
    before = [len(function.signatures) for function in functions]
    warm_up()
    assert [len(function.signatures) for function in functions] == before
