"""Boundaries learned from labelled scenes: a weight for each cue of an edge, in one small JSON file."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import torch
from joblib import delayed
from rich.console import Console
from rich.progress import track
from scipy.ndimage import distance_transform_edt, gaussian_filter
from torch import Tensor

from blockstab.boundaries.cues import CUES, cues_of
from blockstab.boundaries.edge_models import LogisticWeights
from blockstab.datasets.sets import SceneSet
from blockstab.determinism.fingerprint import fingerprint
from blockstab.evaluation.metrics.borders import borders
from blockstab.executors import each_done
from models.gathering import kept_tensors, scene_generator
from models.shipped import read_learned, write_learned

FORMAT = 1
MAX_BYTES = 2**20
SAMPLES = 10_000  # pixels of each image
CLEAR_PX = 4  # how far from every true boundary there is certainly none
_ORIENT_PX = 2.0  # standard deviation of the blur that tells which way a boundary runs


def train_boundary(
    data: SceneSet,
    scenes: Sequence[str],
    provenance: dict[str, Any],
    cache: Path,
    seed: int = 0,
    jobs: int = 1,
    overwrite: bool = False,
) -> tuple[LogisticWeights, dict[str, Any]]:
    """Fit the weights to the true boundaries of labelled scenes.

    Rows are random pixels. On a true boundary they are cues in the orientation that it has there; far from any, in a
    random orientation. What lies between is left out. As each kind is as frequent as in the images, the strength
    is the probability of a boundary.

    Args:
        cache: folder for the rows of each scene, so that a killed run goes on where it was.
        overwrite: make the rows anew even where the cache holds them.

    Returns:
        The weights, and `provenance` with figures of the fit: rows, and the area under the ROC curve on them.
    """
    from sklearn.linear_model import LogisticRegression
    from sklearn.metrics import roc_auc_score

    rows = partial(boundary_rows, data=data, seed=seed, cache=cache, overwrite=overwrite)
    done = each_done((delayed(rows)(scene) for scene in scenes), jobs)
    parts = list(track(done, "boundaries", len(scenes), console=Console(stderr=True)))
    features, target = (torch.cat(tensors).numpy() for tensors in zip(*parts, strict=True))
    fitted = LogisticRegression(max_iter=1000).fit(features, target)
    area = roc_auc_score(target, fitted.decision_function(features))
    weights = LogisticWeights(tuple(fitted.coef_[0].tolist()), float(fitted.intercept_[0]))
    return weights, {**provenance, "rows": len(target), "roc_area": round(float(area), 4)}


def boundary_rows(
    scene: str, data: SceneSet, seed: int, cache: Path, overwrite: bool = False
) -> tuple[Tensor, Tensor]:
    """Cues (N, 8) float64 of random pixels of a scene, each in one orientation, and (N,) bool: whether a boundary."""

    def make() -> dict[str, Tensor]:
        frame = data.read(scene)[0]
        if frame.label is None:
            raise ValueError(f"{frame.name} has no label.png; training needs the true segments.")
        generator = scene_generator(scene, seed)
        whole = without_holes(frame.label)
        edge = borders(whole)
        away = torch.from_numpy(distance_transform_edt(~edge.numpy())) > CLEAR_PX
        row, column = ((edge | away) & (frame.depth > 0)).nonzero(as_tuple=True)
        chosen = torch.randperm(len(row), generator=generator)[:SAMPLES]
        row, column = row[chosen], column[chosen]
        target = edge[row, column]
        drawn_way = torch.randint(4, (len(row),), generator=generator)
        channel = torch.where(target, orientations(whole)[row, column], drawn_way)
        return {"features": cues_of(frame).values[:, channel, row, column].T.double(), "target": target}

    made_by = fingerprint("boundary", seed, type(data), scene, data.stamp(scene))
    kept = kept_tensors(cache, made_by, make, overwrite)
    return kept["features"], kept["target"]


def without_holes(label: Tensor) -> Tensor:
    """(H, W) labels, where 0 has become that of the nearest pixel that has one."""
    if not bool((label > 0).any()):
        return label
    rows, columns = distance_transform_edt((label == 0).numpy(), return_distances=False, return_indices=True)
    return label[torch.from_numpy(rows).long(), torch.from_numpy(columns).long()]


def orientations(label: Tensor) -> Tensor:
    """(H, W) int64: the channel of `BoundaryMap` that true boundaries run most nearly along.

    The gradients of all blurred regions tell where their borders face.
    """
    tensor = np.zeros((3, *label.shape))
    for region in torch.unique(label).tolist():
        down, right = np.gradient(gaussian_filter((label == region).numpy().astype(np.float64), _ORIENT_PX))
        tensor += np.stack([right * right, down * down, -right * down])
    facing = 0.5 * np.arctan2(2 * tensor[2], tensor[0] - tensor[1])  # counter-clockwise from the x axis
    along = np.rint((facing + math.pi / 2) / (math.pi / 4)).astype(np.int64) % 4
    return torch.from_numpy(along)


def save_boundary(path: Path, weights: LogisticWeights, provenance: dict[str, Any]) -> None:
    """Write a JSON file, whole or not at all."""
    named = dict(zip(CUES, weights.weights, strict=True))
    record = {"format": FORMAT, "weights": named, "bias": weights.bias, "provenance": provenance}
    write_learned(path, record)


def load_boundary(path: Path | str = "boundary") -> LogisticWeights:
    """Read what `save_boundary` wrote.

    Args:
        path: of the JSON file; or a name without folder and suffix, of weights that come with this package.

    Raises:
        CheckpointError: naming the file and what is wrong with it.
    """
    return read_learned(path, "boundary", FORMAT, MAX_BYTES, _weights)


def _weights(record: dict[str, Any]) -> LogisticWeights:
    named = record["weights"]
    if not isinstance(named, dict) or tuple(named) != CUES:
        raise ValueError(f"it must have weights for {', '.join(CUES)}; train it anew.")
    numbers = [float(number) for number in (*named.values(), record["bias"])]
    if not all(map(math.isfinite, numbers)):
        raise ValueError("its numbers must be finite.")
    return LogisticWeights(tuple(numbers[:-1]), numbers[-1])
