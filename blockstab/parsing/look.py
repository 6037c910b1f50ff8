"""One look at an image: what several parsers ask of it is computed once."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from blockstab.boundaries.edge_models import EdgeModel
from blockstab.observation import GroundFinder, observe
from blockstab.proposals import Proposal
from blockstab.proposals.pool import Pool
from blockstab.proposals.search_input import SearchInput, make_search_input
from blockstab.rgbd.frame import Frame
from blockstab.segments.segmentation import Segment

Thing = TypeVar("Thing")


class Look:
    """Points, boundaries, first segmentations and masks of one image, each made when it is first asked for.

    None of them depends on potentials or on a search, nor on what else was made before.

    Convention:
        Two parsers ask for the same where they hold the very same part, such as one proposal. Equal parts that are
        two objects do not count: nothing tells whether those of a user are equal.
    """

    def __init__(self, frame: Frame) -> None:
        self.frame = frame
        self._made: dict[tuple[int, ...], tuple[tuple[object, ...], Any, float]] = {}

    def search_input(
        self, ground_of: GroundFinder, edges: EdgeModel, proposal: Proposal
    ) -> tuple[SearchInput, dict[str, float]]:
        """The image made ready, and the seconds that each stage took, whoever asked first."""
        frame = self.frame
        observation, looking = self._once(lambda: observe(frame, ground_of, edges), ground_of, edges)
        search_input, dividing = self._once(
            lambda: make_search_input(observation, proposal), observation, proposal
        )
        return search_input, {"observation": looking, "proposal": dividing}

    def masks(self, pool: Pool, search_input: SearchInput) -> tuple[Sequence[Segment], float]:
        """The masks of a pool, and the seconds that they took."""
        return self._once(lambda: pool(search_input), pool, search_input)

    def _once(self, make: Callable[[], Thing], *asked: object) -> tuple[Thing, float]:
        key = tuple(map(id, asked))
        if key not in self._made:
            begin = time.perf_counter()
            thing = make()
            # What was asked with is kept, so that nothing else gets its id.
            self._made[key] = asked, thing, time.perf_counter() - begin
        _, found, seconds = self._made[key]
        return found, seconds
