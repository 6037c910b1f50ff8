"""All kinds of moves that come with the package, as a search has them unless it is told otherwise."""

from __future__ import annotations

from blockstab.search.moves import Move
from blockstab.search.moves.carve import Carve
from blockstab.search.moves.cut import Cut, Transfer
from blockstab.search.moves.join import Join
from blockstab.search.moves.merge import Merge
from blockstab.search.moves.split import Split
from blockstab.search.moves.turn import Turn
from blockstab.search.moves.unexplained import Unexplained

EVERY: tuple[Move, ...] = (
    Split(),
    Merge(),
    Join(),
    Cut(),
    Transfer(),
    Carve(),
    Unexplained(),
    Turn(),
)
