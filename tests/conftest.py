"""Fixtures shared by all tests."""

from __future__ import annotations

from pathlib import Path

import pytest
import torch

REAL = Path(__file__).resolve().parents[2] / "shared" / "data"


@pytest.fixture
def generator() -> torch.Generator:
    return torch.Generator().manual_seed(7)


@pytest.fixture(scope="session")
def real_scenes() -> Path:
    """The folder of real RGB-D scenes, which is no part of the repository."""
    if not REAL.is_dir():
        pytest.skip(f"the real scenes are not at {REAL}")
    return REAL
