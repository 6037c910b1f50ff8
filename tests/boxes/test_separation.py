"""Gaps of boxes: exact contact, worked by hand, moved rigidly, against coal, fcl and a linear program."""

from __future__ import annotations

import math
from itertools import product

import coal
import fcl
import numpy as np
import pytest
import torch
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation
from torch import Tensor

from blockstab.boxes.box import Boxes, concatenate
from blockstab.boxes.separation import Separation, separation
from tests.tolerance import COMPANY, EXACT

UNITS = torch.eye(3, dtype=torch.float64)
SOLVER = 1e-6  # metres: where coal and HiGHS stop iterating, and what an edge axis has to win by


def exact(values: object) -> Tensor:
    return torch.tensor(values, dtype=torch.float64)


def upright(center: tuple[float, float, float], half_extent: tuple[float, float, float]) -> Boxes:
    return Boxes(
        exact([center]),
        UNITS[None],
        exact([half_extent]),
    )


def rotations(vectors: Tensor) -> Tensor:
    return torch.from_numpy(Rotation.from_rotvec(vectors.numpy()).as_matrix())


def random_boxes(size: int, generator: torch.Generator, spread: float = 1.0) -> Boxes:
    return Boxes(
        center=spread * torch.rand(size, 3, dtype=torch.float64, generator=generator),
        rotation=rotations(math.pi * torch.randn(size, 3, dtype=torch.float64, generator=generator)),
        half_extent=0.05 + 0.3 * torch.rand(size, 3, dtype=torch.float64, generator=generator),
    )


def random_pairs(boxes: Boxes, size: int, generator: torch.Generator) -> tuple[Tensor, Tensor]:
    first = torch.randint(0, len(boxes), (size,), generator=generator)
    other = torch.randint(1, len(boxes), (size,), generator=generator)
    return first, (first + other) % len(boxes)


def pair(first: Boxes, second: Boxes) -> Separation:
    """The separation of box i of one batch and box i of another."""
    index = torch.arange(len(first))
    return separation(concatenate([first, second]), index, index + len(first))


def moved(boxes: Boxes, shift: Tensor) -> Boxes:
    return Boxes(boxes.center + shift, boxes.rotation, boxes.half_extent)


def close(found: Tensor, expected: Tensor, tolerance: float = EXACT) -> None:
    torch.testing.assert_close(found, expected, rtol=0.0, atol=tolerance)


@pytest.mark.parametrize("lift", [0.10, 0.0, -0.03])  # clear, touching, sunk in
@pytest.mark.parametrize("angle", [0.0, 0.3, math.pi / 4, math.pi / 2])
def test_gap_of_a_stack_is_its_clearance(lift: float, angle: float) -> None:
    table = upright((0.0, -0.2, 0.5), (0.6, 0.2, 0.5))
    turn = rotations(exact([0.0, angle, 0.0]))
    cup = Boxes(
        exact([[0.3, 0.15 + lift, 0.4]]),
        turn[None],
        exact([[0.05, 0.15, 0.1]]),
    )
    found = pair(table, cup)
    close(found.gap, found.gap.new_tensor([lift]))
    close(found.direction, UNITS[1:2])


def test_convention_gap_is_negative_where_boxes_overlap() -> None:
    cube = upright((0.0, 0.0, 0.0), (0.5, 0.5, 0.5))
    close(pair(cube, upright((0.9, 0.0, 0.0), (0.5, 0.5, 0.5))).gap, exact([-0.1]))
    close(pair(cube, upright((1.1, 0.0, 0.0), (0.5, 0.5, 0.5))).gap, exact([0.1]))


@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0), (0.3, -1.1, 0.7), (0.0, math.pi / 2, 0.0)])
@pytest.mark.parametrize("shift", [0.0, 1e-6, -1e-6])
def test_blocks_that_meet_at_a_face_an_edge_or_a_corner_have_no_gap(
    turn: tuple[float, float, float], shift: float
) -> None:
    half_a, half_b = exact([0.3, 0.1, 0.2]), exact([0.05, 0.15, 0.2])
    sides = exact([s for s in product((-1.0, 0.0, 1.0), repeat=3) if any(s)])
    boxes = Boxes(
        center=torch.cat([torch.zeros(1, 3).double(), sides * (half_a + half_b + shift)]) + 0.7,
        rotation=UNITS.expand(27, 3, 3),
        half_extent=torch.cat([half_a[None], half_b.expand(26, 3)]),
    ).rotated(rotations(exact(turn)))
    found = separation(boxes, torch.zeros(26, dtype=torch.int64), torch.arange(1, 27))
    close(found.gap, torch.full_like(found.gap, shift))
    if shift:
        assert (
            (found.gap < 0) == (coal_distances(boxes, torch.zeros(26).long(), torch.arange(1, 27)) < 0)
        ).all()
    # Every axis along which they touch is as good as any other: the first axis of the first box wins.
    axis = (sides != 0).long().argmax(dim=1)
    expected = boxes.rotation[0].T[axis] * sides.gather(1, axis[:, None])
    close(found.direction, expected)


def test_edge_that_meets_a_crossing_edge_separates_along_neither_face() -> None:
    roof = Boxes(UNITS[:1] * 0, rotations(exact([[math.pi / 4, 0.0, 0.0]])), torch.ones(1, 3).double())
    ridge = rotations(exact([[0.0, 0.0, math.pi / 4]]))
    for gap in (0.2, 0.0, -0.1):
        beam = Boxes(exact([[0.0, 2 * math.sqrt(2) + gap, 0.0]]), ridge, torch.ones(1, 3).double())
        found = pair(roof, beam)
        close(found.gap, found.gap.new_tensor([gap]))
        close(found.direction, UNITS[1:2])


def test_a_box_inside_another_leaves_by_the_nearest_face() -> None:
    room = upright((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    found = pair(room, upright((0.1, -0.5, 0.2), (0.1, 0.1, 0.1)))
    close(found.gap, exact([-0.6]))
    close(found.direction, -UNITS[1:2])


def test_boxes_with_one_centre_separate_along_the_positive_axis() -> None:
    turn = rotations(exact([0.4, 0.2, -0.9]))
    box = upright((0.3, 0.1, 0.2), (0.3, 0.1, 0.2)).rotated(turn)
    found = pair(box, box)
    close(found.gap, exact([-0.2]))
    close(found.direction, turn[:, 1][None])


def test_gap_of_corners_is_that_of_the_slab_not_the_distance() -> None:
    cube = upright((0.0, 0.0, 0.0), (0.5, 0.5, 0.5))
    found = pair(cube, moved(cube, exact([1.1, 1.2, 1.1])))
    close(found.gap, exact([0.2]))
    close(found.direction, UNITS[1:2])


def test_a_rigid_motion_of_the_world_changes_nothing(generator: torch.Generator) -> None:
    boxes = random_boxes(300, generator)
    first, second = random_pairs(boxes, 5000, generator)
    before = separation(boxes, first, second)
    turn = rotations(exact([0.3, -1.0, 2.0]))
    after = separation(moved(boxes.rotated(turn), exact([5.0, -3.0, 1.0])), first, second)
    close(after.gap, before.gap)
    close(after.direction, before.direction @ turn.T)


def test_the_two_boxes_of_a_pair_may_change_places(generator: torch.Generator) -> None:
    boxes = random_boxes(300, generator)
    first, second = random_pairs(boxes, 5000, generator)
    there, back = separation(boxes, first, second), separation(boxes, second, first)
    close(there.gap, back.gap)
    close(there.direction, -back.direction)
    assert (((boxes.center[second] - boxes.center[first]) * there.direction).sum(dim=1) >= 0).all()


def test_moving_along_the_direction_frees_overlapping_boxes(generator: torch.Generator) -> None:
    first, second = random_boxes(3000, generator, 0.4), random_boxes(3000, generator, 0.4)
    gap, direction = pair(first, second)
    depth = -gap[:, None]
    freed = pair(first, moved(second, direction * (depth + EXACT)))
    assert (freed.gap >= 0)[gap < 0].all()
    held = pair(first, moved(second, direction * (depth - SOLVER)))
    assert (held.gap < 0)[gap < -SOLVER].all()


def test_no_shorter_move_frees_overlapping_boxes(generator: torch.Generator) -> None:
    first, second = random_boxes(3000, generator, 0.4), random_boxes(3000, generator, 0.4)
    gap = pair(first, second).gap
    for _ in range(20):
        way = torch.nn.functional.normalize(torch.randn(3000, 3, dtype=torch.float64, generator=generator))
        assert (pair(first, moved(second, way * (-gap - SOLVER)[:, None])).gap < 0)[gap < -SOLVER].all()


def test_noise_in_the_rotation_of_parallel_boxes_does_not_turn_the_direction(
    generator: torch.Generator,
) -> None:
    noise = rotations(1e-7 * torch.randn(2000, 3, dtype=torch.float64, generator=generator))
    plank = upright((0.0, 0.0, 0.0), (0.5, 0.05, 0.1))
    for center, half in (
        ((0.3, 0.15, 0.0), (0.1, 0.1, 0.4)),  # a crossing plank on top
        ((0.0, 0.1, 0.0), (0.5, 0.05, 0.1)),  # the same plank on top
        ((0.45, 0.05, 0.05), (0.1, 0.1, 0.1)),  # sunk in
        ((0.0, 0.02, 0.0), (0.02, 0.01, 0.02)),  # inside
    ):
        other = upright(center, half)
        still = pair(plank, other)
        shaken = pair(
            Boxes(
                plank.center.expand(2000, 3),
                plank.rotation.expand(2000, 3, 3),
                plank.half_extent.expand(2000, 3),
            ),
            Boxes(other.center.expand(2000, 3), noise, other.half_extent.expand(2000, 3)),
        )
        close(shaken.gap, still.gap.expand(2000), 1e-6)
        close(shaken.direction, still.direction.expand(2000, 3), 1e-6)


def test_a_pair_is_the_same_within_1e_9_whatever_others_are_in_the_batch(generator: torch.Generator) -> None:
    boxes = random_boxes(100, generator)
    first, second = random_pairs(boxes, 9000, generator)
    whole = separation(boxes, first, second)
    parts = [separation(boxes, i, j) for i, j in zip(first.chunk(7), second.chunk(7), strict=True)]
    close(whole.gap, torch.cat([part.gap for part in parts]), COMPANY)
    close(whole.direction, torch.cat([part.direction for part in parts]), COMPANY)
    assert separation(boxes, first[:0], second[:0]).direction.shape == (0, 3)


def coal_distances(boxes: Boxes, first: Tensor, second: Tensor) -> Tensor:
    """Euclidean distances of pairs, minus the penetration depth where they overlap."""
    shapes = [coal.Box(*sides) for sides in (2 * boxes.half_extent).tolist()]
    poses = [
        coal.Transform3s(r, c) for r, c in zip(boxes.rotation.numpy(), boxes.center.numpy(), strict=True)
    ]
    request, found = coal.DistanceRequest(), coal.DistanceResult()
    distances = []
    for i, j in zip(first.tolist(), second.tolist(), strict=True):
        found.clear()
        distances.append(coal.distance(shapes[i], poses[i], shapes[j], poses[j], request, found))
    return exact(distances)


def fcl_depths(boxes: Boxes, first: Tensor, second: Tensor) -> Tensor:
    """Penetration depths of pairs, zero where they do not overlap."""
    objects = [
        fcl.CollisionObject(fcl.Box(*sides), fcl.Transform(r, c))
        for sides, r, c in zip(
            (2 * boxes.half_extent).tolist(), boxes.rotation.numpy(), boxes.center.numpy(), strict=True
        )
    ]
    request = fcl.CollisionRequest(enable_contact=True)
    depths = []
    for i, j in zip(first.tolist(), second.tolist(), strict=True):
        found = fcl.CollisionResult()
        fcl.collide(objects[i], objects[j], request, found)
        depths.append(max((contact.penetration_depth for contact in found.contacts), default=0.0))
    return exact(depths)


def test_verdict_depth_and_bound_agree_with_coal(generator: torch.Generator) -> None:
    boxes = random_boxes(2000, generator)
    first, second = random_pairs(boxes, 100_000, generator)
    gap, distance = separation(boxes, first, second).gap, coal_distances(boxes, first, second)
    assert 0.2 < (gap < 0).double().mean().item() < 0.8
    assert ((gap < 0) == (distance < 0))[gap.abs() > SOLVER].all()
    close(gap.clamp(max=0.0), distance.clamp(max=0.0), SOLVER)
    assert (gap <= distance + SOLVER).all()


def test_verdict_and_depth_agree_with_fcl(generator: torch.Generator) -> None:
    boxes = random_boxes(2000, generator)
    first, second = random_pairs(boxes, 100_000, generator)
    gap, depth = separation(boxes, first, second).gap, fcl_depths(boxes, first, second)
    assert ((gap < 0) == (depth > 0))[gap.abs() > SOLVER].all()
    # fcl inherits the box test of ODE, which keeps a face unless an edge pair is better by more than 5 %.
    assert (depth >= -gap - SOLVER).all()
    assert (depth <= (-1.05 * gap + SOLVER).clamp(min=0.0)).all()


def test_verdict_agrees_with_a_linear_program(generator: torch.Generator) -> None:
    first, second = random_boxes(40, generator, 0.7), random_boxes(40, generator, 0.7)
    gap = pair(first, second).gap
    for k in range(40):
        # The largest t for which some point lies t deep in both boxes.
        rows, bounds = [], []
        for box in (first[k : k + 1], second[k : k + 1]):
            normals = box.face_normals()[0].numpy()
            rows.append(np.column_stack([normals, np.ones(6)]))
            bounds.append((normals * box.face_centers()[0].numpy()).sum(axis=1))
        deepest = linprog(
            [0, 0, 0, -1],
            A_ub=np.vstack(rows),
            b_ub=np.concatenate(bounds),
            bounds=(None, None),
            method="highs",
        )
        assert abs(deepest.fun) > SOLVER
        assert (-deepest.fun > 0) == (gap[k].item() < 0)


def test_gap_and_direction_are_differentiable(generator: torch.Generator) -> None:
    boxes = random_boxes(30, generator)
    first, second = random_pairs(boxes, 30, generator)
    fields = [f.clone().requires_grad_() for f in (boxes.center, boxes.rotation, boxes.half_extent)]
    assert torch.autograd.gradcheck(lambda *f: tuple(separation(Boxes(*f), first, second)), fields)


def test_gradient_of_parallel_boxes_in_contact_is_finite() -> None:
    fields = [
        exact([[0.0, 0.0, 0.0], [0.0, 0.2, 0.0]]),
        UNITS.expand(2, 3, 3).clone(),
        exact([[0.1, 0.1, 0.1]] * 2),
    ]
    for field in fields:
        field.requires_grad_()
    found = separation(Boxes(*fields), torch.tensor([0]), torch.tensor([1]))
    (found.gap.sum() + found.direction.sum()).backward()
    assert all(field.grad is not None and field.grad.isfinite().all() for field in fields)
    assert fields[0].grad is not None
    close(fields[0].grad, exact([[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]]))


def test_pairs_of_unequal_length_or_without_a_box_are_refused(generator: torch.Generator) -> None:
    boxes = random_boxes(3, generator)
    with pytest.raises(ValueError, match=r"first has shape \(2,\) and second \(1,\)"):
        separation(boxes, torch.tensor([0, 1]), torch.tensor([2]))
    with pytest.raises(
        ValueError, match=r"two of the 3 boxes, but first\[1\] is -1; leave out pairs with the ground"
    ):
        separation(boxes, torch.tensor([0, -1]), torch.tensor([2, 2]))
    with pytest.raises(ValueError, match=r"second\[0\] is 3"):
        separation(boxes, torch.tensor([0, 1]), torch.tensor([3, 2]))
