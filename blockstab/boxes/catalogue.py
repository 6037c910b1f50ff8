"""Boxes fitted once, and gaps computed once, for all segmentations of one image that a search looks at."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Protocol

import numpy as np
import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.boxes.fitting import Fits
from blockstab.boxes.sampling import scramble
from blockstab.boxes.separation import Separation, separation
from blockstab.segments.segmentation import Segment

BoxKey = tuple[Segment, bytes]  # a segment, and the bytes of the axis it was fitted to (none: b"")
_NO_AXIS = b""


class BoxFitter(Protocol):
    """What fits boxes: see `fitting.MinimumSurface`."""

    @property
    def max_points(self) -> int: ...

    def __call__(self, points: Tensor, count: Tensor, seed: Tensor, axis: Tensor | None = None) -> Fits: ...


class SegmentPoints:
    """The points of any set of atoms, at most `max_points` of them, in an order that only their pixels decide.

    Every pixel has a fixed random rank; a segment's points are those of its pixels that rank first. So a
    segment has the same points however it came about, and a prefix of them is a random sample.
    """

    def __init__(self, points: Tensor, atom_of_pixel: Tensor, n_atoms: int, max_points: int) -> None:
        """Sort the pixels by atom and rank.

        Args:
            points: (M, 3) metres; atom_of_pixel: (M,) index of the atom of each, of all pixels with depth.
        """
        pixel = torch.arange(len(points))
        rank = scramble(pixel)
        order = np.lexsort((rank.numpy(), atom_of_pixel.numpy()))
        self.max_points = max_points
        self._points = points
        self._pixel_of_rank = rank.argsort()
        place = torch.empty_like(pixel)
        place[self._pixel_of_rank] = pixel
        self._ranked = place.numpy()[order]
        self.count = torch.bincount(atom_of_pixel, minlength=n_atoms)
        self._start = np.concatenate([[0], self.count.cumsum(0).numpy()])

    def gather(self, segments: list[Segment]) -> tuple[Tensor, Tensor, Tensor]:
        """Points (S, max_points, 3) of each segment, how many there are (S,), and its seed (S,).

        Rows past the count repeat the first point.
        """
        index = np.zeros((len(segments), self.max_points), dtype=np.int64)
        count = np.zeros(len(segments), dtype=np.int64)
        for i, segment in enumerate(segments):
            first = np.sort(np.concatenate([self._first_of(atom) for atom in segment]))[: self.max_points]
            count[i] = len(first)
            index[i, : len(first)] = first
            index[i, len(first) :] = first[0]
        pixel = self._pixel_of_rank[torch.from_numpy(index)]
        seed = scramble(pixel[:, 0]) ^ torch.from_numpy(count)
        return self._points[pixel], torch.from_numpy(count), seed

    def _first_of(self, atom: int) -> np.ndarray:
        start, end = self._start[atom], self._start[atom + 1]
        first: np.ndarray = self._ranked[start : min(end, start + self.max_points)]
        return first


class Catalogue:
    """All boxes of one image so far: each (segment, axis) is fitted once, each pair of boxes measured once."""

    def __init__(self, points: SegmentPoints, fitter: BoxFitter) -> None:
        self.points = points
        self.fitter = fitter
        self.fits = Fits.none()
        self._row: dict[BoxKey, int] = {}
        self._variant: dict[tuple[int, bytes], int] = {}
        self._owner = torch.empty(0, dtype=torch.long)  # the smallest atom of the segment of each row
        self._pair_key = torch.empty(0, dtype=torch.long)
        self._pair_value = torch.empty(0, 4, dtype=torch.float64)

    def __len__(self) -> int:
        """How many fits have been made."""
        return len(self._row)

    def rows(self, segments: Sequence[Segment], axes: Tensor | None = None) -> Tensor:
        """Rows in `fits` of the boxes of these segments; those not yet known are fitted in one batch.

        Args:
            axes: (S, 3) the axis each box is fitted to; NaN where it is free.
        """
        if axes is None:
            keys: list[BoxKey] = [(segment, _NO_AXIS) for segment in segments]
        else:
            free = axes.isnan().any(dim=1).tolist()
            keys = [
                (s, _NO_AXIS if f else a.tobytes())
                for s, f, a in zip(segments, free, axes.numpy(), strict=True)
            ]
        self._fit(dict.fromkeys(k for k in keys if k not in self._row))
        return torch.tensor([self._row[key] for key in keys], dtype=torch.long)

    def _fit(self, new: Iterable[BoxKey]) -> None:
        for free in (True, False):
            keys = [key for key in new if (key[1] == _NO_AXIS) == free]
            if not keys:
                continue
            axis = None
            if not free:
                axis = torch.from_numpy(np.stack([np.frombuffer(a, dtype=np.float64) for _, a in keys]))
            fits = self.fitter(*self.points.gather([segment for segment, _ in keys]), axis)
            start = len(self.fits)
            self.fits = self.fits.extended(fits)
            self._owner = torch.cat([self._owner, torch.tensor([min(segment) for segment, _ in keys])])
            self._row.update((key, start + i) for i, key in enumerate(keys))

    def variants(self, rows: Tensor, boxes: Boxes) -> Tensor:
        """Rows of boxes that replace those of `rows`; where a box is unchanged, its row is too.

        What is known of the fit stays: the points are the same, and what was added is what they do not show.
        """
        old = self.fits.boxes[rows]
        changed = ((old.center != boxes.center) | (old.half_extent != boxes.half_extent)).any(dim=1)
        result = rows.clone()
        for i in changed.nonzero()[:, 0].tolist():
            key = (int(rows[i]), boxes.center[i].numpy().tobytes() + boxes.half_extent[i].numpy().tobytes())
            if key not in self._variant:
                self._variant[key] = len(self.fits)
                self.fits = self.fits.extended(self.fits[rows[i : i + 1]].with_boxes(boxes[i : i + 1]))
                self._owner = torch.cat([self._owner, self._owner[rows[i : i + 1]]])
            result[i] = self._variant[key]
        return result

    def separation(self, first: Tensor, second: Tensor) -> Separation:
        """Gaps and directions of pairs of rows (P,), measured once for each pair of boxes."""
        # The order in which two boxes are measured decides how the gap is rounded, so it must not be that of the
        # rows, which depends on what was fitted before.
        swapped = self._owner[first] > self._owner[second]
        key = torch.where(swapped, second, first) << 32 | torch.where(swapped, first, second)
        wanted, place = torch.unique(key, return_inverse=True)
        known = torch.searchsorted(self._pair_key, wanted)
        if len(self._pair_key):
            fresh = wanted[self._pair_key[known.clamp(max=len(self._pair_key) - 1)] != wanted]
        else:
            fresh = wanted
        if len(fresh):
            apart = separation(self.fits.boxes, fresh >> 32, fresh & 0xFFFFFFFF)
            value = torch.cat([apart.gap[:, None], apart.direction], dim=1)
            merged, order = torch.cat([self._pair_key, fresh]).sort()
            self._pair_key, self._pair_value = merged, torch.cat([self._pair_value, value])[order]
        value = self._pair_value[torch.searchsorted(self._pair_key, wanted)[place]]
        turned = torch.where(swapped, -1.0, 1.0)[:, None]
        return Separation(value[:, 0], value[:, 1:] * turned)
