"""Python's cycle collector, left out for the length of a block."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def uncollected() -> Iterator[None]:
    """Do not look for cycles of objects that nothing else refers to.

    A search remembers hundreds of thousands of sets and moves, none of them in a cycle: to walk over all of them
    again and again takes a quarter of its time.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
