"""docs/commands.md tells the options, keys, formats and messages there are; what any page runs is accepted."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import click
import jsonschema
import numpy as np
import pytest
import torch
import typer
from PIL import Image

from blockstab.cli import app
from blockstab.commands.parse import folder_job
from blockstab.evaluation.scoring import SCORES
from blockstab.observation import given_ground
from blockstab.output.batch import parse_all
from blockstab.output.export import scene_schema
from blockstab.parsing.parser import Parser
from blockstab.proposals.files import LabelFile
from blockstab.proposals.watershed import Watershed
from blockstab.rgbd.frame import read_scene
from blockstab.search.moves.every import EVERY
from blockstab.search.none import NoSearch
from blockstab.simulation.layouts.presets import PRESETS
from blockstab.testing.photographs import BLOCKS, photograph
from models.potentials.checkpoint import chosen_columns, load_potentials, save_potentials
from models.potentials.examples import ExampleMaker
from tests.docs.pages import DOCS, PAGES, ROOT, blocks, commands, composed
from tests.synthetic import write_folder
from tests.toy_potentials import kinds_of, toy_potentials

PAGE = DOCS / "commands.md"
SECTIONS = dict(re.findall(r"^## (.*?)\n(.*?)(?=^## |\Z)", PAGE.read_text(), re.MULTILINE | re.DOTALL))


def first_column(section: str, head: str) -> set[str]:
    """The code in the first column of the table of a section whose first heading is `head`."""
    table = SECTIONS[section].split(f"| {head} |")[1].split("\n\n")[0]
    cells = [line.split("|")[1] for line in table.splitlines()[2:]]
    return {word for cell in cells for word in re.findall(r"`(.*?)`", cell)}


def command(name: str) -> click.Command:
    return typer.main.get_command(app).commands[name]


@pytest.mark.parametrize("name", ["parse", "simulate", "judge"])
def test_the_page_names_every_option_of_a_command(name):
    options = {word for parameter in command(name).params for word in parameter.opts if word.startswith("--")}
    assert first_column(f"blockstab {name}", "option") == options - {"--help"}


def test_the_page_names_every_choice_of_a_part_of_a_parse():
    for group in ("ground", "edges", "proposals", "rules", "judge", "search", "energy", "pool"):
        for file in (ROOT / "configs" / group).glob("*.yaml"):
            assert f"`{file.stem}`" in SECTIONS["blockstab parse"], file
    assert all(f"`{preset}`" in SECTIONS["blockstab simulate"] for preset in PRESETS)


def test_the_page_names_every_key_of_a_program():
    assert first_column("blockstab parse", "key") == set(composed("parse", []))
    assert first_column("evaluate.py", "key") == set(composed("evaluate", ["data=simulated"])) - {"hydra"}
    keys = {
        task: set(composed("train", [f"task={task}"])) - {"hydra"}
        for task in ("potentials", "stages", "boundary")
    }
    assert first_column("train.py", "key") == keys["boundary"]
    assert first_column("train.py", "key of potentials") == keys["potentials"] - keys["boundary"]
    assert keys["stages"] - keys["boundary"] == {"edges", "variant"}


def test_the_page_names_every_score_and_every_experiment():
    assert first_column("evaluate.py", "score") == set(SCORES)
    experiments = {file.stem for file in (ROOT / "configs" / "experiment").glob("*.yaml")}
    assert experiments <= set(re.findall(r"`(\w+)`", SECTIONS["evaluate.py"]))


def test_the_scene_json_of_the_page_follows_the_schema_and_lacks_nothing():
    (text,) = blocks(PAGE, "json")
    record, schema = json.loads(text), scene_schema()
    jsonschema.validate(record, schema)
    assert list(record) == list(schema["properties"])


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_command_of_a_page_is_accepted(page):
    for name in ("parse", "simulate", "judge"):
        for words in commands(page, f"blockstab {name}"):
            command(name).make_context(name, words)
    for program in ("train", "evaluate"):
        for words in commands(page, f"python {program}.py"):
            if "--config-dir" not in words:  # see test_extend.py
                composed(program, words)


@pytest.fixture
def scene(tmp_path) -> Path:
    return write_folder(photograph(*BLOCKS).frame, tmp_path / "scene")


def meta(**changes: object) -> Callable[[Path], object]:
    """Read the scene with other values in its meta.json; None takes one away."""

    def read(folder: Path) -> object:
        values = {**json.loads((folder / "meta.json").read_text()), **changes}
        (folder / "meta.json").write_text(json.dumps({k: v for k, v in values.items() if v is not None}))
        return read_scene(folder)

    return read


def image(name: str, pixels: np.ndarray) -> Callable[[Path], object]:
    """Read the scene with another image in it."""

    def read(folder: Path) -> object:
        Image.fromarray(pixels).save(folder / name)
        return read_scene(folder)

    return read


def file(name: str, change: Callable[[bytes], bytes]) -> Callable[[Path], object]:
    """Read the scene with the bytes of a file changed."""

    def read(folder: Path) -> object:
        (folder / name).write_bytes(change((folder / name).read_bytes()))
        return read_scene(folder)

    return read


def huge(png: bytes) -> bytes:
    """The same PNG, said by its header to be a million pixels wide."""
    return png[:16] + (1_000_000).to_bytes(4, "big") + png[20:]


def without_file(folder: Path) -> None:
    (folder / "depth.png").unlink()
    read_scene(folder)


def parsed(folder: Path, **settings: object) -> None:
    parser = Parser(settings.pop("proposal", Watershed()), NoSearch(), toy_potentials(), **settings)
    parser(read_scene(folder))


def without_labels(folder: Path) -> None:
    (folder / "label.png").unlink()
    parsed(folder, proposal=LabelFile())


def without_up(folder: Path) -> None:
    meta(up_camera=None)(folder)
    parsed(folder, ground_of=given_ground)


def twice(folder: Path) -> None:
    parser = Parser(LabelFile(), NoSearch(), toy_potentials())
    parse_all([folder_job(folder), folder_job(folder)], parser, folder.parent / "out")


def saved(stem: Path) -> Path:
    save_potentials(stem, kinds_of(toy_potentials()), 0.1, {})
    return stem.with_suffix(".json")


def mixed(folder: Path) -> None:
    saved(folder / "mine").with_suffix(".safetensors").write_bytes(b"another")
    load_potentials(folder / "mine.json")


def unlabelled(folder: Path) -> None:
    (folder / "label.png").unlink()
    ExampleMaker((Watershed(),), EVERY)(read_scene(folder), torch.Generator())


REFUSALS: dict[str, Callable[[Path], object]] = {
    "must be a readable file": without_file,
    "must be a whole image": file("color.png", lambda png: png[: len(png) // 2]),
    "must be a PNG of one channel of 16 bits, depth in whole millimetres": image(
        "depth.png", np.full((144, 192), 200, np.uint8)
    ),
    "must be a PNG or JPEG of 8 bits a channel": image("color.png", np.full((144, 192), 200, np.uint16)),
    "register the images to one camera": image("color.png", np.zeros((10, 10, 3), np.uint8)),
    "must have at most 64 megapixels": file("depth.png", huge),
    "holds 0 valid pixels": image("depth.png", np.zeros((144, 192), np.uint16)),
    "the median depth must be between 0.1 and 20 m": image("depth.png", np.full((144, 192), 1, np.uint16)),
    "depth_unit must be mm or 0.1mm": meta(depth_unit="inch"),
    "depth_noise must be one of": meta(depth_noise="loud"),
    "must lie inside the image": meta(cx=400.0),
    "must be a positive number of pixels": meta(fx=0.0),
    "must be JSON": file("meta.json", lambda text: text[:-1]),
    "has no label.png": without_labels,
    "in its meta.json; let it be estimated": without_up,
    "Each scene needs a name of its own": twice,
    "may be a pickle, which can run code when read": lambda _: load_potentials("mine.ckpt"),
    "copy both files of one training run": mixed,
    "train it anew with this version": lambda _: chosen_columns(toy_potentials().unary, ("volume",)),
    "training needs the true segments": unlabelled,
}


@pytest.mark.parametrize("message", REFUSALS)
def test_what_the_page_calls_refused_is_refused_in_these_words(message, scene):
    with pytest.raises(ValueError, match=re.escape(message)):
        REFUSALS[message](scene)


def test_every_message_of_the_page_is_tried():
    lines = SECTIONS["What is refused"].split("|---|---|\n")[1].splitlines()
    assert {line.split("|")[2].strip().strip("`") for line in lines if line} == set(REFUSALS)
