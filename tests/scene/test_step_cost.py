"""What a move costs: what it changes is thought over anew, and nothing else."""

from __future__ import annotations

import pytest

from blockstab.scene.builder import SceneBuilder
from blockstab.scene.inference import Rules
from blockstab.segments.hierarchy import build_hierarchy, split
from blockstab.testing.photographs import photograph
from blockstab.testing.worlds import Block
from tests.search.watched import CountingFitter, CountingJudge
from tests.synthetic import view_of

TOWER = (Block(-0.16, 0, 0.12, 0.06, d=0.1), Block(-0.16, 0.06, 0.09, 0.05, d=0.08))
APART = (
    Block(0.02, 0, 0.06, 0.05, z=-0.1, d=0.06),
    Block(0.16, 0, 0.06, 0.05, z=-0.1, d=0.06),
    Block(0.02, 0, 0.06, 0.05, z=0.06, d=0.06),
    Block(0.16, 0, 0.06, 0.05, z=0.06, d=0.06),
)


def cost_of_a_split(apart: int) -> tuple[int, int, int]:
    """Boxes fitted freely, and again, and boxes judged, where the top of the tower is taken in two."""
    view = view_of(photograph(*TOWER, *APART[:apart]))
    fitter, judge = CountingFitter(), CountingJudge()
    build = SceneBuilder(
        view.observation.cloud,
        view.occlusion,
        view.observation.ground,
        view.atoms,
        Rules(fitter=fitter, judge=judge),
    )
    build([view.start])
    before = sum(fitter.free), sum(fitter.refits), sum(judge.asked)
    top = view.start.labels(view.atoms)[view.observation.frame.label == 3].mode().values
    segment = view.start.segments[int(top) - 1]
    parts = split(segment, view.atoms, build_hierarchy(view.atoms))
    assert parts is not None
    build([view.start.replace(view.start.segments.index(segment), parts)])
    after = sum(fitter.free), sum(fitter.refits), sum(judge.asked)
    return after[0] - before[0], after[1] - before[1], after[2] - before[2]


@pytest.mark.parametrize("apart", [2, 4])
def test_a_move_fits_and_judges_as_much_however_many_objects_it_does_not_touch(apart):
    free, again, judged = cost_of_a_split(1)
    assert free == 2
    assert judged > 0
    assert cost_of_a_split(apart) == (free, again, judged)
