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
    """A fitter of boxes: see `fitting.MinimumSurface`."""

    @property
    def max_points(self) -> int: ...

    def coarser(self, times: float) -> BoxFitter:
        """The same for depth whose step is that many times that of a Kinect."""

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
        self._first: dict[Segment, np.ndarray] = {}

    def gather(self, segments: list[Segment]) -> tuple[Tensor, Tensor, Tensor]:
        """Points (S, P, 3) of each segment, how many there are (S,), and its seed (S,).

        P is the most that any has. Rows past the count repeat the first point.
        """
        found = [self._first_of(segment) for segment in segments]
        count = np.fromiter(map(len, found), dtype=np.int64, count=len(found))
        index = np.empty((len(found), int(count.max(initial=1))), dtype=np.int64)
        for i, first in enumerate(found):
            index[i, : len(first)] = first
            index[i, len(first) :] = first[0]
        pixel = self._pixel_of_rank[torch.from_numpy(index)]
        seed = scramble(pixel[:, 0]) ^ torch.from_numpy(count)
        return self._points[pixel], torch.from_numpy(count), seed

    def _first_of(self, segment: Segment) -> np.ndarray:
        """The ranks of a segment's points; it is asked for when it is fitted, judged and fitted again."""
        if segment not in self._first:
            parts = [self._ranked[self._start[a] : self._end_of(a)] for a in segment]
            self._first[segment] = np.sort(np.concatenate(parts))[: self.max_points].astype(np.int32)
        return self._first[segment]

    def _end_of(self, atom: int) -> int:
        return int(min(self._start[atom + 1], self._start[atom] + self.max_points))


class BoxCache:
    """All boxes of one image so far: each (segment, axis) is fitted once, each pair of boxes measured once."""

    def __init__(self, points: SegmentPoints, fitter: BoxFitter) -> None:
        self.points = points
        self.fitter = fitter
        self.fits = Fits.none()
        self._row: dict[BoxKey, int] = {}
        self._variant: dict[tuple[int, bytes], int] = {}
        self._fitted: dict[int, int] = {}  # the row of the fit that a variant is of
        # Arrays, because a search asks for few pairs at a time, and often.
        self._owner = np.empty(0, dtype=np.int64)  # the smallest atom of the segment of each row
        self._pair_key = np.empty(0, dtype=np.int64)  # ascending
        self._pair_value = np.empty((0, 4))

    def __len__(self) -> int:
        """The number of fits made."""
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
            self._owner = np.append(self._owner, [min(segment) for segment, _ in keys])
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
                self._owner = np.append(self._owner, self._owner[int(rows[i])])
                self._fitted[self._variant[key]] = int(rows[i])
            result[i] = self._variant[key]
        return result

    def fitted(self, rows: Tensor) -> Tensor:
        """Rows of the boxes as they were fitted to their points, before anything was added to them."""
        return torch.tensor([self._fitted.get(row, row) for row in rows.tolist()], dtype=torch.long)

    def separation(self, first: Tensor, second: Tensor) -> Separation:
        """Gaps and directions of pairs of rows (P,), measured once for each pair of boxes."""
        # The order in which two boxes are measured decides how the gap is rounded, so it must not be that of the
        # rows, which depends on what was fitted before.
        one, other = first.numpy(), second.numpy()
        swapped = self._owner[one] > self._owner[other]
        key = np.where(swapped, other, one) << 32 | np.where(swapped, one, other)
        self._measure(key[~_found(key, self._pair_key)])
        value = torch.from_numpy(self._pair_value[np.searchsorted(self._pair_key, key)])
        turned = torch.from_numpy(np.where(swapped, -1.0, 1.0))[:, None]
        return Separation(value[:, 0], value[:, 1:] * turned)

    def _measure(self, new: np.ndarray) -> None:
        """Measure pairs that are not yet known."""
        if not len(new):
            return
        key = np.unique(new)
        apart = separation(self.fits.boxes, torch.from_numpy(key >> 32), torch.from_numpy(key & 0xFFFFFFFF))
        value = torch.cat([apart.gap[:, None], apart.direction], dim=1).numpy()
        place = np.searchsorted(self._pair_key, key)
        self._pair_key = np.insert(self._pair_key, place, key)
        self._pair_value = np.insert(self._pair_value, place, value, axis=0)


def _found(wanted: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Mask of the numbers that are among those known, which ascend."""
    if not len(known):
        return np.zeros(len(wanted), dtype=bool)
    found: np.ndarray = known[np.searchsorted(known, wanted).clip(max=len(known) - 1)] == wanted
    return found
