"""Objects from configurations: a parser, and the methods of an experiment."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from hydra import compose, initialize_config_dir
from hydra.utils import get_class, instantiate
from omegaconf import DictConfig, OmegaConf

import blockstab
from blockstab.features.columns import SegmentColumns
from blockstab.parsing.parser import Parser
from models.potentials.examples import ExampleMaker
from models.potentials.heads import HEADS
from models.potentials.parsing import ParsingPotentials, parsing_potentials

# Beside the package where it is installed, and in the root of a checkout.
_PLACES = (Path(blockstab.__file__).parent / "configs", Path(blockstab.__file__).parents[1] / "configs")
CONFIGS = next(place for place in _PLACES if place.is_dir())
# What a parser is made of: groups and values of `parse.yaml`, by the names that `Parser` has for them.
PARTS = {
    "proposals": "proposal",
    "search": "search",
    "energy": "energy",
    "pool": "pool",
    "edges": "edges",
    "rules": "rules",
    "ground": "ground_of",
    "potentials": "potentials",
    "concluding": "concluding",
    "seed": "seed",
}


def made(node: DictConfig) -> Any:
    """Object that a node of a configuration describes; lists in it are plain lists of what their items describe."""
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
        edges=made(cfg.edges),
        pool=made(cfg.pool),
        columns=own_columns(cfg),
        **settings,
    )


def own_columns(cfg: DictConfig) -> tuple[SegmentColumns, ...]:
    """The columns of segments that a configuration adds to ours."""
    return tuple(made(cfg.columns).values())


def composed(
    name: str, overrides: Sequence[str], values: Mapping[str, Any], folder: Path | None = None
) -> DictConfig:
    """A configuration, as a program of that name would have it.

    Args:
        overrides: in hydra's words, such as `search=greedy`.
        values: what is set after that, word for word, by its place, such as `proposals.path`.
        folder: more configurations, as for hydra's `--config-dir`; what they name may lie in the working folder.

    Raises:
        hydra.errors.HydraException, omegaconf.errors.OmegaConfBaseException: if they do not fit together.
    """
    more = []
    if folder is not None:
        see_own_code()
        more = [f"hydra.searchpath=['file://{folder.resolve()}']"]
    with initialize_config_dir(str(CONFIGS), version_base="1.3"):
        cfg = compose(name, [*more, *overrides])
    for place, value in values.items():
        OmegaConf.update(cfg, place, value, force_add=False)
    return cfg


def see_own_code() -> None:
    """Let configurations name what lies in the working folder, as for `python -m`."""
    if "" not in sys.path and str(Path.cwd()) not in sys.path:
        sys.path.insert(0, str(Path.cwd()))


class ParserMaker:
    """Makes parsers of configurations. Parts that are configured alike are one: what they compute is shared."""

    def __init__(self, heads: Iterable[str] = (), columns: Sequence[SegmentColumns] = ()) -> None:
        """Nothing is known yet but what potentials may ask for.

        Args:
            heads: paths of classes that they may name, beside ours.
            columns: of segments, beside ours.
        """
        self._known: dict[str, Any] = {}
        self._columns = columns
        own: list[Any] = [get_class(path) for path in heads]
        self._heads = {**HEADS, **{head.name: head for head in own}}

    def __call__(self, usual: DictConfig, given: Mapping[str, Any] | None = None) -> Parser:
        """The parser of a configuration like `parse.yaml`; `given` has those of its parts that are to be others."""
        nodes = {name: usual[name] for name in PARTS} | dict(given or {})
        parts = {PARTS[name]: self._part(name, node) for name, node in nodes.items()}
        return Parser(**parts, columns=self._columns)

    def _part(self, name: str, node: Any) -> Any:
        key = OmegaConf.to_yaml(node, resolve=True) if OmegaConf.is_config(node) else f"{name}: {node}"
        if key not in self._known:
            self._known[key] = self._made(name, node)
        return self._known[key]

    def _made(self, name: str, node: Any) -> Any:
        if name == "seed":
            return int(node)
        return self.potentials(node) if name == "potentials" else made(node)

    def potentials(self, path: str) -> ParsingPotentials:
        """The potentials of a path, or of a shipped name."""
        return parsing_potentials(path, self._heads, self._columns)


def parser_maker(cfg: DictConfig) -> ParserMaker:
    """Makes parsers whose potentials may name the heads and the columns that a configuration adds to ours."""
    return ParserMaker(cfg.heads, own_columns(cfg))
