"""Pools of masks: what proposals see as regions, as sets of atoms."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from blockstab.observation import Observation
from blockstab.proposals import Proposed
from blockstab.proposals.files import MaskFile
from blockstab.proposals.plane_pieces import Planes
from blockstab.proposals.pool import NoMasks, Regions
from blockstab.proposals.watershed import Watershed
from blockstab.search.moves.carve import Carve
from blockstab.segments.segmentation import Segmentation
from tests.search.watched import blocks_view, seeded, watched
from tests.synthetic import over_split


@dataclass(frozen=True)
class Drawn:
    """A proposal that was drawn by hand."""

    label: Tensor

    def __call__(self, observation: Observation) -> Proposed:
        return Proposed(self.label)


def test_nothing_is_offered_unless_a_pool_offers_it():
    assert list(NoMasks()(blocks_view())) == []
    assert list(Regions(())(blocks_view())) == []
    assert watched(blocks_view()).problem.offered == ()


def test_every_region_of_every_proposal_is_offered_as_the_atoms_that_lie_mostly_in_it():
    search_input = blocks_view()
    for proposals in ((Watershed(),), (Planes(),), (Watershed(), Planes(), Watershed(threshold=0.3))):
        offered = Regions(proposals)(search_input)
        expected = [
            s
            for p in proposals
            for s in Segmentation.from_labels(search_input.atoms, p(search_input.observation).label).segments
        ]
        assert offered == expected
        assert all(offered)


def test_an_atom_belongs_to_the_region_that_has_most_of_its_pixels():
    search_input = blocks_view()
    columns = torch.arange(search_input.atoms.label.shape[1]).expand_as(search_input.atoms.label)
    halves = 1 + (columns >= 90).long()
    offered = Regions((Drawn(halves),))(search_input)
    owner = {atom: number for number, segment in enumerate(offered) for atom in segment}
    mostly = [
        int(halves[search_input.atoms.label == atom + 1].mode().values)
        for atom in range(len(search_input.atoms))
    ]
    assert sorted(owner) == list(range(len(search_input.atoms)))
    assert [owner[atom] == owner[0] for atom in range(len(mostly))] == [m == mostly[0] for m in mostly]


def test_what_no_region_covers_is_not_offered():
    search_input = blocks_view()
    block = search_input.start.segments[2]
    label = torch.where(torch.isin(search_input.atoms.label - 1, torch.tensor(sorted(block))), 7, 0)
    assert Regions((Drawn(label),))(search_input) == [block]


def test_masks_of_another_segmenter_feed_the_pool_and_can_be_carved(tmp_path):
    search_input = blocks_view()
    truth = search_input.observation.frame.label
    masks = np.stack([(truth == region).numpy() for region in (2, 3, 4, 5)])
    np.savez_compressed(tmp_path / "blocks.npz", masks=masks)
    pool = Regions((MaskFile(f"{tmp_path}/{{scene}}.npz"),))
    account = watched(search_input, pool=pool)
    blocks = set(search_input.start.segments[1:])
    assert blocks <= set(account.problem.offered)
    (start,) = account.problem.rate([over_split(search_input)])
    carved = Carve()(start, account.problem, 1000, seeded(0))
    assert blocks <= {s for result in carved for s in result.segments}


def test_the_stamp_of_a_pool_changes_with_the_masks_of_a_scene(tmp_path):
    pool = Regions((Watershed(), MaskFile(f"{tmp_path}/{{scene}}.json")))
    stamps = set()
    for text in ("[]", "[1]"):
        (tmp_path / "one.json").write_text(text)
        stamps.add(pool.stamp("one"))
    (tmp_path / "two.json").write_text("[1, 2]")
    stamps.add(pool.stamp("two"))
    assert len(stamps) == 3
    assert Regions((Watershed(),)).stamp("one") == ""
