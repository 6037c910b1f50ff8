"""The door that all programs share."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from hydra.errors import HydraException, InstantiationException, OverrideParseException
from omegaconf.errors import OmegaConfBaseException


def mistake(error: BaseException) -> str | None:
    """What a caller got wrong, or has not installed, in one line; None where the fault is not the caller's."""
    if isinstance(error, InstantiationException):
        # What a part of the configuration refuses is its caller's mistake; all else keeps its traceback.
        named = "Error locating target" in str(error)
        return _line(str(error)) if named or not error.__cause__ else mistake(error.__cause__)
    if isinstance(error, OverrideParseException):
        return f"The setting {error.override!r} cannot be read: {_line(error.message)}."
    if isinstance(error, OSError) and error.strerror:
        place = error.filename or "a file"
        return f"{place}: {error.strerror}; once that is mended, the same command goes on where it stopped."
    if isinstance(error, (ValueError, ModuleNotFoundError, HydraException, OmegaConfBaseException)):
        return _line(str(error))
    return None


@contextmanager
def one_line_errors() -> Iterator[None]:
    """Turn mistakes into one line on standard error and exit status 1."""
    try:
        yield
    except Exception as error:
        said = mistake(error)
        if said is None:
            raise
        raise SystemExit(said) from None


def _line(text: str) -> str:
    # Where hydra looked is of no use to who misspelt a name.
    return " ".join(text.split("Config search path")[0].split())
