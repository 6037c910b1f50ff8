"""Train what is learned: potentials, or the stages of merging. `python train.py potential=mlp data=simulated`."""

from __future__ import annotations

import json
from datetime import date
from pathlib import Path
from typing import Any

import hydra
import torch
from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf

import blockstab
from blockstab.datasets.readable import readable
from blockstab.datasets.sets import SceneSet
from blockstab.datasets.splits import scenes_of
from models.boundary import save_boundary, train_boundary
from models.checkpoint import save_potentials
from models.entry import one_line_errors
from models.examples import COLUMNS, ExampleMaker, Examples
from models.gathering import gathered
from models.potential import choose_c, fit_potential
from models.stages import save_stages
from models.staging import StageTrainer


@hydra.main(config_path="configs", config_name="train", version_base="1.3")
def main(cfg: DictConfig) -> None:
    """Train one target on the scenes of a data set."""
    with one_line_errors():
        run(cfg)


def run(cfg: DictConfig) -> None:
    """Choose the scenes, and train."""
    if cfg.target not in TARGETS:
        raise ValueError(f"There is no target {cfg.target!r}; choose from: {', '.join(TARGETS)}.")
    data = instantiate(cfg.data)
    chosen = scenes_of(data, instantiate(cfg.split), cfg.part, Path(cfg.splits))
    TARGETS[cfg.target](cfg, data, readable(data, chosen, cfg.strict, cfg.jobs))


def train_potentials(cfg: DictConfig, data: SceneSet, scenes: list[str]) -> None:
    """The unary, pairwise and merge potentials of one head: make examples, fit each, and save them."""
    maker = ExampleMaker(
        instantiate(cfg.proposals), variants=cfg.variants, boundaries=instantiate(cfg.boundaries)
    )
    examples = gathered(data, scenes, maker, cfg.seed, Path(cfg.cache), cfg.jobs)
    head = instantiate(cfg.potential)
    potentials, facts = {}, {}
    for name in Examples._fields:
        rows = [getattr(e, name) for e in examples]
        group = torch.cat([torch.full((len(r.target),), i) for i, r in enumerate(rows)])
        features, target = torch.cat([r.features for r in rows]), torch.cat([r.target for r in rows])
        chosen = choose_c(features, target, group, COLUMNS[name], head, seed=cfg.seed, jobs=cfg.jobs)
        potentials[name] = fit_potential(
            features, target, group, COLUMNS[name], head, c=chosen.c, seed=cfg.seed, jobs=cfg.jobs
        )
        facts[name] = {
            "rows": len(target),
            "bad_share": round(float(target.mean()), 4),
            "c": chosen.c,
            "held_out_loss": round(chosen.held_out_loss[chosen.c], 5),
        }
        print(name, facts[name])
    save_potentials(Path(cfg.output), potentials, {**provenance(cfg, len(scenes)), "potentials": facts})
    print(f"potentials in {cfg.output}.safetensors and {cfg.output}.json")


def train_stages(cfg: DictConfig, data: SceneSet, scenes: list[str]) -> None:
    """The stages of merging that the proposal `silberman` goes through."""
    train = StageTrainer(cfg.variant, seed=cfg.seed, boundaries=instantiate(cfg.boundaries))
    merging = train(data, scenes, provenance(cfg, len(scenes)), Path(cfg.cache), cfg.jobs)
    for number, facts in enumerate(merging.provenance["stages"], start=1):
        print(f"stage {number}", facts)
    save_stages(Path(f"{cfg.output}.json"), merging)
    print(f"stages in {cfg.output}.json")


def train_boundaries(cfg: DictConfig, data: SceneSet, scenes: list[str]) -> None:
    """The weights of the signs of an edge, for `boundaries=learned`."""
    weights, facts = train_boundary(
        data, scenes, provenance(cfg, len(scenes)), Path(cfg.cache), cfg.seed, cfg.jobs
    )
    save_boundary(Path(f"{cfg.output}.json"), weights, facts)
    print(f"area under the ROC curve {facts['roc_area']}; weights in {cfg.output}.json")


TARGETS = {"potentials": train_potentials, "stages": train_stages, "boundary": train_boundaries}


def provenance(cfg: DictConfig, images: int) -> dict[str, Any]:
    """Of what, and by what, something was trained."""
    return {
        "date": date.today().isoformat(),
        "versions": {"blockstab": blockstab.__version__, "torch": torch.__version__},
        "images": images,
        "config": json.loads(json.dumps(OmegaConf.to_container(cfg, resolve=False))),
    }


if __name__ == "__main__":
    main()
