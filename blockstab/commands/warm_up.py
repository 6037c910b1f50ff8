"""Machine code made ahead of its first use: `make setup` parses a small image."""

from __future__ import annotations

from blockstab.parsing.parsed import Parsed
from blockstab.testing.photographs import BLOCKS, photograph
from models.configured import composed, parser_maker


def warm_up() -> Parsed:
    """Parse blocks on a table as `blockstab parse` would, so that the machine code is on disk when it is wanted."""
    cfg = composed("parse", [], {})
    return parser_maker(cfg)(cfg)(photograph(*BLOCKS).frame)
