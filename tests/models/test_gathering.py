"""Examples are made once for what they are made by, and drawn alike by any code."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import pytest
import torch

from blockstab.datasets.sets import FolderScenes
from blockstab.datasets.truth import Truth
from blockstab.determinism import fingerprint
from blockstab.proposals.files import MaskFile
from blockstab.proposals.pool import Regions
from blockstab.proposals.watershed import Watershed
from blockstab.rgbd.frame import Frame
from blockstab.scene.inference import Rules
from blockstab.search.moves.merge import Merge
from blockstab.search.moves.split import Split
from blockstab.stability.judges import EverySupport
from blockstab.testing.photographs import BLOCKS, photograph
from models.gathering import as_tensors, from_tensors, gathered, scene_generator
from models.potentials.examples import ExampleMaker
from models.potentials.rows import Examples
from tests.synthetic import write_folder
from tests.toy_potentials import toy_potentials

MAKER = ExampleMaker((Watershed(),), (Split(), Merge()), walks=1, steps=1, most_masks=5)


@dataclass(frozen=True)
class Watched(FolderScenes):
    """Scene folders, which keep account of what is read."""

    reads: list[str] = field(default_factory=list)

    def read(self, scene: str) -> tuple[Frame, Truth]:
        self.reads.append(scene)
        return super().read(scene)


@pytest.fixture(autouse=True)
def threads() -> Iterator[None]:
    """Making takes one thread; the tests after it get theirs back."""
    before = torch.get_num_threads()
    yield
    torch.set_num_threads(before)


@pytest.fixture
def data(tmp_path: Path) -> Watched:
    """Two scenes, of two blocks and of three."""
    for k in range(2):
        write_folder(photograph(*BLOCKS[: k + 2], seed=k).frame, tmp_path / "scenes" / f"scene{k}")
    return Watched(tmp_path / "scenes")


def made(
    data: Watched, maker: ExampleMaker = MAKER, seed: int = 0, overwrite: bool = False
) -> list[Examples]:
    """The examples of all scenes, from a cache beside them."""
    return gathered(data, data.scenes(), maker, seed, Path(data.root).parent / "cache", 1, overwrite)


def alike(one: list[Examples], other: list[Examples]) -> bool:
    """Whether all rows are equal, bit for bit."""
    pairs = [(as_tensors(a), as_tensors(b)) for a, b in zip(one, other, strict=True)]
    return all(
        a.keys() == b.keys()
        and all(torch.equal(a[name], b[name]) and a[name].dtype == b[name].dtype for name in a)
        for a, b in pairs
    )


def test_examples_that_are_there_are_not_made_again_unless_told_to(data):
    first = made(data)
    assert alike(first, made(data))
    assert data.reads == ["scene0", "scene1"]
    assert alike(first, made(data, overwrite=True))
    assert data.reads == ["scene0", "scene1"] * 2


def test_examples_come_back_whole_from_what_is_kept_of_them(data):
    (one, _) = made(data)
    back = from_tensors(as_tensors(one))
    assert alike([one], [back])
    assert back.states.parts.count == one.states.parts.count == len(one.states.error)
    assert isinstance(back.states.parts.count, int)
    (kept, _) = made(data)  # from the file
    assert isinstance(kept.states.parts.count, int)
    assert kept.states.parts.count == one.states.parts.count


def test_other_code_makes_them_anew_from_the_same_draws(data, monkeypatch):
    first = made(data)
    monkeypatch.setattr(fingerprint, "own_sources", lambda: "a line more")
    assert alike(first, made(data))
    assert data.reads == ["scene0", "scene1"] * 2


@pytest.mark.parametrize(
    "change",
    [
        {"walks": 2},
        {"rules": Rules(judge=EverySupport())},
        {"proposals": (Watershed(least_px=300),)},
        {"moves": (Split(),)},
        {"pool": Regions((Watershed(),))},
        {"potentials": toy_potentials()},
    ],
    ids=["walks", "rules", "proposals", "moves", "pool", "potentials"],
)
def test_other_settings_make_them_anew(data, change):
    made(data)
    made(data, replace(MAKER, **change))
    assert data.reads == ["scene0", "scene1"] * 2


def test_another_seed_makes_others(data):
    assert not alike(made(data), made(data, seed=1))


@pytest.mark.parametrize(
    "reading",
    [
        lambda path: {"proposals": (MaskFile(path),)},
        lambda path: {"pool": Regions((Watershed(), MaskFile(path)))},
    ],
    ids=["proposal", "pool"],
)
def test_changed_masks_of_a_scene_make_its_examples_anew(data, tmp_path, reading):
    maker = replace(MAKER, **reading(f"{tmp_path}/scenes/{{scene}}/masks.png"))
    for k in range(2):
        shutil.copy(tmp_path / f"scenes/scene{k}/label.png", tmp_path / f"scenes/scene{k}/masks.png")
    made(data, maker)
    shutil.copy(tmp_path / "scenes/scene0/masks.png", tmp_path / "scenes/scene1/masks.png")
    made(data, maker)
    assert data.reads == ["scene0", "scene1", "scene1"]


def test_what_is_drawn_for_a_scene_depends_on_its_name_and_the_seed():
    drawn = {
        (scene, seed): int(torch.randint(2**40, (1,), generator=scene_generator(scene, seed)))
        for scene in ("one", "two", "one")
        for seed in (0, 1)
    }
    assert len(set(drawn.values())) == 4
