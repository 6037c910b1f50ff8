"""What every partition into atoms must keep to."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch
from scipy import ndimage
from torch import Tensor

from blockstab.boundaries.cues import cues_of
from blockstab.boundaries.edge_models import FixedWeights
from blockstab.observation import estimated_ground, observe
from blockstab.rgbd.frame import Frame, read_scene
from blockstab.segments.atoms import MIN_ATOM_PX, absorb_small, join, make_atoms, over_segment
from blockstab.segments.flooding import basins
from blockstab.segments.gaps import fill_gaps, without_gaps
from blockstab.segments.pieces import connected_pieces
from blockstab.segments.plane_map import find_planes
from tests.block_scene import STACK, picture
from tests.tolerance import EXACT

EDGE = 0.8


def two_halves(ridge: float = EDGE) -> Tensor:
    """Weak everywhere but along one column."""
    strength = torch.zeros(40, 60, dtype=torch.float64)
    strength[:, 30] = ridge
    return strength


def grainy(generator: torch.Generator) -> tuple[Tensor, Tensor]:
    """Random strength, and a mask with holes and islands."""
    strength = torch.rand(90, 120, dtype=torch.float64, generator=generator)
    valid = torch.rand(90, 120, generator=generator) > 0.1
    valid[30:60, 40:70] = False
    valid[43:46, 50:53] = True
    return strength, valid


def strength_of(frame: Frame) -> Tensor:
    return FixedWeights()(cues_of(frame)).strength


def assert_atoms(label: Tensor) -> None:
    """Numbered from 1 without gaps, 4-connected, and large enough."""
    sizes = torch.bincount(label.flatten())[1:]
    assert int(sizes.min()) >= MIN_ATOM_PX
    for atom in range(1, int(label.max()) + 1):
        assert ndimage.label(label.numpy() == atom)[1] == 1


def test_an_edge_parts_two_atoms() -> None:
    label = over_segment(two_halves(), torch.ones(40, 60, dtype=torch.bool))
    assert int(label.max()) == 2
    assert label[0, 0] != label[0, 59]


def test_a_picture_without_edges_is_one_atom() -> None:
    flat = torch.zeros(30, 30, dtype=torch.float64)
    assert bool((over_segment(flat, torch.ones(30, 30, dtype=torch.bool)) == 1).all())


def test_a_picture_without_depth_has_no_atoms() -> None:
    flat = torch.zeros(30, 30, dtype=torch.float64)
    label = over_segment(flat, torch.zeros(30, 30, dtype=torch.bool))
    assert not label.any()
    assert len(make_atoms(label, flat)) == 0


def test_atoms_are_connected_and_large_enough(generator: torch.Generator) -> None:
    assert_atoms(over_segment(*grainy(generator)))


def test_atoms_cover_what_has_depth_and_its_small_gaps(generator: torch.Generator) -> None:
    strength, valid = grainy(generator)
    covered = without_gaps(valid)
    assert bool(covered[44, 51])  # an island of 9 pixels, smaller than an atom
    covered[40:50, 46:56] = False
    assert torch.equal(over_segment(strength, valid) > 0, covered)


def test_the_same_picture_gives_the_same_atoms(generator: torch.Generator) -> None:
    strength, valid = grainy(generator)
    kept = strength.clone(), valid.clone()
    assert torch.equal(over_segment(strength, valid), over_segment(strength, valid))
    assert torch.equal(strength, kept[0])
    assert torch.equal(valid, kept[1])


def test_colour_parts_what_lies_on_one_plane() -> None:
    label = over_segment(
        two_halves(), torch.ones(40, 60, dtype=torch.bool), torch.ones(40, 60, dtype=torch.int64)
    )
    assert int(label.max()) == 2


def test_planes_part_what_has_one_colour() -> None:
    plane = torch.ones(40, 60, dtype=torch.int64)
    plane[:, 20:40], plane[:, 40:] = 2, 0
    label = over_segment(
        torch.zeros(40, 60, dtype=torch.float64), torch.ones(40, 60, dtype=torch.bool), plane
    )
    assert [label[:, start : start + 20].unique().numel() for start in (0, 20, 40)] == [1, 1, 1]
    assert int(label.max()) == 3


def test_atoms_keep_to_their_plane_but_for_what_is_small_or_slim(generator: torch.Generator) -> None:
    strength, valid = grainy(generator)
    plane = (
        torch.randint(0, 3, (9, 12), generator=generator).repeat_interleave(10, 0).repeat_interleave(10, 1)
    )
    plane[20:22], plane[60:63, 60:64] = 3, 4
    label = over_segment(strength, valid, plane)
    assert_atoms(label)
    assert torch.equal(label > 0, over_segment(strength, valid) > 0)
    area = label > 0
    whole = fill_gaps(torch.where(valid, plane + 1, 0))
    pieces = connected_pieces(torch.where(area, 10_000 * whole + basins(strength, area), 0))
    owners = [
        label[piece].unique().tolist()
        for piece in (pieces == number for number in range(1, int(pieces.max()) + 1))
        if int(piece.sum()) >= MIN_ATOM_PX and ndimage.binary_erosion(piece.numpy(), np.ones((3, 3))).any()
    ]
    assert len(owners) > 10
    assert all(len(owner) == 1 for owner in owners)
    assert len({owner[0] for owner in owners}) == len(owners)


def test_every_atom_holds_a_square_of_three_pixels(generator: torch.Generator) -> None:
    strength, valid = grainy(generator)
    plane = (torch.arange(90)[:, None] % 13 < 2).long().expand(90, 120)
    label = over_segment(strength, torch.ones_like(valid), plane).numpy()
    for atom in range(1, int(label.max()) + 1):
        assert ndimage.binary_erosion(label == atom, np.ones((3, 3))).any()


def test_the_top_and_the_front_of_a_block_share_no_atom() -> None:
    scene = picture(STACK)
    strength, valid = strength_of(scene.frame), scene.cloud.valid
    block = scene.frame.label == 2
    top = block & (scene.cloud.normals[..., 1] > 0.99)
    front = block & (scene.cloud.normals[..., 2] > 0.99)

    def shared_px(label: Tensor) -> int:
        """Pixels of the faces in an atom that is mostly of the other one."""
        count = int(label.max()) + 1
        on = torch.stack([torch.bincount(label[face], minlength=count) for face in (top, front)])
        return int(on.amin(dim=0).sum())

    assert shared_px(over_segment(strength, valid)) > 500
    assert shared_px(over_segment(strength, valid, find_planes(scene.cloud).label)) < 20


def test_real_pictures_have_a_few_hundred_atoms(real_scenes: Path) -> None:
    frame = read_scene(real_scenes / "osd" / "learn20")
    label = observe(frame, estimated_ground).fine
    assert_atoms(label)
    assert 150 <= int(label.max()) <= 400


def test_borders_are_measured_along_their_length() -> None:
    label = torch.tensor([[1, 1, 2], [1, 1, 2], [3, 3, 0]])
    strength = torch.tensor([[0.0, 0.2, 0.6], [0.0, 0.1, 0.0], [0.4, 0.0, 1.0]], dtype=torch.float64)
    atoms = make_atoms(label, strength)
    assert atoms.pixel_count.tolist() == [4, 2, 2]
    assert list(zip(atoms.first.tolist(), atoms.second.tolist(), strict=True)) == [(0, 1), (0, 2)]
    assert atoms.border_px.tolist() == [2.0, 2.0]
    assert atoms.strength.tolist() == pytest.approx([(0.6 + 0.1) / 2, (0.4 + 0.1) / 2], abs=EXACT)


def test_borders_agree_with_a_count_pixel_by_pixel(generator: torch.Generator) -> None:
    label = torch.randint(0, 5, (12, 17), generator=generator)
    label[0, :4] = torch.arange(1, 5)
    strength = torch.rand(12, 17, dtype=torch.float64, generator=generator)
    found: dict[tuple[int, int], list[float]] = {}
    for (row, column), a in np.ndenumerate(label.numpy()):
        for r, c in ((row + 1, column), (row, column + 1)):
            if r < 12 and c < 17 and a > 0 and label[r, c] > 0 and a != label[r, c]:
                pair = min(a, int(label[r, c])) - 1, max(a, int(label[r, c])) - 1
                found.setdefault(pair, []).append(max(float(strength[row, column]), float(strength[r, c])))
    atoms = make_atoms(label, strength)
    assert list(zip(atoms.first.tolist(), atoms.second.tolist(), strict=True)) == sorted(found)
    assert atoms.border_px.tolist() == [len(found[pair]) for pair in sorted(found)]
    means = [sum(found[pair]) / len(found[pair]) for pair in sorted(found)]
    assert atoms.strength.tolist() == pytest.approx(means, abs=EXACT)


def test_numbers_with_gaps_are_refused() -> None:
    label = torch.tensor([[1, 3]])
    with pytest.raises(ValueError, match="2 is missing"):
        make_atoms(label, torch.zeros(1, 2, dtype=torch.float64))


@pytest.mark.parametrize("stage", [make_atoms, join])
def test_images_of_two_sizes_are_refused(stage) -> None:
    with pytest.raises(ValueError, match="one size"):
        stage(torch.ones(4, 5, dtype=torch.int64), torch.ones(5, 4, dtype=torch.int64))


def test_a_small_part_joins_across_its_weakest_border() -> None:
    label = torch.ones(20, 21, dtype=torch.int64)
    label[:, 9:11], label[:, 11:] = 2, 3
    strength = torch.zeros(20, 21, dtype=torch.float64)
    strength[:, 8] = EDGE
    assert absorb_small(make_atoms(label, strength), 50)[0].tolist() == [1] * 9 + [2] * 12


def test_a_small_part_without_neighbours_stays() -> None:
    label = torch.zeros(9, 9, dtype=torch.int64)
    label[4, 4] = 1
    assert torch.equal(absorb_small(make_atoms(label, torch.zeros(9, 9, dtype=torch.float64)), 50), label)


def test_joined_partitions_give_every_coarse_region_its_own_parts(generator: torch.Generator) -> None:
    strength, valid = grainy(generator)
    fine = over_segment(strength, valid)
    coarse = torch.zeros_like(fine)
    coarse[10:70, 5:55], coarse[20:50, 55:90], coarse[30:40, 20:60] = 9, 2, 40000
    parts = join(fine, coarse)
    assert torch.equal(parts > 0, coarse > 0)
    for part in range(1, int(parts.max()) + 1):
        assert len(coarse[parts == part].unique()) == 1
    assert_atoms(parts)


def test_a_coarse_region_without_atoms_stands_alone() -> None:
    fine = torch.zeros(20, 20, dtype=torch.int64)
    coarse = torch.zeros(20, 20, dtype=torch.int64)
    coarse[2:10, 2:10] = 5
    assert torch.equal(join(fine, coarse), (coarse > 0).long())


def test_two_pieces_of_a_coarse_region_are_two_parts() -> None:
    fine = torch.ones(20, 40, dtype=torch.int64)
    coarse = torch.full((20, 40), 3)
    coarse[:, 18:22] = 0
    assert int(join(fine, coarse).max()) == 2


def test_join_keeps_the_truth_of_a_picture() -> None:
    scene = picture(STACK)
    strength = strength_of(scene.frame)
    truth = scene.frame.label
    parts = join(over_segment(strength, scene.cloud.valid), truth)
    assert torch.equal(parts > 0, truth > 0)
    owner = torch.zeros(int(parts.max()) + 1, dtype=torch.int64)
    owner[parts] = truth
    assert torch.equal(owner[parts], truth)
