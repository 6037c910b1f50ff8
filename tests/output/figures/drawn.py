"""Figures as plotly's own classes understand them."""

from __future__ import annotations

from collections.abc import Callable

from plotly.graph_objects import Figure as Drawn

from blockstab.output.figures.figure import Figure
from blockstab.parsing.parsed import Parsed


def checked(figure: Callable[[Parsed], Figure]) -> Callable[[Parsed], Drawn]:
    """The same figure, every value of which plotly has checked."""
    return lambda parsed: Drawn(figure(parsed))
