"""Contract of proposals."""

from __future__ import annotations

from dataclasses import fields, replace
from functools import cache

import torch

from blockstab.observation import Observation, given_ground, observe
from blockstab.proposals import Proposal
from blockstab.testing.photographs import BLOCKS, photograph


class ProposalContract:
    """Tests of a `Proposal`; one that needs more than a picture of blocks has other `observations`."""

    part: Proposal

    def observations(self) -> list[Observation]:
        """Blocks on a table, one block, background alone, and blocks of which the ground is unknown."""
        return list(_observations())

    def test_it_gives_a_label_image_with_a_region_at_least(self) -> None:
        """An int64 image of the frame's size, 0 = no region."""
        for observation in self.observations():
            label = self.part(observation).label
            assert label.dtype == torch.int64
            assert label.shape == observation.frame.depth.shape
            assert int(label.min()) >= 0
            assert bool((label > 0).any())

    def test_the_same_picture_gives_the_same_regions(self) -> None:
        """Bit for bit."""
        for observation in self.observations():
            one, other = self.part(observation), self.part(observation)
            assert torch.equal(one.label, other.label)
            assert one.is_background == other.is_background
            assert one.scores == other.scores

    def test_what_is_known_is_known_of_regions_that_exist(self) -> None:
        """No id without a pixel has a score, or is known as background."""
        for observation in self.observations():
            proposed = self.part(observation)
            there = set(proposed.label.flatten().tolist()) - {0}
            assert set(proposed.is_background) <= there
            assert set(proposed.scores) <= there

    def test_nothing_it_is_given_changes(self) -> None:
        """Neither the frame nor the cloud."""
        for observation in self.observations():
            parts = (observation.frame, observation.cloud)
            before = [getattr(part, f.name) for part in parts for f in fields(part)]
            copies = [value.clone() if torch.is_tensor(value) else value for value in before]
            self.part(observation)
            for value, copy in zip(before, copies, strict=True):
                assert torch.equal(value, copy) if torch.is_tensor(value) else value == copy


@cache
def _observations() -> tuple[Observation, ...]:
    pictures = [photograph(*some).frame for some in (BLOCKS, BLOCKS[:1], (replace(BLOCKS[0], fixed=True),))]
    seen = [observe(frame, given_ground) for frame in pictures]
    return (*seen, replace(seen[0], ground=replace(seen[0].ground, height=None)))
