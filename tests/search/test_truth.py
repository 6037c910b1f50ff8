"""The truth drawn on atoms: a division of the same atoms as any other, told what is background."""

from __future__ import annotations

from dataclasses import replace
from itertools import chain

import pytest
import torch
from torch import Tensor

from blockstab.proposals.watershed import Watershed
from blockstab.search.problem import Problem
from blockstab.search.truth import Truth, true_segmentation
from blockstab.segments.overlap import Overlap
from blockstab.testing.photographs import BLOCKS, photograph
from tests.search.watched import blocks_view, seeded, watched
from tests.synthetic import view_of

FRAME = photograph(*BLOCKS).frame


def labelled(label: Tensor | None) -> Problem:
    """The blocks in regions of a watershed, their true labels replaced."""
    search_input = view_of(photograph(*BLOCKS), Watershed(threshold=0.3))
    frame = replace(search_input.observation.frame, label=label)
    return watched(replace(search_input, observation=replace(search_input.observation, frame=frame))).problem


def test_where_atoms_keep_to_objects_the_truth_is_the_labels():
    assert true_segmentation(watched(blocks_view()).problem) == blocks_view().start


def test_every_atom_goes_to_the_object_that_most_of_its_pixels_have():
    problem = labelled(FRAME.label)
    atoms, truth = problem.search_input.atoms, true_segmentation(problem)
    owner = [int(FRAME.label[atoms.label == a + 1].mode().values) for a in range(len(atoms))]
    assert {len({owner[a] for a in segment}) for segment in truth.segments} == {1}
    assert len(truth) == 5
    assert [truth.background[s] for s in truth.segments] == [owner[min(s)] == 1 for s in truth.segments]


@pytest.mark.parametrize("hidden", [(), (2,), (1,), (1, 2, 3, 4, 5)])
def test_the_truth_divides_all_atoms_whatever_has_no_label(hidden):
    gone = torch.isin(FRAME.label, torch.tensor(hidden, dtype=torch.int64))
    problem = labelled(torch.where(gone, 0, FRAME.label))
    truth = true_segmentation(problem)
    assert sorted(chain(*truth.segments)) == list(range(len(problem.search_input.atoms)))
    assert list(truth.segments) == sorted(truth.segments, key=min)


def test_a_shadow_without_labels_beside_an_object_does_not_change_the_truth():
    block = FRAME.label == 2
    shadow = block & ~torch.nn.functional.pad(block, (4, -4)).bool()  # its left rim, 4 pixels wide
    assert 30 < int(shadow.sum()) < int(block.sum()) / 3
    assert true_segmentation(labelled(torch.where(shadow, 0, FRAME.label))) == true_segmentation(
        labelled(FRAME.label)
    )


def test_what_lies_far_from_all_labels_stays_as_the_start_has_it():
    table = FRAME.label == 1
    problem = labelled(torch.where(table, 0, FRAME.label))
    truth, start = true_segmentation(problem), problem.search_input.start
    far = [s for s in truth.segments if truth.background.get(s, False)]
    assert far
    assert all(any(s <= region and start.background[region] for region in start.segments) for s in far)


def test_the_search_rates_the_start_and_ends_at_the_truth():
    problem = labelled(FRAME.label)
    found = Truth()(problem.search_input.start, problem, seeded(0))
    assert found.bests == (problem.search_input.start, true_segmentation(problem))
    frame = problem.search_input.observation.frame
    overlap = Overlap(problem.search_input.atoms, frame.label, frame.background_ids)
    assert float(overlap.best(found.best.scene.segmentation.segments)[1:].amin()) > 0.8


def test_an_image_without_labels_is_refused():
    problem = labelled(None)
    with pytest.raises(ValueError, match=r"blocks has no label\.png; the truth needs one"):
        Truth()(problem.search_input.start, problem, seeded(0))
