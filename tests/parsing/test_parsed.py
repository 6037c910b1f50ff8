"""What one parse must agree on."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from tests.table_scene import parsed_table


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("ids", (1, 2, 3)),
        ("ids", (1, 2, 3, 3)),
        ("ids", (0, 1, 2, 3)),
        ("unary", torch.zeros(3)),
        ("badness", torch.zeros(5)),
        ("pairwise", torch.zeros(6)),  # of all pairs, not of the neighbours
        ("label", torch.zeros(4, 4, dtype=torch.int64)),
    ],
)
def test_a_parse_whose_parts_disagree_is_refused(field: str, value: object) -> None:
    with pytest.raises(ValueError, match="table: "):
        replace(parsed_table(), **{field: value})
