"""Training of stages: which borders they learn from, and that each learns on what the others leave."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest
import torch
from torch import Tensor

from blockstab.datasets.truth import Truth
from blockstab.features.appearance.pair_columns import APPEARANCE_COLUMNS
from blockstab.proposals.silberman import Silberman
from blockstab.rgbd.frame import Frame
from blockstab.segments.edgelets import trace_edgelets
from models.stages.training import PLAN, StagePlan, StageTrainer, boosted, majority
from tests.block_scene import APART, STACK, picture

SHORT = (StagePlan(0.7, 6, 4), StagePlan(0.6, 6, 4))


@cache
def photo(name: str) -> Frame:
    return picture({"apart": APART, "stack": STACK}[name.removesuffix("_unlabelled")]).frame


@dataclass
class Pictures:
    """A set of two made-up pictures, which counts how often they are read."""

    name: str = "pictures"
    read_count: int = 0

    def scenes(self) -> list[str]:
        return ["apart", "stack"]

    def read(self, scene: str) -> tuple[Frame, Truth]:
        self.read_count += 1
        frame = photo(scene)
        assert frame.label is not None
        if scene.endswith("_unlabelled"):
            frame = dataclasses.replace(frame, label=torch.where(frame.label == 2, 0, frame.label))
        return frame, Truth((1,), (), None, False)

    def stamp(self, scene: str) -> str:
        return scene

    def official(self) -> Mapping[str, Sequence[str]]:
        return {}


def test_the_plan_is_that_of_the_paper() -> None:
    assert [step.threshold for step in PLAN] == [0.9, 0.8, 0.7, 0.7, 0.7]
    assert [step.trees for step in PLAN] == [30] * 5
    assert [step.leaves for step in PLAN] == [20, 20, 20, 10, 10]


@pytest.mark.parametrize(
    ("pixels", "owner"),
    [((40, 35, 25), 1), ((20, 20, 60), 0), ((35, 40, 25), 2), ((50, 50, 0), 1)],
    ids=["most", "unlabelled", "second", "tie"],
)
def test_a_region_is_of_the_object_that_most_of_its_pixels_have(pixels: tuple[int, ...], owner: int) -> None:
    truth = torch.repeat_interleave(torch.tensor([1, 2, 0]), torch.tensor(pixels))[None]
    assert majority(torch.ones_like(truth), truth).tolist() == [owner]


def test_every_region_has_an_owner_and_pixels_outside_do_not_vote() -> None:
    label = torch.tensor([[1, 1, 2, 2, 0, 0, 0]])
    truth = torch.tensor([[5, 5, 7, 7, 9, 9, 9]])
    assert majority(label, truth).tolist() == [5, 7]


def test_a_border_is_within_one_object_if_both_its_sides_are_of_it(tmp_path: Path) -> None:
    trainer, data = StageTrainer(plan=SHORT), Pictures()
    features, within = trainer.rows("stack", data, (), tmp_path)
    assert features.shape == (len(within), len(APPEARANCE_COLUMNS))
    assert within.dtype == torch.bool
    assert 0 < int(within.sum()) < len(within)


def test_borders_of_what_has_no_label_are_left_out(tmp_path: Path) -> None:
    trainer, data = StageTrainer(plan=SHORT), Pictures()
    whole = len(trainer.rows("stack", data, (), tmp_path)[1])
    part = len(trainer.rows("stack_unlabelled", data, (), tmp_path)[1])
    assert 0 < part < whole


def test_rows_are_of_the_edgelets_that_earlier_stages_leave(tmp_path: Path) -> None:
    trainer, data = StageTrainer(plan=SHORT), Pictures()
    stages = trainer(data, data.scenes(), {}, tmp_path).stages
    first, second = (len(trainer.rows("stack", data, stages[:n], tmp_path)[1]) for n in (0, 1))
    assert 0 < second < first
    observation = picture(STACK).observation
    assert first <= len(trace_edgelets(observation.fine))


def test_training_twice_gives_the_same_stages_and_from_the_cache_nothing_is_read(tmp_path: Path) -> None:
    one, again, elsewhere = Pictures(), Pictures(), Pictures()
    trainer = StageTrainer(plan=SHORT)
    made = trainer(one, one.scenes(), {"by": "me"}, tmp_path / "one")
    assert one.read_count == len(SHORT) * len(one.scenes())
    assert trainer(again, again.scenes(), {"by": "me"}, tmp_path / "one") == made
    assert again.read_count == 0
    anew = Pictures()
    assert trainer(anew, anew.scenes(), {"by": "me"}, tmp_path / "one", overwrite=True) == made
    assert anew.read_count == one.read_count
    assert trainer(elsewhere, elsewhere.scenes(), {"by": "me"}, tmp_path / "two", jobs=1) == made


def test_stages_come_with_the_figures_of_their_rows(tmp_path: Path) -> None:
    data = Pictures()
    made = StageTrainer(plan=SHORT)(data, data.scenes(), {"by": "me"}, tmp_path)
    assert made.provenance["by"] == "me"
    first, second = made.provenance["stages"]
    assert first["rows"] > second["rows"] > 0
    assert 0 < first["within_share"] < 1
    assert [stage.threshold for stage in made.stages] == [0.7, 0.6]


def test_what_was_learned_parts_the_blocks_it_was_learned_on(tmp_path: Path) -> None:
    data = Pictures()
    made = StageTrainer(plan=SHORT)(data, data.scenes(), {}, tmp_path)
    label = Silberman(made)(picture(STACK).observation).label
    truth = picture(STACK).frame.label
    assert truth is not None

    def iou(block: Tensor) -> float:
        regions = [label == r for r in label[block].unique().tolist() if r > 0]
        return max(float((r & block).sum() / (r | block).sum()) for r in regions)

    assert min(iou(truth == number) for number in (2, 3)) > 0.8


def test_no_stage_follows_where_those_before_it_leave_no_border_within_an_object(tmp_path: Path) -> None:
    # So low a threshold merges all that lies within the blocks, and more.
    plan = (StagePlan(0.01, 6, 4), StagePlan(0.7, 6, 4))
    data = Pictures()
    made = StageTrainer(plan=plan)(data, data.scenes(), {}, tmp_path)
    assert len(made.stages) == 1
    assert len(made.provenance["stages"]) == 1


def test_borders_of_one_kind_teach_nothing() -> None:
    rows = torch.rand(50, len(APPEARANCE_COLUMNS), generator=torch.Generator().manual_seed(0)).double()
    with pytest.raises(ValueError, match="one kind only"):
        boosted(rows, torch.ones(50, dtype=torch.bool), SHORT[0], seed=0)


class Bare(Pictures):
    """The same without labels."""

    def read(self, scene: str) -> tuple[Frame, Truth]:
        return dataclasses.replace(photo(scene), label=None), Truth((1,), (), None, False)


def test_a_scene_without_labels_is_named(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"has no label\.png"):
        StageTrainer(plan=SHORT).rows("stack", Bare(), (), tmp_path)
