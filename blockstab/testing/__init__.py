"""Contracts of plug-ins, as classes of tests: inherit one, name your part, and let pytest run it.

from blockstab.testing import MoveContract

class TestSwallow(MoveContract):
    part = Swallow()
"""

from blockstab.testing.columns import ColumnsContract
from blockstab.testing.data import SceneSetContract, SensorContract
from blockstab.testing.judges import JudgeContract
from blockstab.testing.proposals import ProposalContract
from blockstab.testing.searches import EnergyContract, MoveContract, SearchContract

__all__ = [
    "ColumnsContract",
    "EnergyContract",
    "JudgeContract",
    "MoveContract",
    "ProposalContract",
    "SceneSetContract",
    "SearchContract",
    "SensorContract",
]
