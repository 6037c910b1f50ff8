"""What the box of an object does not explain becomes an object of its own."""

from __future__ import annotations

from functools import cache

import pytest
import torch

from blockstab.energy import Rating
from blockstab.rgbd.noise import KINECT
from blockstab.search.moves.unexplained import Unexplained
from blockstab.search.problem import MIN_SEGMENT_PX, Problem
from blockstab.testing.photographs import photograph
from blockstab.testing.worlds import Block
from tests.search.watched import seeded, watched
from tests.synthetic import view_of

LOW, HIGH = Block(0, 0, 0.06, 0.08, z=0.12, d=0.06), Block(0, 0, 0.26, 0.2, d=0.1)
TOWER = (Block(0, 0, 0.2, 0.08, d=0.16), Block(0, 0.08, 0.1, 0.1, d=0.08))
PAIRS = {"before": (LOW, HIGH), "wide": (Block(0, 0, 0.14, 0.06, z=0.1, d=0.08), HIGH), "tower": TOWER}
two_blocks = pytest.mark.parametrize("name", PAIRS)
ALL = 10**6  # more than there are


@cache
def taken_for_one(name: str, turn_deg: float = 25.0) -> tuple[Problem, Rating]:
    """Two blocks that the segmentation takes for one object."""
    problem = watched(view_of(photograph(*PAIRS[name], turn_deg=turn_deg))).problem
    merged = problem.search_input.start.merge(1, 2)
    return problem, problem.rate([merged])[0]


@pytest.mark.parametrize("turn_deg", [0.0, 25.0, -25.0])
@two_blocks
def test_a_box_that_stands_before_or_on_another_is_separated_from_it(name, turn_deg):
    problem, rating = taken_for_one(name, turn_deg)
    results = Unexplained()(rating, problem, ALL, seeded(0))
    assert problem.search_input.start.segments in {result.segments for result in results}


@two_blocks
def test_of_one_block_alone_nothing_is_split_off(name):
    problem, _ = taken_for_one(name)
    (truth,) = problem.rate([problem.search_input.start])
    assert Unexplained()(truth, problem, ALL, seeded(0)) == []


@two_blocks
def test_what_lies_off_the_faces_is_one_of_the_parts(name):
    problem, rating = taken_for_one(name)
    whole, box = rating.scene.segmentation.segments[1], rating.scene.boxes[torch.tensor([1])]
    cloud, label = problem.search_input.observation.cloud, problem.search_input.atoms.label
    off = set()
    for atom in whole:
        points = cloud.points[(label == atom + 1) & cloud.valid]
        inward = box.half_extent[0] - ((points - box.center[0]) @ box.rotation[0]).abs()
        far = inward.amin(dim=1).abs().mean()
        step = (KINECT.step * points.square().sum(dim=1)).mean()
        off |= {atom} if float(far) > max(3 * float(step), 0.01) else set()
    assert off
    results = Unexplained()(rating, problem, ALL, seeded(0))
    assert any(frozenset(off) in result.segments for result in results)


@pytest.mark.parametrize("move", [Unexplained(steps=10**4), Unexplained(least_m=1.0)])
def test_how_far_off_a_part_must_lie_is_a_setting(move):
    problem, rating = taken_for_one("before")
    assert move(rating, problem, ALL, seeded(0)) == []


@two_blocks
def test_neither_part_is_smaller_than_a_segment_may_be(name):
    problem, rating = taken_for_one(name)
    for least_m in (0.0005, 0.001, 0.003, 0.02):
        for result in Unexplained(steps=0.0, least_m=least_m)(rating, problem, ALL, seeded(0)):
            assert min(map(problem.pixel_count, result.segments)) >= MIN_SEGMENT_PX
