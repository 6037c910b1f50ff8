"""Unions of atoms, against the same regions measured in the image."""

from __future__ import annotations

from dataclasses import fields, is_dataclass

import pytest
import torch

from blockstab.features.appearance.regions import viewed_regions
from blockstab.features.appearance.unions import UnionCells
from blockstab.features.appearance.views import view
from tests.features.atoms_scene import clutter, grouped
from tests.tolerance import EXACT


def alike(one: object, other: object, path: str) -> None:
    if is_dataclass(one):
        for field in fields(one):
            alike(getattr(one, field.name), getattr(other, field.name), f"{path}.{field.name}")
    else:
        torch.testing.assert_close(one, other, rtol=EXACT, atol=EXACT, msg=lambda said: f"{path}: {said}")


@pytest.mark.parametrize("unlabelled", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_a_union_of_atoms_is_measured_as_the_region_it_is(seed, unlabelled):
    generator = torch.Generator().manual_seed(seed)
    observation, atoms = clutter(generator, unlabelled)
    segmentation, views = grouped(atoms, generator), view(observation)
    inside = torch.zeros(len(segmentation), len(atoms) + 1, dtype=torch.bool)
    for k, segment in enumerate(segmentation.segments):
        inside[k, sorted(segment)] = True
    found = UnionCells(views, atoms.label).regions(inside)
    expected = viewed_regions(views, segmentation.labels(atoms))
    assert len(found) == len(expected) == len(segmentation)
    alike(found, expected, "regions")
    assert torch.equal(found.shapes.samples, expected.shapes.samples)
    assert torch.equal(found.places.few, expected.places.few)


def test_one_atom_alone_is_a_union_too(generator):
    observation, atoms = clutter(generator)
    views = view(observation)
    inside = torch.nn.functional.pad(torch.eye(len(atoms), dtype=torch.bool), (0, 1))
    alike(UnionCells(views, atoms.label).regions(inside), viewed_regions(views, atoms.label), "regions")


def test_no_union_is_no_region(generator):
    observation, atoms = clutter(generator)
    none = torch.zeros(0, len(atoms) + 1, dtype=torch.bool)
    assert len(UnionCells(view(observation), atoms.label).regions(none)) == 0
