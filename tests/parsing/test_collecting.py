"""The cycle collector is left out of a block, and as it was after it."""

from __future__ import annotations

import gc

import pytest

from blockstab.parsing.collecting import uncollected


def fails_inside() -> None:
    with uncollected():
        assert not gc.isenabled()
        raise KeyError


@pytest.mark.parametrize("was_on", [True, False])
def test_the_collector_is_off_inside_and_as_it_was_after_a_fault_too(was_on):
    before = gc.isenabled()
    try:
        (gc.enable if was_on else gc.disable)()
        with pytest.raises(KeyError):
            fails_inside()
        assert gc.isenabled() == was_on
    finally:
        (gc.enable if before else gc.disable)()
