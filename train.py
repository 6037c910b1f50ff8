"""Train potentials: examples, then heads. `python train.py potential=mlp data=simulated output=out/mine`."""

from __future__ import annotations

import hashlib
import json
from datetime import date
from functools import partial
from pathlib import Path
from typing import Any

import hydra
import torch
from hydra.utils import instantiate
from joblib import Parallel, delayed
from omegaconf import DictConfig, OmegaConf
from rich.console import Console
from rich.progress import track
from safetensors.torch import load_file, save

import blockstab
from blockstab.datasets.readable import readable
from blockstab.datasets.sets import SceneSet
from blockstab.datasets.splits import scenes_of
from blockstab.export import write_whole
from models.checkpoint import save_potentials
from models.entry import one_line_errors
from models.examples import COLUMNS, ExampleMaker, Examples, Rows
from models.potential import choose_c, fit_potential


@hydra.main(config_path="configs", config_name="train", version_base="1.3")
def main(cfg: DictConfig) -> None:
    """Train the unary, pairwise and merge potentials of one head."""
    with one_line_errors():
        run(cfg)


def run(cfg: DictConfig) -> None:
    """Make examples, fit each potential, and save them."""
    data = instantiate(cfg.data)
    chosen = scenes_of(data, instantiate(cfg.split), cfg.part, Path(cfg.splits))
    scenes = readable(data, chosen, cfg.strict, cfg.jobs)
    maker = ExampleMaker(instantiate(cfg.proposals), variants=cfg.variants)
    examples = gathered(data, scenes, maker, cfg.seed, Path(cfg.cache), cfg.jobs)
    head = instantiate(cfg.potential)
    potentials, facts = {}, {}
    for name in Examples._fields:
        rows = [getattr(e, name) for e in examples]
        group = torch.cat([torch.full((len(r.target),), i) for i, r in enumerate(rows)])
        features, target = torch.cat([r.features for r in rows]), torch.cat([r.target for r in rows])
        chosen = choose_c(features, target, group, COLUMNS[name], head, seed=cfg.seed)
        potentials[name] = fit_potential(
            features, target, group, COLUMNS[name], head, c=chosen.c, seed=cfg.seed
        )
        facts[name] = {
            "rows": len(target),
            "bad_share": round(float(target.mean()), 4),
            "c": chosen.c,
            "held_out_loss": round(chosen.held_out_loss[chosen.c], 5),
        }
        print(name, facts[name])
    save_potentials(Path(cfg.output), potentials, provenance(cfg, len(scenes), facts))
    print(f"potentials in {cfg.output}.safetensors and {cfg.output}.json")


def gathered(
    data: SceneSet, scenes: list[str], maker: ExampleMaker, seed: int, cache: Path, jobs: int
) -> list[Examples]:
    """The examples of each scene, made once and kept in `cache`; a killed run goes on where it was."""
    cache.mkdir(parents=True, exist_ok=True)
    make = partial(examples_of, data=data, maker=maker, seed=seed, cache=cache)
    results = Parallel(n_jobs=jobs, return_as="generator")(delayed(make)(scene) for scene in scenes)
    return list(track(results, "examples", len(scenes), console=Console(stderr=True)))


def examples_of(scene: str, data: SceneSet, maker: ExampleMaker, seed: int, cache: Path) -> Examples:
    """The examples of one scene, from the cache where it holds them."""
    torch.set_num_threads(1)
    made_of = f"{blockstab.__version__} {maker} {seed} {data.stamp(scene)}"
    digest = hashlib.sha256(made_of.encode())
    file = cache / f"{digest.hexdigest()[:32]}.safetensors"
    if file.is_file():
        kept = load_file(file)
        return Examples(*(Rows(kept[f"{n}.features"], kept[f"{n}.target"]) for n in Examples._fields))
    drawn = int.from_bytes(digest.digest()[:6], "big")
    frame, _ = data.read(scene)
    examples = maker(frame, torch.Generator().manual_seed(drawn))
    tensors = {
        f"{name}.{part}": tensor.contiguous()
        for name, rows in examples._asdict().items()
        for part, tensor in rows._asdict().items()
    }
    write_whole(file, save(tensors))
    return examples


def provenance(cfg: DictConfig, images: int, facts: dict[str, Any]) -> dict[str, Any]:
    """What the potentials were made of."""
    return {
        "date": date.today().isoformat(),
        "versions": {"blockstab": blockstab.__version__, "torch": torch.__version__},
        "images": images,
        "config": json.loads(json.dumps(OmegaConf.to_container(cfg, resolve=False))),
        "potentials": facts,
    }


if __name__ == "__main__":
    main()
