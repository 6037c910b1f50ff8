"""The trimmed supports of random islands, against trying every choice of supports by the written rule."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations
from typing import NamedTuple

import pytest
import shapely
import torch

from blockstab.geometry.convex_hulls import hull
from blockstab.stability.balance import EDGE_REACH
from blockstab.stability.support import GROUND, Supports, SupportType
from blockstab.stability.trimming import trim
from blockstab.testing.worlds import Block, WorldVerdicts, build, judge

TRIED = 4  # supports of either kind that are tried in combination; larger islands are not drawn
CLOSE = 1e-8


class Held(NamedTuple):
    """How supports hold a centre of mass: metres to spare, metres off the middle, square metres."""

    margin: float
    off_center: float
    area: float


def island(generator: torch.Generator) -> list[Block]:
    """3 to 6 blocks: stacked, bridged, side by side or leaning, now and then before a wall."""

    def choose(*options: float) -> float:
        return options[int(torch.randint(len(options), (1,), generator=generator))]

    def jitter() -> float:
        return 0.03 * float(torch.rand(1, generator=generator)) - 0.015

    blocks = []
    for _ in range(int(choose(3, 4, 5, 6))):
        tall = choose(0.1, 0.2)
        leaning = choose(0, 0, 0, 1) > 0
        blocks.append(
            Block(
                x=choose(-0.15, -0.1, -0.05, 0.0, 0.05, 0.1, 0.15) + jitter(),
                y=choose(0.0, 0.0, 0.1, 0.2) + 0.3 * jitter(),
                z=choose(0.0, 0.03),
                w=0.03 if leaning else choose(0.1, 0.2, 0.35),
                h=0.4 if leaning else tall,
                d=choose(0.1, 0.14),
                tilt_deg=choose(-25.0, 25.0) if leaning else choose(0.0, 0.0, 3.0),
                fixed=choose(0, 0, 0, 0, 1) > 0,
            )
        )
    return blocks


def islands(number: int) -> Iterator[WorldVerdicts]:
    generator = torch.Generator().manual_seed(20)
    while number:
        world = judge(*island(generator))
        side = world.candidates.type == SupportType.SIDE
        if all(
            int(world.candidates.supported[kind].bincount(minlength=1).max()) <= TRIED
            for kind in (side, ~side)
        ):
            number -= 1
            yield world


def held(supports: Supports, chosen: tuple[int, ...], center: tuple[float, float]) -> Held:
    """By GEOS."""
    vertices = []
    for k in chosen:
        vertices += supports.area.vertices[k, : int(supports.area.count[k])].tolist()
    shape, point = shapely.MultiPoint(vertices).convex_hull, shapely.Point(center)
    off_center = shape.centroid.distance(point)
    if shape.area < 1e-12:
        return Held(EDGE_REACH - shape.distance(point), off_center, 0.0)
    border = shape.exterior.distance(point)
    return Held(border if shape.contains(point) else -border, off_center, shape.area)


def best_choices(
    supports: Supports, own: list[int], center: tuple[float, float], slack: float
) -> set[frozenset[int]]:
    """The choices among the supports `own` of a box that the rule allows: one, or several that tie."""
    kind = supports.type.tolist()
    surface = tuple(k for k in own if kind[k] == SupportType.SURFACE)
    if surface and held(supports, surface, center).margin >= -slack:
        return {frozenset(surface)}
    if own and held(supports, tuple(own), center).margin < -slack:
        return {frozenset(own)}
    for size in range(1, len(own) + 1):
        stable = {}
        for chosen in combinations(own, size):
            if sum(kind[k] == SupportType.SIDE for k in chosen) <= 2:
                found = held(supports, chosen, center)
                if found.margin >= -slack:
                    stable[frozenset(chosen)] = found
        if stable:
            least = min(found.off_center for found in stable.values())
            central = {c: f for c, f in stable.items() if f.off_center < least + CLOSE}
            most = max(found.area for found in central.values())
            return {c for c, f in central.items() if f.area > most - CLOSE}
    return {frozenset(own)}


def from_the_top_down(supports: Supports, n: int) -> list[int]:
    """Boxes in an order in which each comes after all that may rest on it."""
    resting = supports.type != SupportType.SIDE
    rests_on = set(
        zip(supports.supported[resting].tolist(), supports.supporter[resting].tolist(), strict=True)
    )
    order: list[int] = []
    while len(order) < n:
        order += [b for b in range(n) if b not in order and all(u in order for u, v in rests_on if v == b)]
    return order


def broken_rules(world: WorldVerdicts, slack: torch.Tensor) -> list[tuple[int, set[int]]]:
    """Boxes whose kept supports are not those that the rule allows, and what was kept."""
    boxes, candidates = world.boxes, world.candidates
    n = len(boxes)
    trimmed = trim(boxes, candidates, slack)
    names = list(
        zip(
            candidates.supporter.tolist(),
            candidates.supported.tolist(),
            candidates.type.tolist(),
            strict=True,
        )
    )
    kept = {
        names.index(name)
        for name in zip(
            trimmed.supporter.tolist(), trimmed.supported.tolist(), trimmed.type.tolist(), strict=True
        )
    }
    load = {b: {b} for b in range(n)}
    wrong = []
    for b in from_the_top_down(candidates, n):
        pile_on = sorted(load[b])
        mass = boxes.volume()[pile_on]
        x, _, z = ((mass[:, None] * boxes.center[pile_on]).sum(dim=0) / mass.sum()).tolist()
        own = [k for k, name in enumerate(names) if name[1] == b]
        mine = kept & set(own)
        if frozenset(mine) not in best_choices(candidates, own, (x, z), float(slack[b])):
            wrong.append((b, mine))
        for k in mine:
            below, _, kind = names[k]
            if below != GROUND and kind != SupportType.SIDE:
                load[below] |= load[b]
    return wrong


@pytest.mark.parametrize("slack_m", [0.0, 0.01])
def test_the_kept_supports_are_those_that_trying_all_of_them_finds(slack_m: float) -> None:
    for world in islands(100):
        slack = torch.full((len(world.boxes),), slack_m, dtype=torch.float64)
        assert broken_rules(world, slack) == []


def test_of_three_side_supports_that_would_hold_a_box_no_more_than_two_are_taken() -> None:
    boxes, _ = build(Block(0, 0.5, 0.2, 0.2))
    places = torch.tensor([[0.0, 0.3], [-0.1, -0.1], [0.1, -0.1], [0.0, 0.9]], dtype=torch.float64)
    kind = torch.tensor([SupportType.SIDE] * 3 + [SupportType.SURFACE])
    to_box = torch.zeros(4, dtype=torch.int64)
    candidates = Supports(torch.full((4,), GROUND), to_box, kind, hull(places[:, None]))
    kept = trim(boxes, candidates, torch.zeros(1, dtype=torch.float64))
    # The three sides together would hold it more centrally than two of them and what is far behind it.
    assert kept.area.vertices[:, 0].tolist() == places[1:].tolist()


def test_the_piles_are_no_trivial_ones() -> None:
    kinds, dropped, hopeless = set(), 0, 0
    for world in islands(100):
        kinds |= {
            (b == GROUND, t)
            for b, t in zip(world.supports.supporter.tolist(), world.supports.type.tolist(), strict=True)
        }
        dropped += len(world.candidates) - len(world.supports)
        hopeless += int((~world.balance.stable).sum())
    assert len(kinds) == 5  # surface and partial, on blocks and on the ground, and side
    assert dropped > 100
    assert hopeless > 50


def test_an_empty_world_needs_no_support() -> None:
    lonely = judge(Block(0, 1.0, 0.1, 0.1))
    assert len(lonely.candidates) == len(lonely.supports) == 0
    assert not math.isfinite(float(lonely.balance.margin[0]))
