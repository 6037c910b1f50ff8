"""Features of the outline and the inside of a segment, whatever the rest of the image is divided into."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor

from blockstab.features.borders import BORDER_CUES, AtomBorders
from blockstab.features.formulas import columns_of
from blockstab.observation import Observation
from blockstab.segments.atoms import Atoms
from blockstab.segments.hierarchy import Hierarchy, joined_at

QUANTILES = (0.1, 0.25, 0.5)
WEAK = 0.3  # a boundary of less strength hardly parts two things
_SHARES = np.array([0.0, *QUANTILES])


@dataclass(frozen=True)
class _Measured:
    """Measurements of S segments: sums over their outlines and over the borders of atoms inside, in pixels."""

    outline_px: Tensor  # (S,) to other atoms, to what has no label, and to the image's rim
    interior_px: Tensor  # (S,)
    pixels: Tensor  # (S,)
    weak_share: Tensor  # (S,)
    sides: Tensor  # (S, 4) pixels of outline in the order of `_SIDES`
    strengths: Tensor  # (S, 1 + Q) the least, and quantiles
    outline: Tensor  # (S, K) means of `BORDER_CUES`
    interior: Tensor  # (S, K)
    weakest_atom: Tensor  # (S,)
    joins_at: Tensor  # (S,)
    interior_greatest: Tensor  # (S,)
    saddle: Tensor  # (S,)
    pieces: Tensor  # (S,)
    atoms: Tensor  # (S,)


_Formula = Callable[[_Measured], Tensor]
_SIDES = ("before", "behind", "blank", "rim")


def _side(k: int) -> _Formula:
    return lambda m: m.sides[:, k] / m.outline_px.clamp(min=1.0)


def _strength(k: int) -> _Formula:
    return lambda m: m.strengths[:, k]


def _outline(k: int) -> _Formula:
    return lambda m: m.outline[:, k]


def _interior(k: int) -> _Formula:
    return lambda m: m.interior[:, k]


_FORMULAS: dict[str, _Formula] = {
    "outline_px": lambda m: m.outline_px,
    "outline_relative": lambda m: m.outline_px / m.pixels.sqrt(),
    "outline_least": _strength(0),
    **{f"outline_quantile_{round(100 * q)}": _strength(k) for k, q in enumerate(QUANTILES, start=1)},
    "outline_weak_share": lambda m: m.weak_share,
    **{f"outline_{side}_share": _side(k) for k, side in enumerate(_SIDES)},
    **{f"outline_{cue}": _outline(k) for k, cue in enumerate(BORDER_CUES)},
    "outline_weakest_atom": lambda m: m.weakest_atom,
    "outline_joins_at": lambda m: m.joins_at,
    "interior_relative": lambda m: m.interior_px / m.pixels.sqrt(),
    "interior_greatest": lambda m: m.interior_greatest,
    **{f"interior_{cue}": _interior(k) for k, cue in enumerate(BORDER_CUES)},
    "saddle": lambda m: m.saddle,
    "saddle_gap": lambda m: m.outline[:, 0] - m.saddle,
    "pieces": lambda m: m.pieces,
    "atoms": lambda m: m.atoms,
}
CONTOUR_COLUMNS = tuple(_FORMULAS)


class Contours:
    """Columns of the contour of any set of atoms (paper, section 7.1, lets the potential see the box alone).

    * `outline_px`: length of the border to other atoms, to what has no label, and to the image's rim, in pixels;
      `relative`, divided by the root of the segment's pixels.
    * `least`, `quantile`, `weak_share`: of the boundary strength along the border to other atoms, by length.
    * `before`, `behind`, `blank`, `rim` share: of the outline, where the segment is nearer to the camera than what is
      beside it, further away, beside pixels without a label, and at the image's rim.
    * `outline_<cue>`, `interior_<cue>`: means along the outline, and along the borders of atoms inside.
    * `weakest_atom`: least strength to one atom outside; `joins_at`: height at which the hierarchy joins any of it.
    * `saddle`: height at which the segment's own atoms hang together; `saddle_gap`: mean strength of the outline
      above it. `pieces`: parts that do not touch.
    """

    def __init__(self, observation: Observation, atoms: Atoms, hierarchy: Hierarchy) -> None:
        """Measure the borders of all atoms once."""
        from blockstab.features.compiled.members import borders_of
        from blockstab.features.compiled.outlines import Graph

        found, order = AtomBorders.of(observation, atoms), atoms.strength.argsort(stable=True)
        self._borders = borders_of(atoms)
        self._graph = Graph(
            atoms.strength.numpy(),
            order.argsort().numpy(),
            order.numpy(),
            joined_at(hierarchy, atoms.first, atoms.second).numpy(),
            found.cues.numpy(),
            found.front.numpy(),
        )
        self._of_atoms = torch.cat([atoms.pixel_count.double()[:, None], found.open], dim=1).numpy()

    def __call__(self, segments: Sequence[frozenset[int]]) -> Tensor:
        """Columns of S segments, (S, C) float64, in the order of `CONTOUR_COLUMNS`."""
        # Importing numba takes half a second, and most of the package does without it.
        from blockstab.features.compiled.members import members_of, sums
        from blockstab.features.compiled.outlines import Outlines, outlines

        members = members_of(segments)
        pixels, blank, rim = torch.from_numpy(sums(members, self._of_atoms)).unbind(dim=1)
        measured = outlines(members, self._borders, self._graph, WEAK, _SHARES)
        found: Any = Outlines._make(map(torch.from_numpy, measured))
        return columns_of(
            _FORMULAS,
            _Measured(
                outline_px=found.length + blank + rim,
                interior_px=found.within,
                pixels=pixels,
                weak_share=_means(found.weak, found.length),
                sides=torch.stack([found.before, found.behind, blank, rim], dim=1),
                strengths=found.quantiles,
                outline=_means(found.outline, found.length),
                interior=_means(found.interior, found.within),
                weakest_atom=found.weakest_atom,
                joins_at=found.joins_at,
                interior_greatest=found.greatest,
                saddle=found.saddle,
                pieces=found.pieces,
                atoms=torch.from_numpy(np.diff(members.start)),
            ),
        )


def _means(total: Tensor, length: Tensor) -> Tensor:
    """Totals (S,) or (S, K) along borders of these lengths (S,), as means; 0 where there is no border."""
    return total / length.clamp(min=1.0).view(-1, *[1] * (total.ndim - 1))
