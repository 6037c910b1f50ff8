"""Contract of columns of features."""

from __future__ import annotations

import torch
from torch import Tensor

from blockstab.features.columns import SegmentColumns, computed
from blockstab.segments.segmentation import Segmentation
from blockstab.testing.searches import WITHIN, problem, starts


class ColumnsContract:
    """Tests of `SegmentColumns`."""

    part: SegmentColumns

    def test_its_columns_have_names_of_their_own(self) -> None:
        """That are neither ours nor each other's."""
        assert self.part.columns
        computed([self.part])

    def test_every_segment_has_a_number_in_every_column(self) -> None:
        """Neither infinite nor missing."""
        for start in starts():
            values = self._of(start)
            assert values.shape == (len(start.segments), len(self.part.columns))
            assert bool(values.isfinite().all())

    def test_asked_twice_it_says_the_same(self) -> None:
        """Up to rounding."""
        for start in starts():
            assert torch.allclose(self._of(start), self._of(start), rtol=0, atol=WITHIN)

    def _of(self, segmentation: Segmentation) -> Tensor:
        asked = problem()
        of = asked.search_input
        (scene,) = asked.build([segmentation])
        return self.part(of.observation, of.atoms, scene)
