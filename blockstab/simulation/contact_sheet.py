"""All scenes of a set in one image, to look at."""

from __future__ import annotations

import math
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

import torch
from PIL import Image, ImageDraw
from torch import Tensor

from blockstab.output.coloring import depth_colored, depth_range
from blockstab.output.export import write_whole
from blockstab.rgbd.frame import Frame, read_scene

MOST = 64  # scenes on a sheet; of more, as many are taken at even steps
_WIDTH, _NAME, _GAP = 240, 14, 6  # pixels: of a thumbnail, of the line below it, between two


def contact_sheet(folders: Sequence[Path], out: Path) -> None:
    """Write one PNG of thumbnails: colour, beside it labels above depth, the scene's name below.

    It appears whole or not at all. Of more than `MOST` scenes, that many are shown, evenly chosen.

    Args:
        folders: scene folders, one or more.

    Raises:
        ValueError: there is no scene.
        FrameError: a folder holds no readable scene.
    """
    if not folders:
        raise ValueError("A contact sheet needs one scene folder or more, but got none.")
    shown = [folders[i * len(folders) // min(len(folders), MOST)] for i in range(min(len(folders), MOST))]
    thumbnails = [_thumbnail(read_scene(folder)) for folder in shown]
    columns = math.ceil(math.sqrt(len(thumbnails)))
    wide, high = (max(image.size[k] for image in thumbnails) + _GAP for k in (0, 1))
    sheet = Image.new("RGB", (columns * wide + _GAP, math.ceil(len(shown) / columns) * high + _GAP), "white")
    for i, image in enumerate(thumbnails):
        sheet.paste(image, (_GAP + i % columns * wide, _GAP + i // columns * high))
    buffer = BytesIO()
    sheet.save(buffer, format="PNG")
    write_whole(out, buffer.getvalue())


def _thumbnail(frame: Frame) -> Image.Image:
    height = round(_WIDTH * frame.color.shape[0] / frame.color.shape[1])
    half = (_WIDTH // 2, height // 2)
    image = Image.new("RGB", (_WIDTH + half[0], height + _NAME), "white")
    image.paste(Image.fromarray(frame.color.numpy()).resize((_WIDTH, height), Image.Resampling.BOX), (0, 0))
    # Every so many pixels are enough: labels and depths must not be mixed.
    rows, columns = (
        torch.linspace(0, length - 1, count).round().long()
        for length, count in zip(frame.depth.shape, half[::-1], strict=True)
    )
    depth = frame.depth[rows][:, columns]
    colored = depth_colored(depth, *depth_range(depth))
    for row, strip in enumerate((_labels(frame)[rows][:, columns], colored)):
        image.paste(Image.fromarray(strip.numpy()), (_WIDTH, row * half[1]))
    ImageDraw.Draw(image).text((2, height + 1), frame.name, "black")
    return image


def _labels(frame: Frame) -> Tensor:
    """Objects (H, W, 3) in colours of their own, background in greys, nothing black."""
    if frame.label is None:
        return torch.zeros_like(frame.color)
    ids = torch.arange(int(frame.label.max()) + 1)
    # Steps by the golden ratio keep the hues of neighbouring ids apart.
    hue = 2 * math.pi * (0.618034 * ids[:, None] + torch.tensor([0.0, 1 / 3, 2 / 3]))
    palette = 150.0 + 90.0 * hue.cos()
    behind = [i for i in frame.background_ids if i < len(ids)]
    palette[behind] = (50.0 + 25.0 * torch.arange(len(behind)) % 100)[:, None].expand(-1, 3)
    palette[0] = 0.0
    return palette.round().to(torch.uint8)[frame.label]
