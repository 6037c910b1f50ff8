"""What lies along the borders of atoms, each border against a loop over the sides of pixels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

from blockstab.features.borders import BORDER_CUES, AtomBorders
from blockstab.segments.atoms import make_atoms
from tests.features.atoms_scene import clutter
from tests.features.observed import HEIGHT, WIDTH
from tests.features.pixel_loop import around
from tests.tolerance import EXACT


def test_every_border_is_what_a_loop_over_the_sides_of_pixels_finds(generator):
    observation, atoms = clutter(generator, unlabelled=True)
    borders = AtomBorders.of(observation, atoms)
    assert borders.cues.shape == (len(atoms.first), len(BORDER_CUES))
    for atom in range(0, len(atoms), 9):
        seen = around(observation, atoms.label, frozenset({atom}))
        mine = (atoms.first == atom) | (atoms.second == atom)
        total = np.sum(seen.cues, axis=0)
        assert borders.cues[mine].sum(dim=0).tolist() == pytest.approx(total.tolist(), abs=1e-6)
        is_first = atoms.first[mine] == atom
        front = torch.where(is_first[:, None], borders.front[mine], borders.front[mine].flip(1)).sum(dim=0)
        assert front.tolist() == [seen.before, seen.behind]
        assert borders.open[atom].tolist() == [seen.blank, seen.rim]


def test_strength_along_borders_is_that_of_the_atoms(generator):
    observation, atoms = clutter(generator)
    along = AtomBorders.of(observation, atoms).cues[:, BORDER_CUES.index("strength")]
    torch.testing.assert_close(along, atoms.strength * atoms.border_px, rtol=0.0, atol=EXACT * 100)


@pytest.mark.parametrize(("near", "far"), [(0.8, 0.815), (2.0, 2.02)])
def test_only_what_is_nearer_by_more_than_the_noise_lies_before(generator, near, far):
    observation, _ = clutter(generator)
    left = torch.arange(WIDTH).expand(HEIGHT, WIDTH) < WIDTH // 2
    label = torch.where(left, 1, 2)
    depth = torch.where(left, near, far).double()
    valid = torch.ones_like(left)
    made = replace(observation, cloud=replace(observation.cloud, depth=depth, valid=valid))
    front = AtomBorders.of(made, make_atoms(label, observation.boundary_map.strength)).front
    # 15 mm are more than noise at 0.8 m; 20 mm are not, at 2 m.
    assert front.tolist() == [[HEIGHT if near < 1 else 0.0, 0.0]]


def test_nothing_lies_before_what_has_no_depth(generator):
    observation, _ = clutter(generator)
    left = torch.arange(WIDTH).expand(HEIGHT, WIDTH) < WIDTH // 2
    made = replace(observation, cloud=replace(observation.cloud, depth=torch.where(left, 1.0, 0.0).double()))
    atoms = make_atoms(torch.where(left, 1, 2), observation.boundary_map.strength)
    assert AtomBorders.of(made, atoms).front.tolist() == [[0.0, 0.0]]
