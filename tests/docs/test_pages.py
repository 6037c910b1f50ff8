"""What the pages point at is there, and the pages build."""

from __future__ import annotations

import re
from importlib import util

import pytest

from tests.docs.pages import DOCS, PAGES, ROOT

PLACES = ("blockstab", "models", "configs", "tests", "docs", "benchmarks", "train.py", "evaluate.py")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_file_named_on_a_page_exists(page):
    for name in re.findall(r"`([\w./]+)`", page.read_text()):
        if name.split("/")[0] in PLACES and ("/" in name or name.endswith(".py")):
            assert (ROOT / name).exists(), f"{page.name} names {name}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_between_pages_leads_somewhere(page):
    for target in re.findall(
        r"\]\((?!http)([^)#]+)[^)]*\)|^```\{image\} (\S+)", page.read_text(), re.MULTILINE
    ):
        assert (page.parent / "".join(target)).exists(), f"{page.name} links to {target}"


def test_the_drawing_is_the_one_that_its_script_makes():
    script = DOCS / "figures" / "pipeline.py"
    spec = util.spec_from_file_location("pipeline", script)
    assert spec is not None
    assert spec.loader is not None
    module = util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert module.TARGET.read_text() == module.drawing()
    for stage in module.STAGES:
        for file in stage.file.split(", "):
            assert (ROOT / "blockstab" / file).exists() or (ROOT / file).exists(), f"the drawing names {file}"


@pytest.mark.filterwarnings("ignore")  # what Sphinx's own extensions use of it is going out of use
def test_the_pages_build_without_a_warning(tmp_path, capfd):
    build = pytest.importorskip(
        "sphinx.cmd.build", reason="Sphinx, furo and myst-parser are in the extra `docs`"
    )
    places = ["-d", str(tmp_path / "doctrees"), str(DOCS), str(tmp_path / "html")]
    status = build.build_main(["-W", "--keep-going", "-q", "-b", "html", *places])
    assert status == 0, capfd.readouterr().err
