"""The door that train.py and evaluate.py share."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def one_line_errors() -> Iterator[None]:
    """Turn what a caller got wrong, or has not installed, into one line on standard error and exit status 1."""
    try:
        yield
    except (ValueError, ModuleNotFoundError) as error:
        raise SystemExit(" ".join(str(error).split())) from None
