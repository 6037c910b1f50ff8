"""With the true overlap as potential, the energy ranks the truth first, always."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from blockstab.energy import Rating
from blockstab.energy.truth import true_overlap
from blockstab.observation import estimated_ground, observe
from blockstab.proposals.files import LabelFile
from blockstab.proposals.search_input import make_search_input
from blockstab.rgbd.frame import read_scene
from blockstab.search import rank
from blockstab.search.moves.every import EVERY
from blockstab.search.problem import Problem
from blockstab.testing.photographs import BLOCKS, photograph
from blockstab.testing.worlds import Block
from models.potentials.perturbing import walks
from tests.search.watched import blocks_view, seeded, watched
from tests.synthetic import over_split, view_of

SCENES = {
    "blocks": BLOCKS,
    "tower": (Block(0, 0, 0.2, 0.08, d=0.16), Block(0, 0.08, 0.1, 0.1, d=0.08)),
    "one before another": (Block(0, 0, 0.06, 0.08, z=0.12, d=0.06), Block(0, 0, 0.26, 0.2, d=0.1)),
}
every_scene = pytest.mark.parametrize("name", SCENES)
MANY = 30  # of each kind of move


@cache
def problem(name: str) -> Problem:
    """A scene whose first segmentation is the truth."""
    return watched(view_of(photograph(*SCENES[name], name=name)), true_overlap).problem


def tried(problem: Problem, truth: Rating, seed: int) -> list[Rating]:
    """What all moves make of the truth, and what lies on a random walk from it."""
    moved = [one for move in EVERY for one in move(truth, problem, MANY, seeded(seed))]
    return [*problem.rate(list(dict.fromkeys(moved))), *walks([truth], problem, EVERY, 6, seeded(seed))]


def assert_truth_is_first(problem: Problem, seeds: range) -> None:
    (truth,) = problem.rate([problem.search_input.start])
    told = truth.scene.segmentation.background
    for seed in seeds:
        others = tried(problem, truth, seed)
        assert len(others) > 10
        for other in others:
            same = other.scene.segmentation.segments == truth.scene.segmentation.segments
            assert rank(other) > rank(truth) or (same and other.scene.segmentation.background == told)


@every_scene
def test_whatever_moves_make_of_the_truth_is_worse(name):
    assert_truth_is_first(problem(name), range(4))


@pytest.mark.parametrize("name", ["learn00", "learn07"])
def test_whatever_moves_make_of_the_truth_of_a_real_scene_is_worse(name, real_scenes: Path):
    observation = observe(read_scene(real_scenes / "osd" / name), estimated_ground)
    assert_truth_is_first(
        watched(make_search_input(observation, LabelFile()), true_overlap).problem, range(1)
    )


@every_scene
def test_the_energy_is_the_share_of_pixels_that_the_segmentation_loses(name):
    (truth,) = problem(name).rate([problem(name).search_input.start])
    assert float(truth.energy) == 0.0
    assert truth.unary[1:].tolist() == [0.0] * (len(truth.scene) - 1)
    merged = problem(name).search_input.start.merge(1, 2)
    (rating,) = problem(name).rate([merged])
    a, b = sorted(problem(name).pixel_count(s) for s in problem(name).search_input.start.segments[1:3])
    total = sum(problem(name).pixel_count(s) for s in merged.segments)
    assert float(rating.energy) == pytest.approx((a + b) * (1 - b / (a + b)) / total)


def test_things_in_background_are_lost_and_a_table_as_an_object_is_lost_whole():
    start, table = blocks_view().start, blocks_view().start.segments[0]
    rate = watched(blocks_view(), true_overlap).problem
    block = start.segments[2]
    total = sum(map(rate.pixel_count, start.segments))
    hidden, shown = rate.rate([start.telling({block: True}), start.telling({table: False})])
    assert float(hidden.energy) == pytest.approx(rate.pixel_count(block) / total)
    assert float(shown.energy) == pytest.approx(rate.pixel_count(table) / total)


def test_the_more_pieces_an_object_is_cut_into_the_worse():
    rate = watched(blocks_view(), true_overlap).problem.rate
    energies = [rank(rating) for rating in rate([over_split(blocks_view(), rounds) for rounds in range(3)])]
    assert energies == sorted(set(energies))


def test_potentials_are_not_asked():
    search_input = blocks_view()
    ratings = true_overlap(None, search_input)(
        watched(search_input).problem.describe(watched(search_input).problem.build([search_input.start]))
    )
    assert float(ratings[0].energy) == 0.0


def test_an_image_without_labels_is_refused():
    search_input = blocks_view()
    frame = replace(search_input.observation.frame, label=None)
    with pytest.raises(ValueError, match=r"blocks has no label\.png; the true overlap needs one"):
        true_overlap(None, replace(search_input, observation=replace(search_input.observation, frame=frame)))
