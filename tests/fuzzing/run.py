"""Fuzzes readers by hand: python -m tests.fuzzing.run --reader folder --seconds 600 --seed 1."""

from __future__ import annotations

import argparse
import itertools
import sys
import time
from collections import Counter
from collections.abc import Iterator

from tests.fuzzing.harness import Outcome, fuzz
from tests.fuzzing.miniatures import READERS


def main() -> int:
    """Print the counts, and each fault with the number that repeats it; 1 where there was a fault."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--reader", choices=[*READERS, "all"], default="all")
    parser.add_argument("--seconds", type=float, default=60.0, help="for each reader")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--case", type=int, help="only the case of this number")
    parser.add_argument(
        "--patience", type=float, default=30.0, help="seconds without answer, on a busy machine"
    )
    asked = parser.parse_args()
    names = list(READERS) if asked.reader == "all" else [asked.reader]
    numbers = itertools.count() if asked.case is None else [asked.case]
    faults = 0
    for name in names:
        outcomes = fuzz(READERS[name], asked.seed, numbers, asked.patience)
        faults += _report(name, asked.seed, _until(outcomes, time.monotonic() + asked.seconds))
        numbers = itertools.count() if asked.case is None else numbers
    return int(faults > 0)


def _until(outcomes: Iterator[Outcome], end: float) -> Iterator[Outcome]:
    for outcome in outcomes:
        yield outcome
        if time.monotonic() > end:
            return


def _report(name: str, seed: int, outcomes: Iterator[Outcome]) -> int:
    """Print the counts of one reader, and give the number of faults."""
    counts, slowest, largest = Counter[str](), 0.0, 0.0
    for outcome in outcomes:
        counts[outcome.verdict if outcome.sound else "faults"] += 1
        slowest, largest = max(slowest, outcome.seconds), max(largest, outcome.mib)
        if not outcome.sound:
            print(
                f"{name} seed {seed} case {outcome.number}: {outcome.verdict}: {outcome.what}: {outcome.message}"
            )
    print(
        f"{name}: {counts.total()} cases, {counts['refused']} refused, {counts['read']} read, "
        f"{counts['faults']} faults; slowest {1000 * slowest:.0f} ms, largest {largest:.0f} MiB",
        flush=True,
    )
    return counts["faults"]


if __name__ == "__main__":
    sys.exit(main())
