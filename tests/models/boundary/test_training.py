"""Learned weights of the cues of an edge: where they learn, which way edges run, and what a file keeps."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest
import torch
from torch import Tensor

from blockstab.boundaries.cues import CUES, cues_of
from blockstab.boundaries.edge_models import LogisticWeights
from blockstab.datasets.truth import Truth
from blockstab.evaluation.metrics.borders import borders
from blockstab.rgbd.frame import Frame
from models.boundary.training import (
    boundary_rows,
    load_boundary,
    orientations,
    save_boundary,
    train_boundary,
    without_holes,
)
from models.potentials.record import CheckpointError
from tests.block_scene import APART, STACK, picture

FRAMES = {"apart": picture(APART).frame, "stack": picture(STACK).frame}
WEIGHTS = LogisticWeights(tuple(0.5 * k for k in range(len(CUES))), -3.0)


class Pictures:
    """A set of two made-up pictures."""

    name = "pictures"

    def scenes(self) -> list[str]:
        return list(FRAMES)

    def read(self, scene: str) -> tuple[Frame, Truth]:
        return FRAMES[scene], Truth((1,), (), None, False)

    def stamp(self, scene: str) -> str:
        return scene

    def official(self) -> Mapping[str, Sequence[str]]:
        return {}


@pytest.mark.parametrize("channel", range(4))
def test_the_orientation_of_a_straight_border_is_the_one_it_runs_along(channel: int) -> None:
    row, column = torch.meshgrid(torch.arange(40.0), torch.arange(40.0), indexing="ij")
    angle = torch.tensor(math.pi / 4 * channel)
    # Counter-clockwise as one sees it, while rows count downwards.
    side = (column - 20) * angle.sin() + (row - 20) * angle.cos() > 0.1
    label = side.long() + 1
    seen = orientations(label)[borders(label)]
    assert float((seen == channel).double().mean()) > 0.9


def test_holes_take_the_label_beside_them_and_an_empty_image_stays() -> None:
    label = torch.tensor([[1, 0, 0, 0, 2]])
    filled = without_holes(label)
    assert filled[0, [0, 1, 3, 4]].tolist() == [1, 1, 2, 2]
    assert torch.equal(
        without_holes(torch.zeros(3, 4, dtype=torch.int64)), torch.zeros(3, 4, dtype=torch.int64)
    )


def test_rows_are_cues_of_true_boundaries_and_of_places_far_from_any(tmp_path: Path) -> None:
    features, target = boundary_rows("stack", Pictures(), 0, tmp_path)
    assert features.shape == (len(target), len(CUES))
    assert 0.005 < float(target.double().mean()) < 0.3
    geometry = features[:, [CUES.index("depth"), CUES.index("concave")]].amax(dim=1)
    assert float(geometry[target].mean()) > 5 * float(geometry[~target].mean())


def test_learned_weights_part_boundaries_from_print(tmp_path: Path) -> None:
    data = Pictures()
    weights, facts = train_boundary(data, data.scenes(), {"by": "me"}, tmp_path)
    assert facts["by"] == "me"
    assert facts["roc_area"] > 0.95
    frame = FRAMES["stack"]
    assert frame.label is not None
    strength = weights(cues_of(frame)).strength
    edge = borders(without_holes(frame.label)) & (frame.depth > 0)
    inside = (frame.label > 1) & ~_near(edge, 6)
    assert float(strength[edge].mean()) > 0.5 > float(strength[inside].quantile(0.95))


def _near(mask: Tensor, reach_px: int) -> Tensor:
    size = 2 * reach_px + 1
    return torch.nn.functional.max_pool2d(mask.double()[None], size, stride=1, padding=reach_px)[0] > 0


def test_training_twice_gives_the_same_weights(tmp_path: Path) -> None:
    data = Pictures()
    one, _ = train_boundary(data, data.scenes(), {}, tmp_path / "one")
    assert train_boundary(data, data.scenes(), {}, tmp_path / "two")[0] == one


class Bare(Pictures):
    """The same without labels."""

    def read(self, scene: str) -> tuple[Frame, Truth]:
        return dataclasses.replace(FRAMES[scene], label=None), Truth((1,), (), None, False)


def test_a_scene_without_labels_is_named(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"has no label\.png"):
        boundary_rows("stack", Bare(), 0, tmp_path)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    save_boundary(tmp_path / "mine.json", WEIGHTS, {"images": 2})
    return tmp_path / "mine.json"


def test_what_was_saved_comes_back(file: Path) -> None:
    assert load_boundary(file) == WEIGHTS


def test_weights_that_come_with_the_package_are_found_by_name() -> None:
    shipped = dict(zip(CUES, load_boundary("boundary").weights, strict=True))
    # A jump of depth speaks for a boundary; a convex crease, where the faces of one box meet, against it.
    assert shipped["depth"] > 0 > shipped["convex"]


def _set(key: str, value: object) -> Callable[[dict[str, Any]], Any]:
    return lambda record: record.update({key: value})


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (_set("format", 7), "format 1"),
        (_set("weights", {"depth": 1.0}), "must have weights for"),
        (_set("weights", [1.0] * 8), "must have weights for"),
        (_set("bias", None), "bias|float"),
        (_set("bias", float("inf")), "finite"),
        (_set("bias", 10**400), "too large"),
        (lambda record: record.pop("bias"), "bias"),
    ],
)
def test_a_spoilt_file_is_refused_in_one_line(file: Path, spoil: Callable[[Any], Any], said: str) -> None:
    record = json.loads(file.read_text())
    spoil(record)
    file.write_text(json.dumps(record))
    with pytest.raises(CheckpointError, match=said) as caught:
        load_boundary(file)
    assert file.name in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["", "[]", "{", "[" * 100_000])
def test_what_is_no_record_is_refused_in_one_line(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(CheckpointError, match=r"a\.json holds no boundary"):
        load_boundary(tmp_path / "a.json")


def test_a_missing_file_is_named_with_what_to_do(tmp_path: Path) -> None:
    with pytest.raises(CheckpointError, match=r"b\.json is not there; train it with"):
        load_boundary(tmp_path / "b.json")
