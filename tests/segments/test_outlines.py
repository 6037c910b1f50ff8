"""Borders of sets of atoms, against a trace of images in which there are just the two and one region around them."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor

from blockstab.segments.atoms import Atoms, make_atoms
from blockstab.segments.edgelets import Edgelets, trace_edgelets
from blockstab.segments.outlines import Outlines
from tests.tolerance import EXACT

Traced = dict[tuple[tuple[int, ...], ...], tuple[float, ...]]


def mosaic(generator: torch.Generator, unlabelled: bool) -> Atoms:
    """Tiles of 2 x 3 pixels, some of which only touch at a corner, and one enclosed by an atom, or by no label."""
    coarse = torch.randint(20, (9, 10), generator=generator)
    coarse[2:6, 3:8], coarse[4, 5] = 0, 1
    label = torch.unique(coarse, return_inverse=True)[1] + (0 if unlabelled else 1)
    label = label.repeat_interleave(2, 0).repeat_interleave(3, 1)
    return make_atoms(label, torch.zeros(label.shape, dtype=torch.float64))


def halves(atoms: Atoms, pairs: int, generator: torch.Generator) -> tuple[Tensor, Tensor]:
    """(P, A + 1) bool, twice: which atoms either of two sets has; each at least one."""
    side = torch.randint(3, (pairs, len(atoms) + 1), generator=generator)
    side[:, 0], side[:, 1], side[:, -1] = 1, 2, 0
    return side == 1, side == 2


def traced(edgelets: Edgelets, region: int) -> Traced:
    """By its cracks, the numbers of each edgelet between a region and the next."""
    found = {}
    for e in ((edgelets.first == region) & (edgelets.second == region + 1)).nonzero()[:, 0].tolist():
        cracks = edgelets.cracks[edgelets.edgelet == e].flatten(1)
        numbers = [edgelets.ends[e].flatten(), edgelets.tangents[e].flatten(), edgelets.continuity[e]]
        course = torch.cat([edgelets.length[e, None], edgelets.angle[e, None], *numbers])
        found[tuple(tuple(crack) for crack in cracks.tolist())] = tuple(course.tolist())
    return found


def alone(atoms: Atoms, first: Tensor, second: Tensor) -> Tensor:
    """(H, W) labels: 1 and 2 for the sets, 3 for all else."""
    kind = torch.where(first, 1, torch.where(second, 2, 3))
    return torch.cat([kind[-1:], kind[:-1]])[atoms.label]


@pytest.mark.parametrize("unlabelled", [False, True])
@pytest.mark.parametrize("seed", range(5))
def test_edgelets_are_those_of_an_image_in_which_all_else_is_one_region(seed, unlabelled):
    generator = torch.Generator().manual_seed(seed)
    atoms = mosaic(generator, unlabelled)
    first, second = halves(atoms, 12, generator)
    edgelets = Outlines(atoms).edgelets(first, second)
    assert set((edgelets.second - edgelets.first).tolist()) == {1}
    for pair in range(12):
        expected = traced(trace_edgelets(alone(atoms, first[pair], second[pair])), 0)
        found = traced(edgelets, 2 * pair)
        assert found.keys() == expected.keys()
        for cracks, numbers in found.items():
            assert numbers == pytest.approx(expected[cracks], abs=EXACT)


@pytest.mark.parametrize("unlabelled", [False, True])
def test_a_perimeter_is_as_long_as_the_borders_with_all_other_atoms(unlabelled, generator):
    atoms = mosaic(generator, unlabelled)
    inside, _ = halves(atoms, 9, generator)
    found = Outlines(atoms).perimeter(inside)
    for number, chosen in zip(found.tolist(), inside, strict=True):
        kind = torch.cat([torch.zeros(1, dtype=torch.int64), 1 + chosen[:-1].to(torch.int64)])[atoms.label]
        sides = [(kind[1:], kind[:-1]), (kind[:, 1:], kind[:, :-1])]
        assert number == sum(int(((a != b) & (a > 0) & (b > 0)).sum()) for a, b in sides)


def test_sets_without_a_border_have_no_edgelet():
    label = torch.tensor([1, 2, 3]).repeat_interleave(4).expand(5, 12).contiguous()
    atoms = make_atoms(label, torch.zeros(label.shape, dtype=torch.float64))
    one, other = torch.tensor([[True, False, False, False]]), torch.tensor([[False, False, True, False]])
    assert len(Outlines(atoms).edgelets(one, other)) == 0


def test_a_border_does_not_go_on_beyond_the_image():
    label = torch.tensor([1, 2]).repeat_interleave(4).expand(5, 8).contiguous()
    atoms = make_atoms(label, torch.zeros(label.shape, dtype=torch.float64))
    one, other = torch.tensor([[True, False, False]]), torch.tensor([[False, True, False]])
    edgelets = Outlines(atoms).edgelets(one, other)
    assert edgelets.length.tolist() == [5.0]
    assert edgelets.continuity.tolist() == [[0.0, 0.0]]
