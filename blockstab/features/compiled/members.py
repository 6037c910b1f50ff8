"""Sums and maxima over the atoms of segments, and over the atoms around them, in machine code."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np
from numba import njit

from blockstab.determinism.machine_code import fingerprint_of
from blockstab.segments.atoms import Atoms


class Members(NamedTuple):
    """The atoms of S segments, one segment after the other."""

    atom: np.ndarray  # (M,) ascending within a segment, so that sums come out alike however it came about
    start: np.ndarray  # (S + 1,) where the atoms of each begin


class Borders(NamedTuple):
    """The E borders between A atoms, by the atoms that they lie at."""

    first: np.ndarray  # (E,) atoms
    second: np.ndarray  # (E,)
    pixels: np.ndarray  # (E,) float64
    at: np.ndarray  # (2 E,) borders, atom after atom
    start: np.ndarray  # (A + 1,) where those of each begin


def members_of(segments: Sequence[frozenset[int]]) -> Members:
    """The atoms of segments as machine code takes them."""
    size = np.fromiter(map(len, segments), dtype=np.int64, count=len(segments))
    atom = np.fromiter(chain.from_iterable(segments), dtype=np.int64, count=int(size.sum()))
    owner = np.arange(len(segments)).repeat(size)
    return Members(atom[np.lexsort((atom, owner))], np.concatenate([[0], size.cumsum()]))


def borders_of(atoms: Atoms) -> Borders:
    """The borders of atoms as machine code takes them."""
    first, second = atoms.first.numpy(), atoms.second.numpy()
    ends = np.concatenate([first, second])
    start = np.concatenate([[0], np.bincount(ends, minlength=len(atoms)).cumsum()])
    at = ends.argsort(kind="stable") % max(len(first), 1)
    return Borders(first, second, atoms.border_px.double().numpy(), at, start)


@njit(error_model="numpy")
def borders_at(members, borders, s, inside, outline, interior):
    """Write the borders of segment s along its outline, and inside; how many of either.

    Args:
        inside: (A,) the last segment that each atom was found in; outline, interior: (2 E,).
    """
    along, within = 0, 0
    for m in range(members.start[s], members.start[s + 1]):
        inside[members.atom[m]] = s
    for m in range(members.start[s], members.start[s + 1]):
        atom = members.atom[m]
        for place in range(borders.start[atom], borders.start[atom + 1]):
            border = borders.at[place]
            first = borders.first[border] == atom
            if inside[borders.second[border] if first else borders.first[border]] != s:
                outline[along] = border
                along += 1
            elif first:
                interior[within] = border
                within += 1
    return along, within


def _kept_while(fingerprint):
    """The functions below; their machine code is made again when the fingerprint is another."""

    @njit(cache=True, error_model="numpy")
    def sums(members, values):
        """(S, K) sums of values (A, K) over the atoms of each segment."""
        _ = fingerprint
        count, width = len(members.start) - 1, values.shape[1]
        found = np.zeros((count, width))
        for s in range(count):
            for m in range(members.start[s], members.start[s + 1]):
                for k in range(width):
                    found[s, k] += values[members.atom[m], k]
        return found

    @njit(cache=True, error_model="numpy")
    def maxima(members, values):
        """(S, K) greatest of values (A, K) over the atoms of each segment; -inf where it has none."""
        _ = fingerprint
        count, width = len(members.start) - 1, values.shape[1]
        found = np.full((count, width), -np.inf)
        for s in range(count):
            for m in range(members.start[s], members.start[s + 1]):
                for k in range(width):
                    found[s, k] = max(found[s, k], values[members.atom[m], k])
        return found

    @njit(cache=True, error_model="numpy")
    def around(members, borders, values):
        """(S, K) means of values (A, K) over the atoms around each segment, by length of border; 0 without any.

        And that length, (S,).
        """
        _ = fingerprint
        count, width = len(members.start) - 1, values.shape[1]
        found, length = np.zeros((count, width)), np.zeros(count)
        inside = np.full(len(values), -1)
        outline, interior = np.empty(len(borders.at), np.int64), np.empty(len(borders.at), np.int64)
        for s in range(count):
            along, _ = borders_at(members, borders, s, inside, outline, interior)
            for border in outline[:along]:
                first, second = borders.first[border], borders.second[border]
                beyond = second if inside[first] == s else first
                length[s] += borders.pixels[border]
                for k in range(width):
                    found[s, k] += borders.pixels[border] * values[beyond, k]
            for k in range(width):
                found[s, k] /= max(length[s], 1.0)
        return found, length

    return sums, maxima, around


sums, maxima, around = _kept_while(fingerprint_of("features"))
