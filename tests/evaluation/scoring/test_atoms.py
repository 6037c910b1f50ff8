"""Scoring by atoms is scoring of the painted image."""

from __future__ import annotations

import pytest
import torch

from blockstab.evaluation.metrics import overlap_score
from blockstab.evaluation.scoring.atoms import OverlapOfAtoms
from blockstab.segments.atoms import make_atoms
from blockstab.segments.segmentation import Segmentation
from tests.evaluation.metrics.label_images import patches, scattered
from tests.tolerance import EXACT


@pytest.mark.parametrize("seed", range(5))
def test_it_is_the_score_of_the_label_image(seed):
    generator = torch.Generator().manual_seed(seed)
    truth = patches((3, 5, 8, 9), generator)
    parts = scattered(range(7), generator, tuple(truth.shape))  # 0 = in no atom
    atoms = make_atoms(parts, torch.zeros(truth.shape, dtype=torch.float64))
    groups = torch.randint(0, 4, (len(atoms) + 1,), generator=generator)  # 0 = in no segment
    segmentation = Segmentation.from_labels(atoms, groups[atoms.label])
    objects = [i for i in (3, 8, 9) if bool((truth == i).any())]
    found = OverlapOfAtoms(atoms, truth, objects)(segmentation)
    assert found == pytest.approx(overlap_score(truth, segmentation.labels(atoms), objects), abs=EXACT)
