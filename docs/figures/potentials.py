"""Draw docs/figures/potentials.png (paper, Figure 11): python docs/figures/potentials.py SCENE SCENE ...

A row for each scene folder: the image, a segmentation midway in a search, its boxes coloured by their unary
potential, and its boundaries by their pairwise potential: blue is good, red is bad. Background is grey.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import torch
from PIL import Image, ImageDraw
from torch import Tensor

from sheets import GREY, Panel, close_up, searching_parser, sheet  # isort: skip

from blockstab.energy import Rating
from blockstab.features.pairwise import neighbour_pairs
from blockstab.output.coloring import borders_colored, outlined, quality_colored, tinted
from blockstab.parsing.look import Look
from blockstab.parsing.parser import Parser
from blockstab.rgbd.frame import Frame, read_scene
from blockstab.scene.types import Scene

TARGET = Path(__file__).with_suffix(".png")
WIDTH = 300  # pixels of a panel


def panels(folder: Path, parser: Parser) -> list[Panel]:
    """Image, segmentation, boxes and boundaries of one scene."""
    frame = read_scene(folder)
    problem, found, _ = parser.search_in(Look(frame))
    (rating,) = problem.rate([found.bests[len(found.bests) // 4]])
    label = rating.scene.segmentation.labels(problem.search_input.atoms)
    white = torch.full((len(rating.scene) + 1, 3), 255, dtype=torch.uint8)
    pictures = {
        "image": frame.color,
        "midway in a search": outlined(frame.color, label, white, width_px=1),
        "unary: blue good, red bad": boxes_colored(frame, rating, label),
        "pairwise: blue good, red bad": boundaries_colored(frame, rating, label),
    }
    return [Panel(picture[close_up(frame)], name) for name, picture in pictures.items()]


def boxes_colored(frame: Frame, rating: Rating, label: Tensor) -> Tensor:
    """(H, W, 3) uint8: each segment tinted by its unary potential, and the box of each object drawn around it."""
    scene = rating.scene
    colors = quality_colored(rating.unary.detach())
    colors[scene.background] = torch.tensor(GREY, dtype=torch.uint8)
    palette = torch.cat([colors.new_zeros(1, 3), colors])
    image = Image.fromarray(tinted(frame.color, label, palette, share=0.45).numpy())
    draw = ImageDraw.Draw(image)
    for k in (~scene.background).nonzero()[:, 0].tolist():
        for ends in edges_in_image(frame, scene)[k]:
            draw.line([(float(x), float(y)) for x, y in ends], fill=tuple(colors[k].tolist()), width=3)
    return torch.from_numpy(np.array(image))


def edges_in_image(frame: Frame, scene: Scene) -> Tensor:
    """(N, 12, 2, 2) column and row of both ends of the edges of every box."""
    points = scene.boxes.edges() @ scene.ground.world_from_camera
    camera, depth = frame.camera, points[..., 2].clamp(min=0.05)
    return torch.stack(
        [
            camera.fx * points[..., 0] / depth + camera.cx,
            camera.fy * points[..., 1] / depth + camera.cy,
        ],
        dim=-1,
    )


def boundaries_colored(frame: Frame, rating: Rating, label: Tensor) -> Tensor:
    """(H, W, 3) uint8: the boundaries of the objects over a pale image."""
    scene, count = rating.scene, len(rating.scene) + 1
    palette = torch.tensor(GREY, dtype=torch.uint8).repeat(count, count, 1)
    first, second = (index + 1 for index in neighbour_pairs(scene))
    palette[first, second] = palette[second, first] = quality_colored(rating.pairwise.detach())
    pale = (0.5 * frame.color.double() + 0.5 * 255).round().to(torch.uint8)
    return borders_colored(pale, label, palette)


def main() -> None:
    """Draw, of scene folders."""
    asking = argparse.ArgumentParser(description=__doc__)
    asking.add_argument("scenes", nargs="+", type=Path)
    asking.add_argument("--potentials", default="mlp")
    asking.add_argument("--out", type=Path, default=TARGET)
    asked = asking.parse_args()
    parser = searching_parser(asked.potentials)
    rows = [panels(folder, parser) for folder in asked.scenes]
    sheet(rows, WIDTH).quantize(256).save(asked.out, optimize=True)


if __name__ == "__main__":
    main()
