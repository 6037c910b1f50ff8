"""Train what is learned: potentials, stages of merging, weights of edges. `python train.py potential=mlp`."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from datetime import date
from functools import partial
from pathlib import Path
from typing import Any

import hydra
import torch
from omegaconf import DictConfig, OmegaConf

import blockstab
from blockstab.datasets.readable import readable
from blockstab.datasets.sets import SceneSet
from blockstab.datasets.splits import scenes_of
from blockstab.features.columns import feature_set
from models.boundary.training import save_boundary, train_boundary
from models.configured import CONFIGS, example_maker, made, see_own_code
from models.entry import one_line_errors
from models.gathering import gathered
from models.potentials.checkpoint import save_potentials
from models.potentials.fitting import Fitted, fit_all
from models.potentials.potential import fold_of
from models.potentials.rows import joined
from models.stages.stages import save_stages
from models.stages.training import StageTrainer


@hydra.main(config_path=str(CONFIGS), config_name="train", version_base="1.3")
def main(cfg: DictConfig) -> float | None:
    """Train on the scenes of a data set; what is returned is for a sweep to make small."""
    see_own_code()
    with one_line_errors():
        return run(cfg)


def run(cfg: DictConfig) -> float | None:
    """Choose the scenes, and train; the held-out loss, where images are held out."""
    data = made(cfg.data)
    chosen = scenes_of(data, made(cfg.split), cfg.part, Path(cfg.splits))
    train: Callable[..., float | None] = made(cfg.task)
    with made(cfg.executor):
        return train(cfg, data, readable(data, chosen, cfg.strict, cfg.jobs))


def train_potentials(cfg: DictConfig, data: SceneSet, scenes: list[str]) -> float:
    """The potentials of one head: make examples, fit, search with what was fitted for more examples, fit again.

    Returns:
        1 - AUC of the potential of segments, on images that it has not seen; NaN where all are good, or all bad.
    """
    maker = example_maker(
        cfg,
        cfg.examples.starts.values(),
        walks=cfg.examples.walks,
        steps=cfg.examples.steps,
        most_states=cfg.examples.most_states,
    )
    keep = partial(
        gathered, data, seed=cfg.seed, cache=Path(cfg.cache), jobs=cfg.jobs, overwrite=cfg.overwrite
    )
    fit = partial(
        fit_all,
        head=made(cfg.potential),
        features=made(cfg.features),
        target=cfg.fit.target,
        structured=cfg.fit.structured,
        weight=cfg.fit.weight,
        most_rows=cfg.fit.most_rows,
        folds=cfg.fit.folds,
        seed=cfg.seed,
        jobs=cfg.jobs,
        columns=maker.columns,
    )
    examples = keep(scenes, maker)
    found = fit(examples)
    for number in range(cfg.rounds):
        # What a search meets on training scenes, with potentials that had not seen them, they have to judge next.
        fold = fold_of(torch.arange(len(scenes)), cfg.fit.folds)
        drawn = torch.randperm(len(scenes), generator=torch.Generator().manual_seed(cfg.seed + number))
        searched = drawn[: cfg.examples.searched].sort().values
        for k in range(cfg.fit.folds):
            part = searched[fold[searched] == k].tolist()
            visited = replace(maker, search=made(cfg.search), potentials=found.ready(k))
            more = keep([scenes[i] for i in part], visited)
            for i, one in zip(part, more, strict=True):
                examples[i] = joined([examples[i], one])
        found = fit(examples)
    facts = provenance(cfg, len(scenes))
    _saved(Path(cfg.output), found, facts)
    for name in cfg.ablations:
        # The same examples, seen by other columns: what those columns are worth.
        ablated = fit(examples, features=feature_set(name))
        _saved(Path(f"{cfg.output}_{name}"), ablated, {**facts, "ablation": name})
    auc = found.facts["unary"]["held_out_auc"]
    return math.nan if auc is None else 1.0 - float(auc)


def _saved(output: Path, found: Fitted, facts: dict[str, Any]) -> None:
    for kind, of_kind in found.facts.items():
        print(kind, of_kind)
    save_potentials(output, found.potentials, found.weight, {**facts, "potentials": found.facts})
    print(f"potentials in {output}.safetensors and {output}.json")


def train_stages(cfg: DictConfig, data: SceneSet, scenes: list[str]) -> None:
    """The stages of merging that the proposal `silberman` goes through."""
    train = StageTrainer(cfg.variant, seed=cfg.seed, edges=made(cfg.edges))
    merging = train(data, scenes, provenance(cfg, len(scenes)), Path(cfg.cache), cfg.jobs, cfg.overwrite)
    for number, facts in enumerate(merging.provenance["stages"], start=1):
        print(f"stage {number}", facts)
    save_stages(Path(f"{cfg.output}.json"), merging)
    print(f"stages in {cfg.output}.json")


def train_boundaries(cfg: DictConfig, data: SceneSet, scenes: list[str]) -> None:
    """The weights of the cues of an edge, for `edges=learned`."""
    weights, facts = train_boundary(
        data, scenes, provenance(cfg, len(scenes)), Path(cfg.cache), cfg.seed, cfg.jobs, cfg.overwrite
    )
    save_boundary(Path(f"{cfg.output}.json"), weights, facts)
    print(f"area under the ROC curve {facts['roc_area']}; weights in {cfg.output}.json")


def provenance(cfg: DictConfig, images: int) -> dict[str, Any]:
    """Of what, and by what, something was trained."""
    return {
        "date": date.today().isoformat(),
        "versions": {"blockstab": blockstab.__version__, "torch": torch.__version__},
        "images": images,
        "config": json.loads(json.dumps(OmegaConf.to_container(cfg, resolve=False))),
    }
