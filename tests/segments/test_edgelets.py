"""Edgelets, against borders worked out by hand and against a tracer that walks one crack at a time."""

from __future__ import annotations

import math
from collections import Counter

import pytest
import torch
from torch import Tensor

from blockstab.segments.edgelets import Edgelets, continuity, trace_edgelets
from tests.tolerance import COMPANY, EXACT

Crack = frozenset[tuple[int, int]]


def tee() -> Tensor:
    """Region 1 to the left, 2 and 3 to the right of it."""
    label = torch.ones(40, 60, dtype=torch.int64)
    label[:20, 30:], label[20:, 30:] = 2, 3
    return label


def walked(label: Tensor) -> set[tuple[int, int, frozenset[Crack]]]:
    """Every edgelet as its regions and the set of its cracks: grown from one crack over corners where two meet."""
    height, width = label.shape
    corners: dict[Crack, list[tuple[int, int]]] = {}
    for r in range(height):
        for c in range(width):
            if c + 1 < width and label[r, c] != label[r, c + 1]:
                corners[frozenset({(r, c), (r, c + 1)})] = [(r, c + 1), (r + 1, c + 1)]
            if r + 1 < height and label[r, c] != label[r + 1, c]:
                corners[frozenset({(r, c), (r + 1, c)})] = [(r + 1, c), (r + 1, c + 1)]
    degree = Counter(corner for pair in corners.values() for corner in pair)
    at: dict[tuple[int, int], list[Crack]] = {}
    for crack, pair in corners.items():
        for corner in pair:
            at.setdefault(corner, []).append(crack)
    found = set()
    for crack in corners:
        first, second = sorted(int(label[pixel]) for pixel in crack)
        grown, queue = {crack}, [crack]
        while queue:
            for corner in corners[queue.pop()]:
                more = [other for other in at[corner] if degree[corner] == 2 and other not in grown]
                grown.update(more)
                queue.extend(more)
        if first > 0:
            found.add((first - 1, second - 1, frozenset(grown)))
    return found


def cracks_of_each(edgelets: Edgelets) -> list[list[Crack]]:
    cracks = [frozenset({tuple(one), tuple(other)}) for one, other in edgelets.cracks.tolist()]
    return [[cracks[k] for k in (edgelets.edgelet == e).nonzero()[:, 0]] for e in range(len(edgelets))]


@pytest.mark.parametrize("unlabelled", [0, 1])
@pytest.mark.parametrize("seed", range(8))
def test_edgelets_are_those_of_a_tracer_that_walks(seed: int, unlabelled: int) -> None:
    generator = torch.Generator().manual_seed(seed)
    coarse = torch.randint(1 - unlabelled, 4, (7, 8), generator=generator)
    label = coarse.repeat_interleave(2, 0).repeat_interleave(3, 1)
    edgelets = trace_edgelets(label)
    regions = zip(edgelets.first.tolist(), edgelets.second.tolist(), strict=True)
    found = [(*pair, frozenset(own)) for pair, own in zip(regions, cracks_of_each(edgelets), strict=True)]
    assert len(found) == len(set(found))
    assert set(found) == walked(label)


def test_cracks_follow_one_another_from_start_to_end(generator: torch.Generator) -> None:
    label = torch.randint(1, 4, (9, 9), generator=generator).repeat_interleave(2, 0)
    edgelets = trace_edgelets(label)
    middle = edgelets.cracks.double().mean(dim=1) + 0.5
    for e in range(len(edgelets)):
        along = middle[edgelets.edgelet == e]
        assert len(along) == edgelets.length[e]
        assert float((along[0] - edgelets.ends[e, 0]).norm()) == 0.5
        assert float((along[-1] - edgelets.ends[e, 1]).norm()) == 0.5
        assert bool(((along[1:] - along[:-1]).norm(dim=1) <= 1.0).all())


def test_the_first_pixel_of_a_crack_is_of_the_first_region(generator: torch.Generator) -> None:
    label = torch.randint(1, 6, (20, 20), generator=generator)
    edgelets = trace_edgelets(label)
    sides = label[edgelets.cracks[..., 0], edgelets.cracks[..., 1]] - 1
    assert torch.equal(sides[:, 0], edgelets.first[edgelets.edgelet])
    assert torch.equal(sides[:, 1], edgelets.second[edgelets.edgelet])
    assert bool((edgelets.first < edgelets.second).all())


def test_three_edgelets_meet_where_three_regions_do() -> None:
    edgelets = trace_edgelets(tee())
    assert edgelets.first.tolist() == [0, 0, 1]
    assert edgelets.second.tolist() == [1, 2, 2]
    assert edgelets.length.tolist() == [20, 20, 30]
    assert edgelets.angle.tolist() == [90, 90, 0]


def test_an_edgelet_that_runs_on_straight_turns_by_nothing() -> None:
    edgelets = trace_edgelets(tee())
    at_junction = (edgelets.ends == torch.tensor([20.0, 30.0])).all(dim=-1)
    assert at_junction.sum(dim=1).tolist() == [1, 1, 1]
    assert edgelets.continuity[at_junction].tolist() == pytest.approx([0.0, 0.0, 90.0], abs=EXACT)
    assert (
        float(edgelets.continuity[~at_junction].abs().max()) == 0.0
    )  # the image's border, where nothing meets


@pytest.mark.parametrize("turn", [0.0, 30.0, 135.0, 180.0])
def test_turns_are_measured_to_either_side_alike(turn: float) -> None:
    tips = torch.tensor([[0, 1], [0, 2]])
    for side in (-1, 1):
        angle = math.radians(180.0 + side * turn)
        into = [[[0.0, 1.0], [0.0, -1.0]], [[math.sin(angle), math.cos(angle)], [0.0, 1.0]]]
        turns = continuity(tips, torch.tensor(into, dtype=torch.float64))
        assert turns.flatten().tolist() == pytest.approx([turn, 0.0, turn, 0.0], abs=EXACT)


def test_a_turn_is_the_same_within_1e_9_in_whatever_company(generator: torch.Generator) -> None:
    tips = torch.tensor([[0, 1], [0, 2], [0, 3]])
    tangents = torch.randn(200, 3, 2, 2, dtype=torch.float64, generator=generator)
    apart = tips + 4 * torch.arange(200)[:, None, None]
    together = continuity(apart.flatten(0, 1), tangents.flatten(0, 1)).view(200, 3, 2)
    for found, own in zip(together, tangents, strict=True):
        torch.testing.assert_close(continuity(tips, own), found, rtol=COMPANY, atol=COMPANY)


def test_a_closed_edgelet_has_length_but_no_continuity() -> None:
    label = torch.ones(10, 10, dtype=torch.int64)
    label[3:6, 4:8] = 2
    edgelets = trace_edgelets(label)
    assert edgelets.length.tolist() == [14]
    assert torch.equal(edgelets.ends[:, 0], edgelets.ends[:, 1])
    assert edgelets.continuity.tolist() == [[0.0, 0.0]]
    assert edgelets.tangents.norm(dim=-1).tolist() == [[1.0, 1.0]]


def test_a_single_pixel_has_tangents_of_unit_length() -> None:
    label = torch.ones(3, 3, dtype=torch.int64)
    label[1, 1] = 2
    assert trace_edgelets(label).tangents.norm(dim=-1).flatten().tolist() == pytest.approx([1.0, 1.0])


def test_edgelets_end_where_two_regions_meet_like_squares_of_a_chessboard() -> None:
    label = torch.tensor([[1, 2], [2, 1]]).repeat_interleave(5, 0).repeat_interleave(5, 1)
    edgelets = trace_edgelets(label)
    assert edgelets.length.tolist() == [5, 5, 5, 5]
    assert edgelets.continuity.amax(dim=1).tolist() == pytest.approx([0.0] * 4, abs=EXACT)


def test_edgelets_end_at_pixels_without_label() -> None:
    label = torch.ones(10, 20, dtype=torch.int64)
    label[5:] = 2
    label[4:6, 8:12] = 0
    assert trace_edgelets(label).length.tolist() == [8, 8]


@pytest.mark.parametrize(("rising", "angle"), [(True, 45.0), (False, 135.0)])
def test_angles_turn_counter_clockwise_as_one_sees_the_image(rising: bool, angle: float) -> None:
    row, column = torch.meshgrid(torch.arange(30), torch.arange(30), indexing="ij")
    below = row + column >= 30 if rising else row > column
    edgelets = trace_edgelets(1 + below.to(torch.int64))
    assert edgelets.angle.tolist() == pytest.approx([angle], abs=3.0)


def test_tangents_see_ten_cracks_and_no_more() -> None:
    label = torch.ones(50, 50, dtype=torch.int64)
    label[:25, 30:] = 2  # from the top straight down, then to the right
    edgelets = trace_edgelets(label)
    tangents = {tuple(edgelets.ends[0, k].tolist()): edgelets.tangents[0, k].tolist() for k in range(2)}
    assert tangents == {(0.0, 30.0): [1.0, 0.0], (25.0, 50.0): [0.0, -1.0]}


@pytest.mark.parametrize("label", [torch.zeros(6, 7), torch.ones(6, 7), torch.zeros(0, 7)])
def test_without_two_regions_there_is_no_edgelet(label: Tensor) -> None:
    assert len(trace_edgelets(label.to(torch.int64))) == 0


def test_labels_that_are_no_image_are_refused() -> None:
    with pytest.raises(ValueError, match=r"must be an image.*\(5,\)"):
        trace_edgelets(torch.ones(5, dtype=torch.int64))
