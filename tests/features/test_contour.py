"""The contour of segments, against a loop over the sides of pixels."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import torch
from torch import Tensor

from blockstab.features.borders import BORDER_CUES
from blockstab.features.contour import CONTOUR_COLUMNS, QUANTILES, WEAK, Contours
from blockstab.observation import Observation
from blockstab.segments.atoms import Atoms, make_atoms
from blockstab.segments.hierarchy import Hierarchy, build_hierarchy, joined_at
from tests.features.atoms_scene import clutter, grouped, renamed
from tests.features.pixel_loop import around, groups
from tests.tolerance import COMPANY, EXACT

Made = tuple[Observation, Atoms, list[frozenset[int]]]


@cache
def made(seed: int = 7) -> Made:
    """An image in atoms, some pixels without a label; groups of atoms near and far, single ones, and all."""
    generator = torch.Generator().manual_seed(seed)
    observation, atoms = clutter(generator, unlabelled=True)
    # Weak borders on the left, strong ones on the right.
    strength = observation.boundary_map.strength * torch.linspace(0.1, 1.0, atoms.label.shape[1]).double()
    observation = replace(observation, boundary_map=replace(observation.boundary_map, strength=strength))
    atoms = make_atoms(atoms.label, strength)
    some = list(grouped(atoms, generator).segments)
    return observation, atoms, [*some, frozenset({0}), frozenset({3}), frozenset(range(len(atoms)))]


def measured(observation: Observation, atoms: Atoms, segments: list[frozenset[int]]) -> Tensor:
    return Contours(observation, atoms, build_hierarchy(atoms))(segments)


def by_loop(
    observation: Observation, atoms: Atoms, hierarchy: Hierarchy, segment: frozenset[int]
) -> dict[str, float]:
    """All columns of one segment, worked out the slow way."""
    seen = around(observation, atoms.label, segment)
    pixels = int(torch.isin(atoms.label - 1, torch.tensor(sorted(segment))).sum())
    length = sum(map(len, seen.border.values()))
    whole = length + seen.blank + seen.rim
    along = np.sort(np.concatenate([[np.mean(s)] * len(s) for s in seen.border.values()] or [[]]))
    inner = {pair: float(np.mean(strength)) for pair, strength in seen.inner.items()}
    outside = {b for _, b in seen.border}
    to_atom = [np.concatenate([s for (_, b), s in seen.border.items() if b == atom]) for atom in outside]
    joined = [float(joined_at(hierarchy, *torch.tensor(pair).view(2, 1))) for pair in seen.border]
    within, cues = sum(map(len, seen.inner.values())), len(BORDER_CUES)
    outline_means = np.mean(seen.cues, axis=0) if length else np.zeros(cues)
    inner_means = np.mean(seen.inner_cues, axis=0) if within else np.zeros(cues)
    pieces = len(groups(segment, list(inner)))
    heights = [0.0, *sorted(inner.values())]
    saddle = next(
        h for h in heights if len(groups(segment, [p for p, s in inner.items() if s <= h])) == pieces
    )
    return {
        "outline_px": whole,
        "outline_relative": whole / pixels**0.5,
        "outline_least": along[0] if length else 1.0,
        **{
            f"outline_quantile_{round(100 * q)}": along[int(np.ceil(q * length)) - 1] if length else 1.0
            for q in QUANTILES
        },
        "outline_weak_share": float(np.mean(along < WEAK)) if length else 0.0,
        "outline_before_share": seen.before / whole,
        "outline_behind_share": seen.behind / whole,
        "outline_blank_share": seen.blank / whole,
        "outline_rim_share": seen.rim / whole,
        **{f"outline_{cue}": outline_means[k] for k, cue in enumerate(BORDER_CUES)},
        "outline_weakest_atom": min(map(np.mean, to_atom)) if length else 1.0,
        "outline_joins_at": min([1.0, *joined]),
        "interior_relative": within / pixels**0.5,
        "interior_greatest": max(inner.values(), default=0.0),
        **{f"interior_{cue}": inner_means[k] for k, cue in enumerate(BORDER_CUES)},
        "saddle": saddle,
        "saddle_gap": outline_means[0] - saddle,
        "pieces": pieces,
        "atoms": len(segment),
    }


@pytest.mark.parametrize("seed", [7, 8])
def test_every_column_is_what_a_loop_over_the_sides_of_pixels_finds(seed):
    observation, atoms, segments = made(seed)
    hierarchy = build_hierarchy(atoms)
    for segment, row in zip(segments, measured(observation, atoms, segments), strict=True):
        expected = by_loop(observation, atoms, hierarchy, segment)
        assert list(expected) == list(CONTOUR_COLUMNS)
        assert dict(zip(CONTOUR_COLUMNS, row.tolist(), strict=True)) == pytest.approx(expected, abs=EXACT)


def test_the_images_have_all_that_is_to_be_measured():
    observation, atoms, segments = made()
    rows = measured(observation, atoms, segments)
    constant = [
        name for name, column in zip(CONTOUR_COLUMNS, rows.T, strict=True) if float(column.std()) == 0
    ]
    assert constant == []


def test_a_segment_is_the_same_within_1e_9_in_whatever_company_it_is_measured():
    observation, atoms, segments = made()
    contours = Contours(observation, atoms, build_hierarchy(atoms))
    together = contours(segments * 40)  # more than are measured at a time
    alone = torch.cat([contours([segment]) for segment in segments])
    torch.testing.assert_close(together, alone.repeat(40, 1), rtol=0.0, atol=COMPANY)
    backwards = contours(segments[::-1]).flip(0)
    torch.testing.assert_close(backwards, alone, rtol=0.0, atol=COMPANY)


def test_no_segment_gives_no_row():
    observation, atoms, _ = made()
    assert measured(observation, atoms, []).shape == (0, len(CONTOUR_COLUMNS))


def test_the_names_of_atoms_do_not_matter(generator):
    observation, atoms, segments = made()
    under_other_names = measured(observation, *renamed(observation, atoms, segments, generator))
    torch.testing.assert_close(
        under_other_names, measured(observation, atoms, segments), rtol=0.0, atol=COMPANY
    )


def test_the_image_may_be_mirrored():
    observation, atoms, segments = made()
    strength = replace(observation.boundary_map, strength=observation.boundary_map.strength.flip(1))
    cloud = replace(
        observation.cloud, depth=observation.cloud.depth.flip(1), valid=observation.cloud.valid.flip(1)
    )
    mirrored = replace(observation, boundary_map=strength, cloud=cloud, cues=observation.cues.flip(2))
    other = make_atoms(atoms.label.flip(1), strength.strength)
    torch.testing.assert_close(
        measured(mirrored, other, segments), measured(observation, atoms, segments), rtol=0.0, atol=COMPANY
    )


def test_a_segment_that_fills_the_image_ends_at_its_rim_alone():
    observation, atoms, _ = made()
    height, width = atoms.label.shape
    whole = make_atoms(torch.ones_like(atoms.label), observation.boundary_map.strength)
    (row,) = measured(observation, whole, [frozenset({0})])
    values = dict(zip(CONTOUR_COLUMNS, row.tolist(), strict=True))
    assert values["outline_px"] == 2 * (height + width)
    assert values["outline_rim_share"] == 1.0
    assert values["outline_least"] == values["outline_weakest_atom"] == values["outline_joins_at"] == 1.0


def test_a_merge_moves_the_border_between_two_parts_from_their_outlines_inside():
    observation, atoms, _ = made()
    one, other = frozenset({int(atoms.first[0])}), frozenset({int(atoms.second[0])})
    a, b, both = measured(observation, atoms, [one, other, one | other])
    outline = CONTOUR_COLUMNS.index("outline_px")
    pixels = float(atoms.pixel_count[list(one | other)].sum())
    within = float(both[CONTOUR_COLUMNS.index("interior_relative")]) * pixels**0.5
    assert within == pytest.approx(float(atoms.border_px[0]))
    assert float(both[outline]) == pytest.approx(float(a[outline] + b[outline]) - 2 * within)
    assert float(both[CONTOUR_COLUMNS.index("saddle")]) == pytest.approx(float(atoms.strength[0]))
