"""Every reader of files that there is, each with a small sound set."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.lib.recfunctions import repack_fields
from numpy.typing import NDArray
from PIL import Image

from blockstab.datasets.bop import BOP
from blockstab.datasets.folder import write_scene
from blockstab.datasets.nyu import NYUv2
from blockstab.datasets.ocid import OCID
from blockstab.datasets.osd import OSD
from blockstab.datasets.sets import FolderScenes, SceneSet
from blockstab.datasets.splits import Halves, scenes_of
from blockstab.datasets.sunrgbd import SUNRGBD
from blockstab.datasets.truth import ObjectTruth, Truth
from blockstab.features.appearance.pair_columns import APPEARANCE_COLUMNS
from blockstab.rgbd.frame import Camera, Frame
from blockstab.simulation.physics.verdicts import read_verdict
from models.potentials.checkpoint import load_potentials, save_potentials
from models.potentials.heads import LinearHead, MLPHead, Potential, TreesHead
from models.stages.stages import BoostedStage, StagedMerging, load_stages, save_stages
from models.stages.training import StagePlan, boosted
from tests.datasets.bop_files import write_bop
from tests.datasets.nyu_files import write_nyu
from tests.datasets.pcd_files import seen, table_of, write_cloud
from tests.datasets.scene_names import Names
from tests.datasets.sunrgbd_files import write_sunrgbd
from tests.fuzzing.reader import Reader
from tests.proposals.mask_files import MASKS

WIDTH, HEIGHT = 40, 30  # pixels
CAMERA = Camera(40.0, 41.0, 19.5, 14.5)
LABEL = np.repeat([0, 1, 2, 21, 31], 6)[:, None] + np.zeros((HEIGHT, WIDTH), dtype=np.int64)


def read_set(make: Callable[[Path], SceneSet], root: Path) -> None:
    """Read every scene of a set, and all else that it says."""
    data = make(root)
    for scene in data.scenes():
        data.read(scene)
        data.stamp(scene)
    data.official()


def _frame() -> Frame:
    random = torch.Generator().manual_seed(0)
    color = torch.randint(256, (HEIGHT, WIDTH, 3), generator=random, dtype=torch.uint8)
    depth = 1 + torch.randint(200, (HEIGHT, WIDTH), generator=random).double() / 1000
    return Frame("frame", color, depth, CAMERA, torch.from_numpy(LABEL), (1,))


def write_folders(root: Path) -> None:
    """A scene with all that a scene folder can hold, and a bare one whose colours are a JPEG."""
    half, pose = torch.full((3,), 0.05, dtype=torch.float64), torch.eye(4, dtype=torch.float64)
    full = ObjectTruth(2, "box", half, pose, (1,), (21,), ("surface",), "brick", 300, True)
    boundary = torch.zeros(2, HEIGHT, WIDTH, dtype=torch.bool)
    boundary[:, 3, 3] = True
    up = torch.tensor([0.0, -1.0, 0.0], dtype=torch.float64)
    write_scene(
        root / "full", _frame(), Truth((1,), (full, ObjectTruth(21)), up, True, boundary), {"seed": 3}
    )
    write_scene(root / "bare", replace(_frame(), label=None), Truth((), (), None, False), {})
    _jpeg(root / "bare" / "color.png")


def write_verdict(root: Path) -> None:
    """A file as `write_verdicts` makes it, without the engine."""
    values = {
        "center": [[0.0, 0.1, 0.0], [0.0, 0.3, 0.0]],
        "rotation": [np.eye(3).tolist()] * 2,
        "half_extent": [[0.1, 0.1, 0.1]] * 2,
        "moved": [False, True],
        "simulation": {"seed": 0, "index": 0, "recipe": 1, "versions": {}},
    }
    (root / "verdict_0000.json").write_text(json.dumps(values, indent=1))


def _read_verdict(root: Path) -> None:
    read_verdict(root / "verdict_0000.json")


def write_potentials(root: Path) -> None:
    """Small potentials, of every kind of head."""
    rows = torch.rand(60, 2, generator=torch.Generator().manual_seed(0)).double()
    trees = TreesHead(2, trees=1, leaves=2).grown(rows, rows[:, 0], torch.ones(60).double(), 1.0, 0)
    heads = {"unary": MLPHead(2, 3), "pairwise": LinearHead(2), "alone": trees, "background": LinearHead(2)}
    potentials = {k: Potential(("a", "b"), h, torch.zeros(2), torch.ones(2)) for k, h in heads.items()}
    save_potentials(root / "small", potentials, 0.5, {"seed": 1})


def _read_potentials(root: Path) -> None:
    load_potentials(root / "small.json")


def write_stages(root: Path) -> None:
    """One stage of one small tree."""
    rows = torch.rand(60, len(APPEARANCE_COLUMNS), generator=torch.Generator().manual_seed(0)).double()
    trees, _ = boosted(rows, rows[:, 0] < 0.5, StagePlan(0.9, trees=1, leaves=2), seed=0)
    save_stages(root / "small.json", StagedMerging("fixed", (BoostedStage(0.9, trees),), {"seed": 1}))


def _read_stages(root: Path) -> None:
    load_stages(root / "small.json")


def read_split(root: Path) -> None:
    """The file that keeps a drawn split; it is written when it is first asked for."""
    scenes_of(Names(tuple("abcdefgh")), Halves(), "test", root)


def write_osd(data: str, root: Path) -> None:
    """A labelled cloud of the Object Segmentation Database, and one with an annotation."""
    write_cloud(root / "test" / "test0.pcd", _table(), data)
    write_cloud(root / "pcd" / "learn0.pcd", repack_fields(_table()[["x", "y", "z", "rgb"]]), data)
    _write_png(root / "annotation" / "learn0.png", LABEL.astype(np.uint8))


def write_ocid(root: Path) -> None:
    """A view from images, which must be as large as those of the set, and one from a cloud."""
    sequence = root / "ARID20" / "floor" / "top" / "seq01"
    _write_png(sequence / "rgb" / "a.png", np.full((480, 640, 3), 90, dtype=np.uint8))
    _write_png(sequence / "depth" / "a.png", np.full((480, 640), 1200, dtype=np.uint16))
    _write_png(
        sequence / "label" / "a.png", np.repeat(LABEL, 16, axis=0)[:, :1].repeat(640, 1).astype(np.uint8)
    )
    write_cloud(root / "ARID20" / "table" / "top" / "seq02" / "pcd" / "b.pcd", _table(), "binary_compressed")


def _table() -> NDArray[np.void]:
    frame = _frame()
    return table_of(seen(frame.depth.numpy(), CAMERA), frame.color.numpy(), LABEL)


def _jpeg(path: Path) -> None:
    with Image.open(path) as image:
        image.save(path, format="JPEG", progressive=True)


def _write_png(path: Path, pixels: NDArray[Any]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(pixels).save(path)


_CLOUDS = ("ascii", "binary", "binary_compressed")
READERS = {
    reader.name: reader
    for reader in (
        Reader("folder", write_folders, partial(read_set, FolderScenes), confined=False),
        Reader("verdict", write_verdict, _read_verdict, confined=False),
        Reader("split", read_split, read_split, confined=False),
        Reader("potentials", write_potentials, _read_potentials, confined=False),
        Reader("stages", write_stages, _read_stages, confined=False),
        MASKS,
        *(Reader(f"osd_{data}", partial(write_osd, data), partial(read_set, OSD)) for data in _CLOUDS),
        Reader("ocid", write_ocid, partial(read_set, OCID)),
        Reader("nyu", write_nyu, partial(read_set, NYUv2)),
        Reader("sunrgbd", write_sunrgbd, partial(read_set, SUNRGBD)),
        Reader("bop", write_bop, partial(read_set, BOP)),
    )
}
