"""Draw docs/figures/sequence.png (paper, Figure 14): python docs/figures/sequence.py SCENE SCENE ...

A row for each scene folder: the image, the first segmentation, and the best ones after some rounds of a search, each
with its energy and its score beneath.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import torch
from torch import Tensor

from sheets import GREY, Panel, close_up, searching_parser, sheet  # isort: skip

from blockstab.datasets.folder import read_truth
from blockstab.evaluation.scoring.atoms import OverlapOfAtoms
from blockstab.evaluation.scoring.prediction import object_ids
from blockstab.output.coloring import tinted
from blockstab.parsing.look import Look
from blockstab.parsing.parser import Parser
from blockstab.rgbd.frame import read_scene
from blockstab.scene.types import Scene
from blockstab.segments.atoms import Atoms
from blockstab.segments.segmentation import Segmentation

TARGET = Path(__file__).with_suffix(".png")
WIDTH, SHOWN = 240, 4  # pixels of a panel, and segmentations in a row


def panels(folder: Path, parser: Parser) -> list[Panel]:
    """The image, and the best segmentations of one scene."""
    frame = read_scene(folder)
    assert frame.label is not None, f"{folder} has no label.png, by which segmentations are scored"
    problem, found, _ = parser.search_in(Look(frame))
    atoms = problem.search_input.atoms
    score = OverlapOfAtoms(atoms, frame.label, object_ids(frame, read_truth(folder)))
    # Where a search starts from more than one segmentation, its trace begins with the best of them.
    rounds = changes(found.bests, SHOWN - 1)
    ratings = problem.rate([problem.search_input.start, *(found.bests[k] for k in rounds)])
    part = close_up(frame)
    shown = [Panel(frame.color[part], "image")]
    for when, rating in zip(["start", *(f"round {k}" for k in rounds)], ratings, strict=True):
        best = rating.scene.segmentation
        picture = tinted(frame.color, best.labels(atoms), palette(rating.scene, atoms), share=0.65)
        caption = f"{when}: energy {float(rating.energy):.4f}\nscore {100 * score(best):.1f} %"
        shown.append(Panel(picture[part], caption))
    return shown


def changes(bests: tuple[Segmentation, ...], most: int) -> list[int]:
    """Rounds after which the best was another than before, evenly chosen, the last of them among these."""
    new = [k for k, best in enumerate(bests) if k == 0 or best != bests[k - 1]]
    places = torch.linspace(0, len(new) - 1, min(most, len(new))).round().long().unique().tolist()
    return [new[place] for place in places]


def palette(scene: Scene, atoms: Atoms) -> Tensor:
    """(N + 1, 3) uint8: a colour that an object keeps from picture to picture, with its largest atom."""
    colors = torch.randint(40, 256, (len(atoms), 3), generator=torch.Generator().manual_seed(4))
    segments = scene.segmentation.segments
    chosen = colors[[max(sorted(s), key=lambda atom: int(atoms.pixel_count[atom])) for s in segments]]
    chosen[scene.background] = torch.tensor(GREY)
    return torch.cat([colors.new_zeros(1, 3), chosen]).to(torch.uint8)


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
