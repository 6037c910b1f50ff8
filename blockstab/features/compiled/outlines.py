"""The outline and the inside of segments of atoms, in machine code; see `features.contour`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from blockstab.determinism.machine_code import fingerprint_of
from blockstab.features.compiled.members import borders_at


class Graph(NamedTuple):
    """What is known of the E borders between A atoms, beside `Borders`."""

    strength: np.ndarray  # (E,)
    rank: np.ndarray  # (E,) place of each by its strength
    at_rank: np.ndarray  # (E,) the border at each place
    joined_at: np.ndarray  # (E,) height at which the hierarchy joins its two atoms
    cues: np.ndarray  # (E, K) sums along each border
    front: np.ndarray  # (E, 2) pixels along which the first atom lies before the second, and behind it


class Outlines(NamedTuple):
    """Measurements of S segments: along their outlines, and along the borders of atoms inside."""

    length: np.ndarray  # (S,) pixels to other atoms
    within: np.ndarray  # (S,) pixels between atoms inside
    weak: np.ndarray  # (S,) pixels of the outline that are weaker than a limit
    before: np.ndarray  # (S,) pixels of the outline before what is beside it
    behind: np.ndarray  # (S,)
    quantiles: np.ndarray  # (S, Q) of the strength along the outline
    outline: np.ndarray  # (S, K) sums of cues
    interior: np.ndarray  # (S, K)
    weakest_atom: np.ndarray  # (S,) least mean strength to one atom outside
    joins_at: np.ndarray  # (S,)
    greatest: np.ndarray  # (S,) strength inside
    saddle: np.ndarray  # (S,) the strongest border on the easiest way through
    pieces: np.ndarray  # (S,) parts that do not touch


@njit(error_model="numpy")
def _along(s, outline, members, borders, graph, inside, weak_below, found):
    """Sums along the outline."""
    for border in outline:
        pixels, strength = borders.pixels[border], graph.strength[border]
        found.length[s] += pixels
        found.weak[s] += pixels if strength < weak_below else 0.0
        held = 0 if inside[borders.first[border]] == s else 1
        found.before[s] += graph.front[border, held]
        found.behind[s] += graph.front[border, 1 - held]
        found.joins_at[s] = min(found.joins_at[s], graph.joined_at[border])
        for k in range(graph.cues.shape[1]):
            found.outline[s, k] += graph.cues[border, k]


@njit(error_model="numpy")
def _quantiles(s, outline, borders, graph, shares, found):
    """Of the strength along the outline, by length."""
    rank = np.empty(len(outline), dtype=np.int64)
    for i in range(len(outline)):
        rank[i] = graph.rank[outline[i]]
    rank.sort()
    for q in range(len(shares)):
        goal, passed = max(found.length[s] * shares[q], 1e-9), 0.0
        for place in rank:
            border = graph.at_rank[place]
            passed += borders.pixels[border]
            if passed >= goal:
                found.quantiles[s, q] = graph.strength[border]
                break


@njit(error_model="numpy")
def _weakest(s, outline, borders, graph, inside, length, total, found):
    """The least mean strength of the border to one atom outside; `length` and `total` (A,) are left at zero."""
    for border in outline:
        beyond = borders.second[border] if inside[borders.first[border]] == s else borders.first[border]
        length[beyond] += borders.pixels[border]
        total[beyond] += borders.pixels[border] * graph.strength[border]
    for border in outline:
        beyond = borders.second[border] if inside[borders.first[border]] == s else borders.first[border]
        if length[beyond] > 0:
            found.weakest_atom[s] = min(found.weakest_atom[s], total[beyond] / length[beyond])
    for border in outline:
        for atom in (borders.first[border], borders.second[border]):
            length[atom], total[atom] = 0.0, 0.0


@njit(error_model="numpy")
def _inside(s, interior, members, borders, graph, parent, found):
    """Sums over the borders inside, and the tree of the weakest of them (Kruskal 1956)."""
    rank = np.empty(len(interior), dtype=np.int64)
    for i in range(len(interior)):
        border = interior[i]
        rank[i] = graph.rank[border]
        found.within[s] += borders.pixels[border]
        for k in range(graph.cues.shape[1]):
            found.interior[s, k] += graph.cues[border, k]
    rank.sort()
    for m in range(members.start[s], members.start[s + 1]):
        parent[members.atom[m]] = members.atom[m]
    found.pieces[s] = members.start[s + 1] - members.start[s]
    for place in rank:
        border = graph.at_rank[place]
        found.greatest[s] = graph.strength[border]
        one, other = _root(parent, borders.first[border]), _root(parent, borders.second[border])
        if one != other:
            parent[other] = one
            found.saddle[s] = graph.strength[border]
            found.pieces[s] -= 1


@njit(error_model="numpy")
def _root(parent, atom):
    while parent[atom] != atom:
        parent[atom] = parent[parent[atom]]
        atom = parent[atom]
    return atom


def _kept_while(fingerprint):
    """The function below; its machine code is made again when the fingerprint is another."""

    @njit(cache=True, error_model="numpy")
    def outlines(members, borders, graph, weak_below, shares):
        """Measure S segments; `shares` (Q,) are those of the quantiles."""
        _ = fingerprint
        count, atoms, cues = len(members.start) - 1, len(borders.start) - 1, graph.cues.shape[1]
        found = Outlines(
            np.zeros(count),
            np.zeros(count),
            np.zeros(count),
            np.zeros(count),
            np.zeros(count),
            np.ones((count, len(shares))),
            np.zeros((count, cues)),
            np.zeros((count, cues)),
            np.ones(count),
            np.ones(count),
            np.zeros(count),
            np.zeros(count),
            np.zeros(count, dtype=np.int64),
        )
        inside, parent = np.full(atoms, -1), np.empty(atoms, dtype=np.int64)
        outline, interior = np.empty(len(borders.at), np.int64), np.empty(len(borders.at), np.int64)
        length, total = np.zeros(atoms), np.zeros(atoms)
        for s in range(count):
            along, within = borders_at(members, borders, s, inside, outline, interior)
            _along(s, outline[:along], members, borders, graph, inside, weak_below, found)
            _quantiles(s, outline[:along], borders, graph, shares, found)
            _weakest(s, outline[:along], borders, graph, inside, length, total, found)
            _inside(s, interior[:within], members, borders, graph, parent, found)
        return found

    return outlines


outlines = _kept_while(fingerprint_of("features"))
