"""Runs of consecutive numbers."""

from __future__ import annotations

import torch

from blockstab.segments.runs import spans


def test_spans_follow_one_another_and_may_be_empty():
    numbers, span = spans(torch.tensor([5, 9, 0, 5]), torch.tensor([2, 0, 3, 1]))
    assert numbers.tolist() == [5, 6, 0, 1, 2, 5]
    assert span.tolist() == [0, 0, 2, 2, 2, 3]


def test_no_span_has_no_number():
    numbers, span = spans(torch.empty(0, dtype=torch.int64), torch.empty(0, dtype=torch.int64))
    assert len(numbers) == len(span) == 0
