"""The merge order of atoms, and the two parts that a segment falls into."""

from __future__ import annotations

from copy import deepcopy

import pytest
import torch
from skimage.measure import label as components
from torch import Tensor

from blockstab.segments.atoms import Atoms, make_atoms, over_segment
from blockstab.segments.hierarchy import build_hierarchy, joined_at, split, ultrametric_map
from tests.tolerance import EXACT

SIDE = 4


def row(*strengths: float) -> Atoms:
    """Atoms in a row; border k between atoms k and k + 1 has the k-th strength."""
    columns = torch.arange(1, len(strengths) + 2).repeat_interleave(SIDE)
    atoms = make_atoms(
        columns.expand(SIDE, -1).contiguous(), torch.zeros(SIDE, len(columns), dtype=torch.float64)
    )
    return Atoms(
        atoms.label,
        atoms.pixel_count,
        atoms.first,
        atoms.second,
        atoms.border_px,
        torch.tensor(strengths, dtype=torch.float64),
    )


def mosaic(generator: torch.Generator, side: int = 8) -> Atoms:
    """Squares with random borders."""
    numbers = 1 + torch.arange(side * side).view(side, side)
    label = numbers.repeat_interleave(SIDE, dim=0).repeat_interleave(SIDE, dim=1)
    return make_atoms(label, torch.rand(label.shape, dtype=torch.float64, generator=generator))


def ragged(generator: torch.Generator) -> Atoms:
    """Atoms of all shapes, with holes and islands between them."""
    valid = torch.rand(40, 50, generator=generator) > 0.05
    valid[10:30, 22:30] = False
    valid[:, 34:46] = False
    strength = torch.rand(40, 50, dtype=torch.float64, generator=generator)
    return make_atoms(over_segment(strength, valid), strength)


def pieces_below(image: Tensor, threshold: float) -> Tensor:
    """(H, W) int64: the 4-connected pieces of an ultrametric map that are not above a threshold, at its pixels."""
    return torch.from_numpy(components((image <= threshold).numpy(), connectivity=1))[1::2, 1::2].long()


def same_partition(one: Tensor, other: Tensor) -> bool:
    """Whether two label images divide the pixels alike, whatever the numbers; 0 is no label in both."""
    pairs = torch.unique(torch.stack([one.flatten(), other.flatten()]), dim=1)
    return all(len(side.unique()) == pairs.shape[1] for side in pairs) and torch.equal(one > 0, other > 0)


def test_weak_borders_go_first() -> None:
    hierarchy = build_hierarchy(row(0.5, 0.1, 0.9, 0.3))
    merges = list(zip(hierarchy.first.tolist(), hierarchy.second.tolist(), strict=True))
    assert merges == [(1, 2), (3, 4), (0, 1), (0, 3)]
    assert hierarchy.height.tolist() == pytest.approx([0.1, 0.3, 0.5, 0.9], abs=EXACT)


def test_a_merged_border_has_the_mean_along_its_length() -> None:
    label = torch.tensor([[1, 1, 2], [3, 3, 3]])
    strength = torch.zeros(2, 3, dtype=torch.float64)
    atoms = make_atoms(label, strength)
    atoms = Atoms(
        atoms.label,
        atoms.pixel_count,
        atoms.first,
        atoms.second,
        atoms.border_px,
        torch.tensor([0.1, 0.4, 0.7], dtype=torch.float64),
    )
    # Atoms 0 and 1 merge first; two pixels of 0.4 and one of 0.7 are left towards atom 2.
    assert build_hierarchy(atoms).height.tolist() == pytest.approx([0.1, (2 * 0.4 + 0.7) / 3], abs=EXACT)


def test_heights_never_fall(generator: torch.Generator) -> None:
    height = build_hierarchy(mosaic(generator)).height
    assert len(height) == 63
    assert bool((height.diff() >= 0).all())


def test_equal_borders_merge_in_order_of_their_atoms() -> None:
    hierarchy = build_hierarchy(row(0.5, 0.5, 0.5))
    assert hierarchy.first.tolist() == [0, 0, 0]
    assert hierarchy.second.tolist() == [1, 2, 3]


@pytest.mark.parametrize(
    ("threshold", "segments"),
    [(0.0, [{0}, {1}, {2}, {3}]), (0.1, [{0}, {1, 2}, {3}]), (0.6, [{0, 1, 2}, {3}]), (1.0, [{0, 1, 2, 3}])],
)
def test_a_cut_keeps_the_borders_above_the_threshold(threshold: float, segments: list[set[int]]) -> None:
    cut = build_hierarchy(row(0.5, 0.1, 0.9)).cut(threshold)
    assert list(cut.segments) == segments


def test_cuts_are_nested(generator: torch.Generator) -> None:
    hierarchy = build_hierarchy(mosaic(generator))
    fine, coarse = hierarchy.cut(0.5), hierarchy.cut(0.6)
    assert len(fine) > len(coarse) > 1
    for segment in fine.segments:
        assert any(segment <= other for other in coarse.segments)


def test_a_picture_without_atoms_has_an_empty_hierarchy() -> None:
    empty = make_atoms(torch.zeros(3, 3, dtype=torch.int64), torch.zeros(3, 3, dtype=torch.float64))
    assert len(build_hierarchy(empty).cut(1.0)) == 0


def test_a_segment_falls_apart_at_its_strongest_border() -> None:
    atoms = row(0.5, 0.1, 0.9, 0.3)
    whole = frozenset(range(5))
    assert split(whole, atoms, build_hierarchy(atoms)) == ({0, 1, 2}, {3, 4})


def test_borders_outside_the_segment_play_no_part() -> None:
    atoms = row(0.5, 0.1, 0.9, 0.3)
    assert split(frozenset({0, 1, 2}), atoms, build_hierarchy(atoms)) == ({0}, {1, 2})


def test_a_single_atom_cannot_be_split() -> None:
    atoms = row(0.5)
    assert split(frozenset({1}), atoms, build_hierarchy(atoms)) is None


def test_pieces_that_do_not_touch_stay_whole() -> None:
    atoms = row(0.9, 0.1, 0.1, 0.1)
    assert split(frozenset({0, 1, 3, 4}), atoms, build_hierarchy(atoms)) == ({0, 1}, {3, 4})


def test_of_several_pieces_the_nearest_are_joined() -> None:
    atoms = row(*[0.5] * 9)
    assert split(frozenset({0, 3, 7, 9}), atoms, build_hierarchy(atoms)) == ({0, 3}, {7, 9})


def test_the_split_of_a_part_of_the_hierarchy_is_how_it_was_made(generator: torch.Generator) -> None:
    atoms = mosaic(generator)
    hierarchy = build_hierarchy(atoms)
    parts = {atom: frozenset({atom}) for atom in range(len(atoms))}
    for kept, gone in zip(hierarchy.first.tolist(), hierarchy.second.tolist(), strict=True):
        made = parts[kept], parts.pop(gone)
        parts[kept] = made[0] | made[1]
        assert split(parts[kept], atoms, hierarchy) == made


def test_any_segment_falls_into_two_parts_that_make_it_up(generator: torch.Generator) -> None:
    atoms = mosaic(generator)
    hierarchy = build_hierarchy(atoms)
    before = deepcopy(hierarchy.borders)
    for _ in range(30):
        size = int(torch.randint(2, 30, (1,), generator=generator))
        segment = frozenset(torch.randperm(64, generator=generator)[:size].tolist())
        parts = split(segment, atoms, hierarchy)
        assert parts is not None
        one, other = parts
        assert one
        assert other
        assert one | other == segment
        assert not one & other
        assert min(one) < min(other)
        assert split(frozenset(sorted(segment, reverse=True)), atoms, hierarchy) == parts
    assert hierarchy.borders == before


@pytest.mark.parametrize("make", [mosaic, ragged])
def test_a_cut_is_what_hangs_together_below_the_threshold(make, generator: torch.Generator) -> None:
    atoms = make(generator)
    hierarchy = build_hierarchy(atoms)
    image = ultrametric_map(hierarchy, atoms)
    assert image.shape == (2 * atoms.label.shape[0] + 1, 2 * atoms.label.shape[1] + 1)
    assert float(hierarchy.height.max()) < 1.0
    between = (hierarchy.height[1:] + hierarchy.height[:-1]) / 2
    for threshold in (0.0, *hierarchy.height.tolist(), *between.tolist(), 0.999):
        assert same_partition(pieces_below(image, threshold), hierarchy.cut(threshold).labels(atoms))


def test_the_map_of_a_row_is_the_height_of_each_border() -> None:
    atoms = row(0.5, 0.1, 0.9)
    image = ultrametric_map(build_hierarchy(atoms), atoms)
    inside = [0.0] * (2 * SIDE - 1)
    assert image[1].tolist() == [1.0, *inside, 0.5, *inside, 0.1, *inside, 0.9, *inside, 1.0]
    assert torch.equal(image[2], image[1])  # corners have the height of their highest crack
    assert bool((image[0] == 1.0).all())


def test_what_has_no_atom_is_one() -> None:
    label = torch.tensor([[1, 0, 2]])
    atoms = make_atoms(label, torch.zeros(1, 3, dtype=torch.float64))
    assert ultrametric_map(build_hierarchy(atoms), atoms)[1].tolist() == [1.0, 0.0, 1.0, 1.0, 1.0, 0.0, 1.0]


def test_an_image_without_atoms_is_one_everywhere() -> None:
    empty = make_atoms(torch.zeros(2, 3, dtype=torch.int64), torch.zeros(2, 3, dtype=torch.float64))
    assert bool((ultrametric_map(build_hierarchy(empty), empty) == 1.0).all())


@pytest.mark.parametrize("make", [mosaic, ragged])
def test_of_three_heights_the_two_greatest_are_equal(make, generator: torch.Generator) -> None:
    atoms = make(generator)
    hierarchy, count = build_hierarchy(atoms), len(atoms)
    first, second = torch.cartesian_prod(torch.arange(count), torch.arange(count)).T
    height = joined_at(hierarchy, first, second).view(count, count)
    assert torch.equal(height, height.T)
    assert bool((height.diagonal() == 0).all())
    detour = torch.maximum(height[:, :, None], height[None]).amin(dim=1)  # by way of the best third atom
    assert bool((height <= detour).all())


def test_atoms_join_at_the_height_of_the_first_cut_that_holds_both(generator: torch.Generator) -> None:
    atoms = ragged(generator)
    hierarchy = build_hierarchy(atoms)
    first, second = torch.randint(0, len(atoms), (2, 60), generator=generator)
    height = joined_at(hierarchy, first, second)
    for i, j, joined in zip(first.tolist(), second.tolist(), height.tolist(), strict=True):
        cuts = (
            at
            for at in (0.0, *hierarchy.height.tolist())
            if any({i, j} <= part for part in hierarchy.cut(at).segments)
        )
        assert joined == next(cuts, torch.inf)
    assert bool(height.isinf().any())
