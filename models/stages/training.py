"""Training of the merging stages: each learns on what the stages before it make of the training images."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import torch
from joblib import delayed
from rich.console import Console
from rich.progress import track
from torch import Tensor

from blockstab.boundaries.edge_models import EdgeModel, FixedWeights
from blockstab.datasets.sets import SceneSet
from blockstab.determinism.fingerprint import fingerprint
from blockstab.executors import each_done
from blockstab.features.appearance.pair_columns import Variant, describe_regions, edgelet_appearance
from blockstab.observation import estimated_ground, observe
from blockstab.proposals.silberman import Order, merged_once
from blockstab.segments.edgelets import trace_edgelets
from models.gathering import kept_tensors
from models.stages.stages import BoostedStage, StagedMerging

MOST_ROWS = 500_000  # of a stage

_SETTINGS = {
    "objective": "binary",
    "learning_rate": 0.3,
    "min_data_in_leaf": 20,
    "deterministic": True,
    "force_row_wise": True,
    "num_threads": 1,
    "verbose": -1,
}


@dataclass(frozen=True)
class StagePlan:
    """Plan of a stage: threshold, trees at most, leaves of a tree."""

    threshold: float
    trees: int
    leaves: int


PLAN = (
    StagePlan(0.9, 30, 20),
    StagePlan(0.8, 30, 20),
    StagePlan(0.7, 30, 20),
    StagePlan(0.7, 30, 10),
    StagePlan(0.7, 30, 10),
)


@dataclass(frozen=True)
class StageTrainer:
    """Trains one classifier after the other (Silberman et al. 2012, section 4.2).

    Args:
        variant: of the features.
        order: in which regions are merged on the way.
        seed: of all that is drawn.
        plan: the stages.
        edges: weighs the cues of an edge between two objects.
    """

    variant: Variant = "fixed"
    order: Order = "best"
    seed: int = 0
    plan: Sequence[StagePlan] = field(default=PLAN)
    edges: EdgeModel = field(default_factory=FixedWeights)

    def __call__(
        self,
        data: SceneSet,
        scenes: Sequence[str],
        provenance: dict[str, Any],
        cache: Path,
        jobs: int = 1,
        overwrite: bool = False,
    ) -> StagedMerging:
        """Train on labelled scenes; with fewer stages than planned where these leave nothing to learn.

        Args:
            scenes: names of the training scenes.
            provenance: what the stages keep of their making; figures of each stage's rows are added.
            cache: folder for the rows of each scene, so that a killed run goes on where it was.
            jobs: scenes worked on side by side.
            overwrite: make the rows anew even where the cache holds them.

        Raises:
            ValueError: the scenes show no border of two objects, or none within one.
        """
        stages: tuple[BoostedStage, ...] = ()
        facts = []
        for number, step in enumerate(self.plan, start=1):
            rows = partial(self.rows, data=data, stages=stages, cache=cache, overwrite=overwrite)
            done = each_done((delayed(rows)(scene) for scene in scenes), jobs)
            title = f"stage {number} of {len(self.plan)}"
            parts = list(track(done, title, len(scenes), console=Console(stderr=True)))
            features, within = (torch.cat(tensors) for tensors in zip(*parts, strict=True))
            if stages and len(torch.unique(within)) < 2:
                # What is left is all right already: on few scenes the earlier stages leave nothing to learn.
                break
            trees, loss = boosted(features, within, step, self.seed)
            stages = (*stages, BoostedStage(step.threshold, trees))
            share = round(float(within.double().mean()), 4)
            facts.append({"rows": len(within), "within_share": share, "loss": round(loss, 5)})
        return StagedMerging(self.variant, stages, {**provenance, "stages": facts})

    def rows(
        self,
        scene: str,
        data: SceneSet,
        stages: tuple[BoostedStage, ...],
        cache: Path,
        overwrite: bool = False,
    ) -> tuple[Tensor, Tensor]:
        """Features (L, 51) of the edgelets that `stages` leave of a scene, and whether they lie within one object.

        Edgelets with a region on either side that has no label are left out.
        """
        kept = self._kept(scene, data, stages, cache, overwrite)
        return kept["features"][kept["known"]], kept["within"][kept["known"]]

    def _kept(
        self,
        scene: str,
        data: SceneSet,
        stages: tuple[BoostedStage, ...],
        cache: Path,
        overwrite: bool = False,
    ) -> dict[str, Tensor]:
        """The regions (H, W), the rows of all their edgelets, and which of these are known to be right or wrong."""

        def make() -> dict[str, Tensor]:
            frame = data.read(scene)[0]
            if frame.label is None:
                raise ValueError(f"{frame.name} has no label.png; training needs the true segments.")
            observation = observe(frame, estimated_ground, self.edges)
            label = observation.fine
            if stages:
                # If all is to be made anew, then this was, for the stage before.
                before = self._kept(scene, data, stages[:-1], cache)
                label = self._merged(before["label"].long(), before["features"], stages)
            edgelets, regions = trace_edgelets(label), describe_regions(observation, label)
            owner = majority(label, frame.label)
            first, second = owner[edgelets.first], owner[edgelets.second]
            return {
                "label": label.int(),
                "features": edgelet_appearance(regions, edgelets, observation.boundary_map, self.variant),
                "known": (first > 0) & (second > 0),
                "within": first == second,
            }

        settings = (
            self.variant,
            self.order,
            self.seed,
            self.edges,
        )  # not the plan: stages say what came of it
        made_by = fingerprint("edgelets", stages, settings, type(data), scene, data.stamp(scene))
        return dict(kept_tensors(cache, made_by, make, overwrite))

    def _merged(self, label: Tensor, features: Tensor, stages: tuple[BoostedStage, ...]) -> Tensor:
        """Regions merged by the last of `stages`, of whose edgelets it is shown the features."""
        within, threshold = stages[-1](features), stages[-1].threshold
        generator = torch.Generator().manual_seed(self.seed + len(stages))
        return merged_once(label, trace_edgelets(label), within, threshold, self.order, generator)


def majority(label: Tensor, truth: Tensor) -> Tensor:
    """The id (R,) that most pixels of each region of `label` (H, W) have in `truth`; of equals the least."""
    ids, index = torch.unique(truth, return_inverse=True)
    inside = label > 0
    count = int(label.max())
    cells = (label[inside] - 1) * len(ids) + index[inside]
    votes = torch.bincount(cells, minlength=count * len(ids)).view(count, len(ids))
    most: Tensor = ids[votes.argmax(dim=1)]
    return most


def boosted(features: Tensor, within: Tensor, step: StagePlan, seed: int) -> tuple[str, float]:
    """LightGBM's text, and the log-loss on the training rows.

    Args:
        features, within: (L, 51) and (L,) bool; a random `MOST_ROWS` of more.
    """
    import lightgbm

    if len(torch.unique(within)) < 2:
        raise ValueError(
            "Stages learn from borders of objects and others within, but there is one kind only."
        )
    if len(within) > MOST_ROWS:
        chosen = torch.randperm(len(within), generator=torch.Generator().manual_seed(seed))[:MOST_ROWS]
        features, within = features[chosen], within[chosen]
    rows = lightgbm.Dataset(features.numpy(), within.numpy().astype("int8"))
    settings = {**_SETTINGS, "num_leaves": step.leaves, "seed": seed}
    found = lightgbm.train(settings, rows, num_boost_round=step.trees)
    sure = torch.from_numpy(found.predict(features.numpy())).clamp(1e-9, 1 - 1e-9)
    loss = torch.nn.functional.binary_cross_entropy(sure, within.to(sure.dtype))
    return found.model_to_string(), float(loss)
