"""The pages, and what they tell to run."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

from omegaconf import DictConfig

from models import configured

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES = sorted([ROOT / "README.md", *DOCS.glob("*.md")])

_BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def blocks(page: Path, language: str) -> list[str]:
    """The fenced blocks of a page in one language, in order."""
    return [text for found, text in _BLOCK.findall(page.read_text()) if found == language]


def commands(page: Path, program: str) -> list[list[str]]:
    """The words that follow `program` in each line of a page that runs it, less the comment."""
    lines = re.findall(rf"^    {re.escape(program)}\b(.*)$", page.read_text(), re.MULTILINE)
    return [shlex.split(line.split("  #")[0]) for line in lines]


def composed(config: str, overrides: list[str], more: Path | None = None) -> DictConfig:
    """What hydra makes of a command line; `more` is the folder that --config-dir names."""
    return configured.composed(config, overrides, {}, more)
