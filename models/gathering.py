"""What is computed of many scenes to learn from, each made once and kept."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

import torch
from joblib import Parallel, delayed
from rich.console import Console
from rich.progress import track
from safetensors.torch import load_file, save
from torch import Tensor

import blockstab
from blockstab.datasets.sets import SceneSet
from blockstab.export import write_whole
from models.examples import COLUMNS, ExampleMaker, Examples, Rows


def gathered(
    data: SceneSet, scenes: list[str], maker: ExampleMaker, seed: int, cache: Path, jobs: int
) -> list[Examples]:
    """The examples of each scene, made once and kept in `cache`; a killed run goes on where it was."""
    make = partial(examples_of, data=data, maker=maker, seed=seed, cache=cache)
    results = Parallel(n_jobs=jobs, return_as="generator")(delayed(make)(scene) for scene in scenes)
    return list(track(results, "examples", len(scenes), console=Console(stderr=True)))


def examples_of(scene: str, data: SceneSet, maker: ExampleMaker, seed: int, cache: Path) -> Examples:
    """The examples of one scene, from the cache where it holds them."""

    def make(drawn: int) -> dict[str, Tensor]:
        frame, _ = data.read(scene)
        examples = maker(frame, torch.Generator().manual_seed(drawn))
        return {
            f"{name}.{part}": tensor
            for name, rows in examples._asdict().items()
            for part, tensor in rows._asdict().items()
        }

    kept = kept_tensors(cache, f"{maker} {COLUMNS} {seed} {data.stamp(scene)}", make)
    return Examples(*(Rows(kept[f"{n}.features"], kept[f"{n}.target"]) for n in Examples._fields))


def kept_tensors(
    cache: Path, made_of: str, make: Callable[[int], Mapping[str, Tensor]]
) -> Mapping[str, Tensor]:
    """Tensors by name, made once and kept in a file, which is written whole or not at all.

    Args:
        cache: folder, made where it is not there.
        made_of: all that decides what they are, but for this package's version.
        make: makes them, given a seed that depends on `made_of` alone; on one thread.
    """
    digest = hashlib.sha256(f"{blockstab.__version__} {made_of}".encode())
    file = cache / f"{digest.hexdigest()[:32]}.safetensors"
    if file.is_file():
        return load_file(file)
    torch.set_num_threads(1)
    tensors = {name: t.contiguous() for name, t in make(int.from_bytes(digest.digest()[:6], "big")).items()}
    cache.mkdir(parents=True, exist_ok=True)
    write_whole(file, save(tensors))
    return tensors
