"""The door that train.py and evaluate.py share."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from hydra.errors import InstantiationException
from hydra.utils import instantiate
from omegaconf import DictConfig

from models.potentials.examples import ExampleMaker


def made(node: DictConfig) -> Any:
    """What a node of a configuration describes; the lists in it are plain lists of what their items describe."""
    # In a list of its own, hydra would turn every dataclass back into a configuration.
    return instantiate(node, _convert_="all")


def example_maker(cfg: DictConfig, starts: Iterable[DictConfig] = (), **settings: Any) -> ExampleMaker:
    """Makes examples as a configuration says.

    Args:
        starts: proposals beside the configured one.
        settings: those of `ExampleMaker` that are numbers.
    """
    return ExampleMaker(
        proposals=[made(proposal) for proposal in (cfg.proposals, *starts)],
        moves=made(cfg.search).moves,
        boundaries=made(cfg.boundaries),
        pool=made(cfg.pool),
        **settings,
    )


@contextmanager
def one_line_errors() -> Iterator[None]:
    """Turn what a caller got wrong, or has not installed, into one line on standard error and exit status 1."""
    try:
        yield
    except (ValueError, ModuleNotFoundError) as error:
        raise SystemExit(" ".join(str(error).split())) from None
    except InstantiationException as error:
        # What a part of the configuration refuses is its caller's mistake; all else keeps its traceback.
        if not isinstance(error.__cause__, (ValueError, ModuleNotFoundError)):
            raise
        raise SystemExit(" ".join(str(error.__cause__).split())) from None
