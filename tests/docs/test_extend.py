"""The code and the configurations of docs/extend.md do what the page says."""

from __future__ import annotations

import re
import sys
from functools import partial
from pathlib import Path

import pytest
import torch
from hydra import compose, initialize_config_dir
from hydra.utils import instantiate

from blockstab.parser import Parser
from models.heads import HEADS
from tests.block_scene import STACK, picture
from tests.synthetic import BLOCKS, photograph, write_folder

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "extend.md").read_text()
BLOCK = re.compile(r"^```(python|yaml)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FILE = re.compile(r"# (mine/\S+)\n")


@pytest.fixture(autouse=True)
def heads(monkeypatch):
    """A head that the page names is forgotten afterwards."""
    monkeypatch.setattr("models.heads.HEADS", HEADS)
    before = dict(HEADS)
    yield
    HEADS.clear()
    HEADS.update(before)


@pytest.fixture
def workplace(tmp_path, monkeypatch) -> Path:
    """A folder with the scene that the page reads and the files that it tells to write."""
    write_folder(photograph(*BLOCKS).frame, tmp_path / "my_scene")
    for _, text in BLOCK.findall(PAGE):
        if named := FILE.match(text):
            target = tmp_path / named[1]
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(text)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    yield tmp_path
    for module in [name for name in sys.modules if name.split(".")[0] == "mine"]:
        del sys.modules[module]


def run_page() -> dict[str, object]:
    """All Python of the page, in one namespace."""
    names: dict[str, object] = {"__name__": "extend"}
    code = "\n".join(text for language, text in BLOCK.findall(PAGE) if language == "python")
    torch.set_num_threads(1)
    exec(compile(code, "docs/extend.md", "exec"), names)
    return names


def test_the_code_of_the_page_runs(workplace, monkeypatch):
    monkeypatch.setitem(sys.modules, "extend", type(sys)("extend"))
    names = run_page()
    assert names["parsed"].energy == names["parsed"].trace[-1]
    assert names["unary"].badness(names["rows"].features).shape == names["rows"].target.shape


def composed(workplace: Path, config: str, *overrides: str):
    searchpath = f"hydra.searchpath=[file://{workplace / 'mine'}]"
    with initialize_config_dir(str(ROOT / "configs"), version_base="1.3"):
        return compose(config, [searchpath, *overrides])
