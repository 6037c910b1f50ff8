"""The expected overlap: by hand, what it prefers, and the gradient that it carries."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import pytest
import torch

from blockstab.energy.overlap import ExpectedOverlap, TwoJudges, expected_loss, parts_of
from blockstab.energy.truth import true_overlap
from blockstab.features.columns import LONE_COLUMNS, SEGMENT_COLUMNS
from blockstab.observation import estimated_ground, observe
from blockstab.proposals.search_input import SearchInput, make_search_input
from blockstab.proposals.watershed import Watershed
from blockstab.rgbd.frame import read_scene
from blockstab.scene.inference import Rules
from blockstab.search import rank
from blockstab.search.moves.every import EVERY
from blockstab.search.problem import problem_of
from blockstab.search.truth import true_segmentation
from blockstab.testing.photographs import BLOCKS, photograph
from blockstab.testing.worlds import Block
from models.potentials.examples import Neutral
from models.potentials.heads import LinearHead, initialised
from models.potentials.perturbing import walks
from tests.box_scene import scene_of
from tests.energy.described import described, first_column
from tests.synthetic import view_of
from tests.tolerance import COMPANY, EXACT

ENERGY = ExpectedOverlap(first_column, first_column, weight=0.5)
TABLE = Block(0, -0.1, 4.0, 0.1, d=4.0, fixed=True)
ROW = (Block(0, 0, 0.1, 0.1), Block(0.3, 0, 0.1, 0.1), Block(0.9, 0, 0.1, 0.1))


def test_energy_is_the_share_of_pixels_lost_and_what_wrong_boundaries_add():
    scene = scene_of(TABLE, *ROW, pixels=[1000, 300, 200, 100])
    (rating,) = ENERGY([described(scene, [0.9, 0.1, 0.2, 0.4], [0.5, 0.25, 0.0], [0.01, 0.0, 0.0, 0.0])])
    lost = 1000 * 0.01 + 300 * 0.1 + 200 * 0.2 + 100 * 0.4
    between = 0.5 * (200 * 0.5 + 100 * 0.25)
    assert float(rating.energy) == pytest.approx((lost + between) / 1600, abs=EXACT)


def test_energy_does_not_depend_on_how_many_pieces_the_wrong_part_lies_in():
    energy = ExpectedOverlap(first_column, first_column)
    apart = described(scene_of(*ROW, pixels=[300, 120, 80]), [0.0, 1.0, 1.0])
    merged = described(scene_of(*ROW[:2], pixels=[300, 200]), [0.0, 1.0])
    one, other = energy([apart, merged])
    assert float(one.energy) == pytest.approx(float(other.energy), abs=EXACT)


def test_a_price_is_added():
    scene = scene_of(*ROW, pixels=[300, 120, 80])
    one = described(scene, [0.2, 0.3, 0.4])
    asked = []
    (free,), (dear,) = (
        ExpectedOverlap(first_column, first_column, price=price)([one])
        for price in (lambda _: 0.0, lambda scene: asked.append(scene) or 0.25)
    )
    assert asked == [scene]
    assert float(dear.energy - free.energy) == pytest.approx(0.25, abs=EXACT)


def test_two_judges_are_the_mean_of_what_they_say_of_a_segment():
    rows = torch.rand(5, len(SEGMENT_COLUMNS), generator=torch.Generator().manual_seed(0)).double()
    both = SimpleNamespace(unary=lambda x: 4 * x[:, 0] - 1, alone=lambda x: x[:, -1])
    assert LONE_COLUMNS[-1] == SEGMENT_COLUMNS[-1]
    expected = ((4 * rows[:, 0] - 1).clamp(0, 1) + rows[:, -1]) / 2
    torch.testing.assert_close(TwoJudges(both)(rows), expected, rtol=0, atol=EXACT)


def test_the_rating_of_a_scene_is_the_same_within_1e_9_whatever_scenes_are_rated_with_it():
    head = initialised(LinearHead, 92, 3).double()
    energy = ExpectedOverlap(lambda rows: head(rows[:, :92]), first_column, 0.3)
    scenes = [described(scene_of(*ROW[:n]), [0.1 * n] * n) for n in (1, 2, 3)] * 9
    for together, scene in zip(energy(scenes), scenes, strict=True):
        (alone,) = energy([scene])
        assert float(alone.energy) == pytest.approx(float(together.energy), abs=COMPANY)


def test_a_gradient_reaches_the_potentials_and_the_weight_of_boundaries():
    parts = parts_of(described(scene_of(TABLE, *ROW), [0.0] * 4))
    phi = torch.tensor([0.4, 0.1, 0.2, 0.7], dtype=torch.float64, requires_grad=True)
    psi = torch.tensor([0.3, 0.6, 0.2], dtype=torch.float64, requires_grad=True)
    weight = torch.tensor(0.2, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(lambda *given: expected_loss(parts, *given), (phi, psi, weight))
    expected_loss(parts, phi, psi, weight).backward()
    assert phi.grad is not None
    assert float(phi.grad[0]) == 0.0  # background has no say


def perturbations_of_the_truth(search_input: SearchInput, count: int) -> tuple[float, list[float]]:
    """The energy of the truth drawn on atoms, with the true overlap as potential, and those on walks away from it."""
    problem = problem_of(search_input, Rules(), Neutral(), true_overlap)
    (truth,) = problem.rate([true_segmentation(problem)])
    generator = torch.Generator().manual_seed(1)
    visited = walks([truth] * count, problem, EVERY, 6, generator)
    # A walk may come back to where it started.
    start = set(truth.scene.segmentation.segments)
    return rank(truth), [rank(r) for r in visited if set(r.scene.segmentation.segments) != start]


@pytest.mark.parametrize("turn_deg", [0.0, 25.0])
def test_with_the_true_overlap_as_potential_the_truth_is_best_of_its_perturbations(turn_deg):
    truth, others = perturbations_of_the_truth(view_of(photograph(*BLOCKS, turn_deg=turn_deg)), 6)
    assert len(others) > 15
    assert all(truth < energy for energy in others)


@pytest.mark.parametrize("name", ["learn00", "learn20"])
def test_the_truth_is_best_of_its_perturbations_in_photographs(real_scenes: Path, name):
    frame = read_scene(real_scenes / "osd" / name)
    search_input = make_search_input(observe(frame, estimated_ground), Watershed())
    truth, others = perturbations_of_the_truth(search_input, 3)
    assert all(truth <= energy for energy in others)


def test_convention_lower_energy_is_better():
    good, bad = ENERGY([described(scene_of(*ROW), [x] * 3, [x] * 3) for x in (0.1, 0.6)])
    assert rank(good) < rank(bad)
