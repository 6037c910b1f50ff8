"""Examples of many scenes to learn from, each made once and kept."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import partial
from pathlib import Path
from typing import Any

import torch
from joblib import delayed
from rich.console import Console
from rich.progress import track
from safetensors.torch import load_file, save
from torch import Tensor

from blockstab.datasets.sets import SceneSet
from blockstab.determinism.fingerprint import fingerprint
from blockstab.energy.overlap import Parts
from blockstab.executors import each_done
from blockstab.output.export import write_whole
from blockstab.proposals import stamp_of
from models.potentials.examples import ExampleMaker
from models.potentials.rows import KINDS, Examples, Rows, States

_OF_STATES = ("unary", "pairwise", "loss", "error")  # the rest is in `Parts`


def gathered(
    data: SceneSet,
    scenes: list[str],
    maker: ExampleMaker,
    seed: int,
    cache: Path,
    jobs: int,
    overwrite: bool = False,
) -> list[Examples]:
    """The examples of each scene, made once and kept in `cache`; a killed run goes on where it was.

    Args:
        overwrite: make them anew even where the cache holds them.
    """
    make = partial(examples_of, data=data, maker=maker, seed=seed, cache=cache, overwrite=overwrite)
    results = each_done((delayed(make)(scene) for scene in scenes), jobs)
    return list(track(results, "examples", len(scenes), console=Console(stderr=True)))


def examples_of(
    scene: str, data: SceneSet, maker: ExampleMaker, seed: int, cache: Path, overwrite: bool = False
) -> Examples:
    """The examples of one scene, from the cache where it holds them."""

    def make() -> dict[str, Tensor]:
        frame, _ = data.read(scene)
        return as_tensors(maker(frame, scene_generator(scene, seed)))

    stamps = data.stamp(scene), *(stamp_of(part, scene) for part in (*maker.proposals, maker.pool))
    made_by = fingerprint("examples", maker, seed, type(data), scene, stamps)
    return from_tensors(kept_tensors(cache, made_by, make, overwrite))


def as_tensors(examples: Examples) -> dict[str, Tensor]:
    """Every tensor of the examples, by name."""
    found = {f"{k}.{part}": t for k in KINDS for part, t in getattr(examples, k)._asdict().items()}
    states = examples.states
    found.update({f"states.{name}": getattr(states, name) for name in _OF_STATES})
    found.update({f"parts.{f.name}": torch.as_tensor(getattr(states.parts, f.name)) for f in fields(Parts)})
    return found


def from_tensors(kept: Mapping[str, Tensor]) -> Examples:
    """The examples that `as_tensors` took apart."""
    rows = {kind: Rows(*(kept[f"{kind}.{part}"] for part in Rows._fields)) for kind in KINDS}
    parts: dict[str, Any] = {f.name: kept[f"parts.{f.name}"] for f in fields(Parts)}
    whole = {name: kept[f"states.{name}"] for name in _OF_STATES}
    return Examples(**rows, states=States(**whole, parts=Parts(**{**parts, "count": int(parts["count"])})))


def scene_generator(scene: str, seed: int) -> torch.Generator:
    """Generator for a scene, which depends on its name and the seed alone: other code draws the same."""
    digest = hashlib.sha256(f"{seed} {scene}".encode()).digest()
    return torch.Generator().manual_seed(int.from_bytes(digest[:6], "big"))


def kept_tensors(
    cache: Path, made_by: str, make: Callable[[], Mapping[str, Tensor]], overwrite: bool = False
) -> Mapping[str, Tensor]:
    """Tensors by name, made once and kept in a file, which is written whole or not at all.

    Args:
        cache: folder, made where it is not there.
        made_by: the `fingerprint` of all that decides what they are.
        make: makes them; on one thread.
        overwrite: make them even if they are there.
    """
    file = cache / f"{made_by[:32]}.safetensors"
    if file.is_file() and not overwrite:
        return load_file(file)
    torch.set_num_threads(1)
    tensors = {name: t.contiguous() for name, t in make().items()}
    cache.mkdir(parents=True, exist_ok=True)
    write_whole(file, save(tensors))
    return tensors
