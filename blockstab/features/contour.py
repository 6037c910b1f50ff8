"""Features of the outline and the inside of a segment, whatever the rest of the image is divided into."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from scipy.sparse import coo_array
from scipy.sparse.csgraph import minimum_spanning_tree
from torch import Tensor

from blockstab.features.borders import BORDER_CUES, AtomBorders
from blockstab.features.formulas import columns_of
from blockstab.observation import Observation
from blockstab.segments.atoms import Atoms
from blockstab.segments.hierarchy import Hierarchy, joined_at

QUANTILES = (0.1, 0.25, 0.5)
WEAK = 0.3  # a boundary of less strength hardly parts two things
_BLOCK = 256  # segments measured at a time: (segments, borders) tables stay small


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
        self._atoms = atoms
        self._borders = AtomBorders.of(observation, atoms)
        self._joined = joined_at(hierarchy, atoms.first, atoms.second)

    def __call__(self, segments: Sequence[frozenset[int]]) -> Tensor:
        """Columns of S segments, (S, C) float64, in the order of `CONTOUR_COLUMNS`."""
        blocks = [segments[i : i + _BLOCK] for i in range(0, len(segments), _BLOCK)]
        rows = [columns_of(_FORMULAS, self._measured(block)) for block in blocks]
        return torch.cat(rows) if rows else torch.empty(0, len(CONTOUR_COLUMNS), dtype=torch.float64)

    def _measured(self, segments: Sequence[frozenset[int]]) -> _Measured:
        atoms, borders = self._atoms, self._borders
        inside = membership(segments, len(atoms))
        one, other = inside[:, atoms.first], inside[:, atoms.second]
        outline, interior = one ^ other, one & other
        held = inside.double()
        blank, rim = (held @ borders.open).unbind(dim=1)
        length = outline.double() @ atoms.border_px
        within = interior.double() @ atoms.border_px
        ahead, back = borders.front.unbind(dim=1)
        before = (outline & one).double() @ ahead + (outline & other).double() @ back
        behind = (outline & one).double() @ back + (outline & other).double() @ ahead
        saddle, pieces = self._saddles(interior, len(atoms), inside.sum(dim=1))
        weak = (outline & (atoms.strength < WEAK)).double() @ atoms.border_px
        return _Measured(
            outline_px=length + blank + rim,
            interior_px=within,
            pixels=held @ atoms.pixel_count.double(),
            weak_share=_means(weak, length),
            sides=torch.stack([before, behind, blank, rim], dim=1),
            strengths=_quantiles(atoms.strength, outline * atoms.border_px, (0.0, *QUANTILES)),
            outline=_means(outline.double() @ borders.cues, length),
            interior=_means(interior.double() @ borders.cues, within),
            weakest_atom=self._weakest(inside, outline),
            joins_at=_least(self._joined, outline),
            interior_greatest=torch.where(interior, atoms.strength, 0.0).amax(dim=1)
            if len(atoms.first)
            else 0.0 * within,
            saddle=saddle,
            pieces=pieces,
            atoms=inside.sum(dim=1),
        )

    def _weakest(self, inside: Tensor, outline: Tensor) -> Tensor:
        """(S,) the least mean strength of the border to one atom outside; 1 without any."""
        atoms = self._atoms
        segment, border = outline.nonzero(as_tuple=True)
        first, second = atoms.first[border], atoms.second[border]
        beyond = torch.where(inside[segment, first], second, first)
        shape = (inside.shape[0], len(atoms))
        length = torch.zeros(shape, dtype=torch.float64).index_put_(
            (segment, beyond), atoms.border_px[border], accumulate=True
        )
        total = torch.zeros(shape, dtype=torch.float64).index_put_(
            (segment, beyond), (atoms.border_px * atoms.strength)[border], accumulate=True
        )
        return torch.where(length > 0, total / length.clamp(min=1.0), 1.0).amin(dim=1)

    def _saddles(self, interior: Tensor, count: int, size: Tensor) -> tuple[Tensor, Tensor]:
        """(S,) the strongest border that is crossed on the easiest way through a segment; and its pieces."""
        atoms = self._atoms
        segment, border = interior.nonzero(as_tuple=True)
        nodes = interior.shape[0] * count
        # A graph has no edge where a weight is zero: one more keeps all.
        weights = (atoms.strength[border] + 1.0).numpy()
        ends = (
            (segment * count + atoms.first[border]).numpy(),
            (segment * count + atoms.second[border]).numpy(),
        )
        tree = minimum_spanning_tree(coo_array((weights, ends), shape=(nodes, nodes)).tocsr()).tocoo()
        owner = torch.from_numpy(tree.row.astype(np.int64) // count)
        height = torch.zeros(interior.shape[0], dtype=torch.float64)
        height = height.scatter_reduce(0, owner, torch.from_numpy(tree.data) - 1.0, "amax")
        return height, size - torch.bincount(owner, minlength=interior.shape[0])


def membership(segments: Sequence[frozenset[int]], count: int) -> Tensor:
    """(S, A) bool, which of `count` atoms each segment has."""
    inside = torch.zeros(len(segments), count, dtype=torch.bool)
    size = torch.tensor([len(segment) for segment in segments], dtype=torch.int64)
    members = torch.tensor([atom for segment in segments for atom in segment], dtype=torch.int64)
    inside[torch.arange(len(segments)).repeat_interleave(size), members] = True
    return inside


def _means(total: Tensor, length: Tensor) -> Tensor:
    """Totals (S,) or (S, K) along borders of these lengths (S,), as means; 0 where there is no border."""
    return total / length.clamp(min=1.0).view(-1, *[1] * (total.ndim - 1))


def _quantiles(value: Tensor, weight: Tensor, shares: Sequence[float]) -> Tensor:
    """(S, Q) weighted quantiles of the values (E,) of borders; 1 for segments without any, (S, E) weights of 0."""
    order = value.argsort(stable=True)
    passed = weight[:, order].cumsum(dim=1)
    if not len(value):
        return torch.ones(len(weight), len(shares), dtype=torch.float64)
    total = passed[:, -1:]
    goal = total * torch.tensor(shares, dtype=torch.float64)
    place = torch.searchsorted(passed, goal.clamp(min=1e-9)).clamp(max=len(value) - 1)
    return torch.where(total > 0, value[order][place], 1.0)


def _least(value: Tensor, chosen: Tensor) -> Tensor:
    """(S,) the least of the values (E,) chosen by (S, E), at most 1; 1 where none is."""
    if not len(value):
        return torch.ones(len(chosen), dtype=torch.float64)
    return torch.where(chosen, value.clamp(max=1.0), 1.0).amin(dim=1)
