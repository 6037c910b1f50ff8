"""Whatever the bytes, a reader reads or refuses: a fixed number of damaged sets each, the same every time.

`python -m tests.fuzzing.run` tries others for as long as one likes.
"""

from __future__ import annotations

import sys

import pytest

from tests.fuzzing.harness import fuzz
from tests.fuzzing.miniatures import READERS

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="memory is measured in /proc")
SEED = 1
CASES = 400
# Readers whose sets cannot be small.
FEWER = {"ocid": 200, "nyu": 200}


@pytest.mark.parametrize("name", READERS)
def test_damaged_files_are_read_or_refused_in_one_line(name: str) -> None:
    # Patient, as a busy machine may let the child wait; the time it works is limited all the same.
    outcomes = list(fuzz(READERS[name], SEED, range(FEWER.get(name, CASES)), patience=30.0))
    faults = [outcome for outcome in outcomes if not outcome.sound]
    assert not faults, f"python -m tests.fuzzing.run --reader {name} --seed {SEED} --case {faults[0].number}"
    # Damage that never gets past the first check, or never does harm, would show nothing.
    assert {outcome.verdict for outcome in outcomes} == {"read", "refused"}
