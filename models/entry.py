"""The door that all programs share."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NoReturn


def mistake(error: BaseException, place: str = "a file") -> str | None:
    """The caller's mistake, or what is not installed, in one line; None where the fault is not the caller's.

    Args:
        place: what could not be read or written, where the error does not say it.
    """
    # The command line asks about mistakes alone; hydra takes longer to load than the rest of its start.
    from hydra.errors import HydraException, InstantiationException, OverrideParseException
    from omegaconf.errors import OmegaConfBaseException

    if isinstance(error, InstantiationException):
        # What a part of the configuration refuses is its caller's mistake; all else keeps its traceback.
        named = "Error locating target" in str(error)
        return _line(str(error)) if named or not error.__cause__ else mistake(error.__cause__, place)
    if isinstance(error, OverrideParseException):
        return f"The setting {error.override!r} cannot be read: {_line(error.message)}."
    if isinstance(error, OSError) and error.strerror:
        where = error.filename or place
        return f"{where}: {error.strerror}; once that is mended, the same command goes on where it stopped."
    if isinstance(error, (ValueError, ModuleNotFoundError, HydraException, OmegaConfBaseException)):
        return _line(str(error))
    return None


def leave(said: str) -> NoReturn:
    """Print a line on standard error, and leave with status 1."""
    raise SystemExit(said)


@contextmanager
def one_line_errors(stop: Callable[[str], NoReturn] = leave, place: str = "a file") -> Iterator[None]:
    """Hand mistakes, each in one line, to `stop`; all else keeps its traceback. `place` is as in `mistake`."""
    try:
        yield
    except Exception as error:
        said = mistake(error, place)
        if said is None:
            raise
        stop(said)


def _line(text: str) -> str:
    # Where hydra looked is of no use to who misspelt a name.
    return " ".join(text.split("Config search path")[0].split())
