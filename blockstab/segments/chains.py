"""Pieces of line put together, end to end."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import torch
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from torch import Tensor


class Chains(NamedTuple):
    """For each of K pieces, its place in a chain.

    Args:
        chain: (K,) int64, the same number for all pieces of a chain; numbers have gaps.
        left: (K,) int64, how many pieces come after it.
        forward: (K,) bool, whether the chain enters it by its end 0.
    """

    chain: Tensor
    left: Tensor
    forward: Tensor


def chained(node: Tensor, through: Tensor) -> Chains:
    """Order pieces along the chains that they form.

    A chain starts at the open end of the piece of least index; a closed one at end 0 of its least piece.

    Args:
        node: (K, 2) int64, the node at either end of each piece.
        through: (K, 2) bool, the ends that are joined to another: exactly two at each of their nodes.
    """
    joined = through.flatten().nonzero()[:, 0]
    joined = joined[node.flatten()[joined].argsort(stable=True)].view(-1, 2)
    partner = torch.arange(node.numel())
    partner[joined[:, 0]], partner[joined[:, 1]] = joined[:, 1], joined[:, 0]
    seam = 2 * _closed(len(node), joined // 2)
    partner[partner[seam]] = partner[seam]
    partner[seam] = seam

    # Number 2 k + e stands for passing through piece k and leaving by its end e; `partner` is where one enters next,
    # by an end that one leaves by the other. Each round doubles how far `last` looks ahead.
    here = torch.arange(node.numel())
    last = torch.where(partner == here, here, partner ^ 1)
    left = (last != here).to(torch.int64)
    while not torch.equal(further := last[last], last):
        left, last = left + left[last], further
    last, left = last.view(-1, 2), left.view(-1, 2)
    forward = last[:, 1] > last[:, 0]
    way = forward.to(torch.int64)[:, None]
    return Chains(last.gather(1, way)[:, 0], left.gather(1, way)[:, 0], forward)


def _closed(count: int, joined: Tensor) -> Tensor:
    """The piece of least index of every closed chain, given the (J, 2) pieces that are joined."""
    first, second = joined.numpy().T
    links = coo_array((np.ones(len(joined), dtype=np.int8), (first, second)), (count, count))
    component = connected_components(links, directed=False)[1]
    _, least = np.unique(component, return_index=True)
    closed = np.bincount(component[first], minlength=len(least)) == np.bincount(component)
    return torch.from_numpy(least[closed])
