"""One of every part that comes with the package, and parts as a user may write them."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path

import numpy as np
import torch
from omegaconf import OmegaConf
from torch import Tensor, nn

from blockstab.boundaries.edge_models import FixedWeights
from blockstab.boxes.fitting import MinimumSurface
from blockstab.boxes.minimum_volume import MinimumVolume
from blockstab.datasets.bop import BOP
from blockstab.datasets.nyu import NYUv2
from blockstab.datasets.ocid import OCID
from blockstab.datasets.osd import OSD
from blockstab.datasets.sets import FolderScenes
from blockstab.datasets.sunrgbd import SUNRGBD
from blockstab.determinism.fingerprint import fingerprint
from blockstab.energy.overlap import expected_overlap
from blockstab.energy.paper import paper_energy
from blockstab.energy.truth import true_overlap
from blockstab.features.columns import feature_set
from blockstab.observation import Observation, estimated_ground, given_ground
from blockstab.parsing.parser import Parser
from blockstab.proposals import Proposed
from blockstab.proposals.felzenszwalb import Felzenszwalb
from blockstab.proposals.files import LabelFile, MaskFile
from blockstab.proposals.plane_dbscan import PlaneDBSCAN
from blockstab.proposals.plane_pieces import Planes
from blockstab.proposals.pool import NoMasks, Regions
from blockstab.proposals.watershed import Watershed
from blockstab.scene.inference import Rules
from blockstab.search.best_cut import BestCut
from blockstab.search.greedy import Greedy
from blockstab.search.moves.every import EVERY
from blockstab.search.none import NoSearch
from blockstab.search.rsamp import RSamp
from blockstab.search.truth import Truth
from blockstab.simulation.cached import SimulatedScenes
from models.boundary.training import load_boundary
from models.potentials.examples import ExampleMaker
from models.potentials.heads import LinearHead, MLPHead, TreesHead
from models.potentials.parsing import parsing_potentials
from models.stages.stages import silberman
from tests.toy_potentials import toy_potentials

ROOT = Path(__file__).resolve().parents[1]


class Plain:
    """A proposal that is no dataclass, so that its `repr` tells where it lies in memory and nothing else."""

    def __init__(self, least_px: int = 7) -> None:
        self.least_px = least_px
        self.words = {"table", "floor", "wall", "shelf"}
        self.net = nn.Sequential(nn.Linear(2, 1), nn.Dropout(0.1)).requires_grad_(False)
        for parameter in self.net.parameters():
            parameter.fill_(0.5)
        self.limits = np.arange(3, dtype=np.float32)
        self.settings = OmegaConf.create({"around": 1, "mine": [1, 2]}).mine
        self.draw = torch.Generator().manual_seed(5)
        self.path = Path("masks")
        self.rule = partial(np.clip, a_min=0)
        self.bound = self.known
        self.around = {"me": self}

    def known(self) -> dict[int, bool]:
        return {1: True}

    def __call__(self, observation: Observation) -> Proposed:
        return Proposed(observation.fine, self.known())


@dataclass(frozen=True)
class Noted:
    """A dataclass with a note, and with something worked out on the way."""

    size: int = 1
    note: str = field(default="", compare=False)

    @cached_property
    def doubled(self) -> int:
        return 2 * self.size


class Sparing:
    """Keeps an open file to itself."""

    def __init__(self, size: int = 1) -> None:
        self.size = size
        self.log = Path(__file__).open()  # noqa: SIM115

    def __getstate__(self) -> dict[str, int]:
        return {"size": self.size}


def doubled(value: Tensor) -> Tensor:
    """A function of a user's module."""
    return 2 * value


EVERY_PART: dict[str, Callable[[], object]] = {
    "watershed": Watershed,
    "felzenszwalb": Felzenszwalb,
    "planes": Planes,
    "plane dbscan": PlaneDBSCAN,
    "silberman": silberman,
    "labels": LabelFile,
    "files": lambda: MaskFile("masks/{scene}.json"),
    "greedy": Greedy,
    "best cut": BestCut,
    "truth": Truth,
    "rsamp": RSamp,
    "rsamp from the start": lambda: RSamp(first=(NoSearch(),)),
    "none": NoSearch,
    **{type(move).__name__: type(move) for move in EVERY},
    "expected overlap": lambda: expected_overlap,
    "energy of the paper": lambda: paper_energy,
    "true overlap": lambda: true_overlap,
    "no masks": NoMasks,
    "pool": lambda: Regions((Watershed(), Planes())),
    "features": lambda: feature_set("paper"),
    "fixed": FixedWeights,
    "learned": load_boundary,
    "minimum surface": MinimumSurface,
    "minimum volume": MinimumVolume,
    "rules": Rules,
    "estimate": lambda: estimated_ground,
    "meta": lambda: given_ground,
    "linear head": lambda: LinearHead,
    "mlp head": lambda: partial(MLPHead, hidden=8),
    "trees head": lambda: partial(TreesHead, trees=9),
    "mlp": lambda: parsing_potentials("mlp"),
    "svm": lambda: parsing_potentials("svm"),
    "trees": lambda: parsing_potentials("trees"),
    "parser": lambda: Parser(Watershed(), RSamp(), toy_potentials()),
    "examples": lambda: ExampleMaker((Watershed(),), EVERY),
    **{
        kind.__name__: partial(lambda kind: kind, kind)
        for kind in (FolderScenes, SimulatedScenes, BOP, NYUv2, OCID, OSD, SUNRGBD)
    },
    "no dataclass": Plain,
    "dataclass": Noted,
    "with a state of its own": Sparing,
    "function": lambda: doubled,
    "class": lambda: Plain,
}


def fingerprints() -> dict[str, str]:
    """That of every part by itself."""
    return {name: fingerprint(make()) for name, make in EVERY_PART.items()}


def in_another_process(program: str, seed: int) -> str:
    """What a program prints, with its sets and dictionaries hashed in another way."""
    environment = {**os.environ, "PYTHONHASHSEED": str(seed), "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", program]
    return subprocess.run(
        command, cwd=ROOT, env=environment, capture_output=True, text=True, check=True
    ).stdout
