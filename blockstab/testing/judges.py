"""Contract of judges of stability."""

from __future__ import annotations

import torch

from blockstab.boxes.box import Boxes, concatenate
from blockstab.boxes.separation import separation
from blockstab.stability.judges import StabilityJudge, Verdicts
from blockstab.stability.removal import falls_if_removed
from blockstab.stability.support import SupportRules, Supports, candidate_supports
from blockstab.testing.worlds import BRIDGE, ONE_BLOCK, STACK, Block, build


class JudgeContract:
    """Tests of a `StabilityJudge`."""

    part: StabilityJudge

    def test_one_block_on_the_ground_and_a_stack_stand(self) -> None:
        """On the whole of their lower faces."""
        for world in (ONE_BLOCK, STACK):
            assert bool(self._judged(*build(*world)).balance.stable.all())

    def test_a_block_in_the_air_falls_unless_it_is_background(self) -> None:
        """Nothing holds it."""
        assert not bool(self._judged(*build(Block(0, 0.5, 0.1, 0.1))).balance.stable.any())
        assert bool(self._judged(*build(Block(0, 0.5, 0.1, 0.1, fixed=True))).balance.stable.all())

    def test_the_supports_that_count_are_among_the_candidates(self) -> None:
        """A judge drops relations, and invents none."""
        boxes, movable = build(*BRIDGE)
        known = _pairs(_candidates(boxes, movable))
        assert _pairs(self._judged(boxes, movable).supports) <= known

    def test_what_is_said_of_a_pile_does_not_depend_on_another(self) -> None:
        """Islands may come in one table."""
        one, other = build(*STACK), build(Block(0, 0.5, 0.1, 0.1))
        far = Boxes(
            other[0].center + torch.tensor([5.0, 0, 0]).double(), other[0].rotation, other[0].half_extent
        )
        both = self._judged(concatenate([one[0], far]), torch.cat([one[1], other[1]]))
        assert torch.equal(both.balance.stable[: len(one[0])], self._judged(*one).balance.stable)

    def test_what_stands_on_a_block_falls_without_it(self) -> None:
        """Removal asks the same judge."""
        boxes, movable = build(*STACK)
        exact = torch.zeros(len(boxes), dtype=torch.float64)
        stable = self._judged(boxes, movable).balance.stable
        table = falls_if_removed(boxes, movable, _candidates(boxes, movable), stable, exact, self._judge())
        assert table.tolist() == [[False, True], [False, False]]

    def _judged(self, boxes: Boxes, movable: torch.Tensor) -> Verdicts:
        exact = torch.zeros(len(boxes), dtype=torch.float64)
        return self._judge()(boxes, movable, _candidates(boxes, movable), exact)

    def _judge(self) -> StabilityJudge:
        return self.part


def _candidates(boxes: Boxes, movable: torch.Tensor) -> Supports:
    n = len(boxes)
    first, second = torch.triu_indices(n, n, offset=1)
    ground, none = torch.zeros(n, dtype=torch.float64), torch.zeros(n, dtype=torch.bool)
    apart = separation(boxes, first, second)
    return candidate_supports(boxes, (first, second), apart, ground, movable, none, SupportRules())


def _pairs(supports: Supports) -> set[tuple[int, int]]:
    return set(zip(supports.supporter.tolist(), supports.supported.tolist(), strict=True))
