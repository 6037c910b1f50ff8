"""Which light reaches a known scene: where shadows fall, and how soft they are."""

from __future__ import annotations

import pytest
import torch

from blockstab.simulation.appearance.openness import Openness, openness
from blockstab.simulation.appearance.raycasting import RayCaster
from blockstab.simulation.appearance.room import furnish
from blockstab.simulation.appearance.viewpoint import draw_view
from blockstab.simulation.physics.solids import concatenate
from blockstab.simulation.sensors import Kinect
from tests.simulation.scenery import Scenery, lamps_at, of_one_part, standing

MAIN, SECOND, SKY, MIRROR = range(4)


@pytest.fixture(scope="module")
def scene() -> Scenery:
    """A block on a table, in a room without walls or cabinets."""
    pile = standing((of_one_part("box", (0.05, 0.1, 0.05), "block"), 0.0, 0.0))
    generator = torch.Generator().manual_seed(2)
    view = draw_view(generator, pile, Kinect(), "shelf")
    room = furnish(generator, view, pile)[[0, 1]]
    caster = RayCaster(concatenate([room, pile]))
    return Scenery(pile, room, view, caster, caster.first_hit(view.center, view.rays()))


def table_share(scene: Scenery, open_: Openness, channel: int, low: float, high: float) -> float:
    """The mean share on the table between two x, near z = 0, metres."""
    points, top = open_.seen.points, (open_.seen.solid == 0) & (open_.seen.points[..., 1].abs() < 1e-6)
    here = top & (points[..., 0] > low) & (points[..., 0] < high) & (points[..., 2].abs() < 0.03)
    assert int(here.sum()) > 5
    return float(open_.share[here][:, channel].mean())


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_shadows_fall_away_from_the_lamp(scene: Scenery, side: float) -> None:
    open_ = openness(scene.seen, scene.caster, lamps_at(side), scene.view.center)
    left, right = (table_share(scene, open_, MAIN, *sorted((s * 0.08, s * 0.2))) for s in (-1.0, 1.0))
    near, away = (left, right) if side < 0 else (right, left)
    assert near > 0.97
    assert away < 0.1


def test_the_table_is_darker_at_the_foot_of_a_block_than_far_from_it(scene: Scenery) -> None:
    open_ = openness(scene.seen, scene.caster, lamps_at(1.0), scene.view.center)
    foot, far = (table_share(scene, open_, SKY, *edges) for edges in ((0.05, 0.09), (0.4, 0.6)))
    assert far > 0.97
    assert foot < far - 0.1


def test_a_wider_lamp_throws_softer_shadows(scene: Scenery) -> None:
    lamps = [lamps_at(1.0, radius) for radius in (0.02, 0.3)]
    shares = [openness(scene.seen, scene.caster, lamp, scene.view.center).share[..., MAIN] for lamp in lamps]
    half = [int(((share > 0.1) & (share < 0.9)).sum()) for share in shares]
    assert half[1] > 2 * half[0]


def test_shares_at_the_pixels_of_the_grid_are_its_own(scene: Scenery) -> None:
    open_ = openness(scene.seen, scene.caster, lamps_at(1.0), scene.view.center)
    rows, columns = (
        v.flatten() for v in torch.meshgrid(torch.arange(40, 200), torch.arange(60, 280), indexing="ij")
    )
    own = scene.seen[2 * rows, 2 * columns]
    shares = open_.at(own, 2.0 * rows, 2.0 * columns)
    # A weight of a thousandth is left to the three neighbours.
    assert float((shares - open_.share[rows, columns]).abs().max()) < 5e-3
