"""What the figures of searches share: the parser whose search is shown, and sheets of panels."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import torch
from hydra import compose, initialize_config_dir
from PIL import Image, ImageDraw, ImageFont
from torch import Tensor

sys.path.insert(0, str(Path(__file__).parents[2]))

from blockstab.parsing.parser import Parser
from blockstab.rgbd.frame import Frame
from evaluate import methods_of

CONFIGS = str(Path(__file__).resolve().parents[2] / "configs")
GAP, LINE = 8, 17  # pixels between panels, and of a line of a caption
AROUND = 0.12  # of the size of all objects together, that is shown around them
GREY = (150, 150, 150)  # what is background


class Panel(NamedTuple):
    """A picture (H, W, 3) uint8, and what stands beneath it, a line or several."""

    picture: Tensor
    caption: str


def searching_parser(potentials: str, seed: int = 0) -> Parser:
    """The parser of the row R-Samp of `evaluate.py experiment=segments`."""
    with initialize_config_dir(CONFIGS, version_base="1.3"):
        cfg = compose("evaluate", ["experiment=segments", f"potentials={potentials}", f"seed={seed}"])
    return methods_of(cfg)["R-Samp"].parser


def close_up(frame: Frame) -> tuple[slice, slice]:
    """The rows and columns that the true objects lie in, and a little more."""
    assert frame.label is not None, f"{frame.name} has no label.png, which tells where its objects are"
    background = torch.tensor([0, *frame.background_ids])
    places = (~torch.isin(frame.label, background)).nonzero()
    low, high = places.amin(dim=0), places.amax(dim=0) + 1
    room = (AROUND * (high - low)).round().long()
    rows, columns = zip((low - room).clamp(min=0).tolist(), (high + room).tolist(), strict=True)
    return slice(*rows), slice(*columns)


def sheet(rows: Sequence[Sequence[Panel]], width: int) -> Image.Image:
    """All panels, each scaled to `width` pixels, with their captions."""
    return _stacked([_row(row, width) for row in rows])


def _row(panels: Sequence[Panel], width: int) -> Image.Image:
    images = [_captioned(panel, width) for panel in panels]
    whole = Image.new("RGB", (len(images) * (width + GAP) - GAP, max(i.height for i in images)), "white")
    for k, image in enumerate(images):
        whole.paste(image, (k * (width + GAP), 0))
    return whole


def _captioned(panel: Panel, width: int) -> Image.Image:
    picture = Image.fromarray(panel.picture.contiguous().to(torch.uint8).numpy())
    height = round(picture.height * width / picture.width)
    lines = panel.caption.splitlines()
    whole = Image.new("RGB", (width, height + LINE * len(lines) + (4 if lines else 0)), "white")
    whole.paste(picture.resize((width, height), Image.Resampling.LANCZOS), (0, 0))
    draw, font = ImageDraw.Draw(whole), ImageFont.load_default(13)
    for k, line in enumerate(lines):
        draw.text((width / 2, height + 2 + LINE * k), line, fill="#222", font=font, anchor="ma")
    return whole


def _stacked(images: Sequence[Image.Image]) -> Image.Image:
    whole = Image.new(
        "RGB", (max(i.width for i in images), sum(i.height + GAP for i in images) - GAP), "white"
    )
    top = 0
    for image in images:
        whole.paste(image, (0, top))
        top += image.height + GAP
    return whole
