"""Regions that hang together in the image."""

from __future__ import annotations

import numpy as np
import torch
from scipy import ndimage

from blockstab.segments.pieces import connected_pieces, without_small_pieces


def test_pieces_that_meet_at_a_corner_are_two() -> None:
    label = torch.tensor([[7, 0, 7], [0, 7, 7], [2, 2, 7]])
    assert connected_pieces(label).tolist() == [[1, 0, 2], [0, 2, 2], [3, 3, 2]]


def test_pieces_agree_with_scipy(generator: torch.Generator) -> None:
    label = torch.randint(0, 4, (30, 40), generator=generator)
    pieces = connected_pieces(label)
    for value in range(1, 4):
        own, count = ndimage.label(label.numpy() == value)
        assert len(np.unique(pieces.numpy()[own > 0])) == count
        assert len(np.unique(np.stack([own, pieces.numpy()])[:, own > 0], axis=1).T) == count


def test_small_pieces_lose_their_label() -> None:
    label = torch.tensor([[5, 5, 5, 0, 5], [0, 3, 0, 0, 5]])
    assert without_small_pieces(label, 3).tolist() == [[5, 5, 5, 0, 0], [0, 0, 0, 0, 0]]
    assert torch.equal(without_small_pieces(label, 1), label)


def test_no_label_is_no_piece_however_large() -> None:
    assert not connected_pieces(torch.zeros(4, 4, dtype=torch.int64)).any()
