"""What tests need around photographs of blocks: search inputs, builders, segmentations gone wrong, scene folders."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import torch
from PIL import Image

from blockstab.observation import given_ground, observe
from blockstab.proposals import Proposal
from blockstab.proposals.files import LabelFile
from blockstab.proposals.search_input import SearchInput, make_search_input
from blockstab.rgbd.frame import Frame
from blockstab.scene.builder import SceneBuilder
from blockstab.scene.inference import Rules
from blockstab.segments.hierarchy import build_hierarchy, split
from blockstab.segments.segmentation import Segmentation
from blockstab.testing.photographs import Photograph

LEAST_PX = 40  # of a part


def view_of(photo: Photograph, proposal: Proposal | None = None) -> SearchInput:
    """The photograph made ready, its true labels as the first segmentation."""
    return make_search_input(observe(photo.frame, given_ground), proposal or LabelFile())


def builder(search_input: SearchInput, rules: Rules | None = None) -> SceneBuilder:
    """One that has understood nothing yet."""
    cloud, ground = search_input.observation.cloud, search_input.observation.ground
    return SceneBuilder(cloud, search_input.occlusion, ground, search_input.atoms, rules or Rules())


def over_split(search_input: SearchInput, rounds: int = 1) -> Segmentation:
    """The start with every object split in two, each part again, and so on, but into no specks: of these few points
    fit any box, so they tell nothing about a search."""
    hierarchy, background = build_hierarchy(search_input.atoms), search_input.start.segments[0]
    now = search_input.start
    for _ in range(rounds):
        for segment in now.segments:
            parts = split(segment, search_input.atoms, hierarchy) if segment != background else None
            if (
                parts
                and min(int(search_input.atoms.pixel_count[list(part)].sum()) for part in parts) >= LEAST_PX
            ):
                now = now.replace(now.segments.index(segment), parts)
    return now


def variants(search_input: SearchInput, count: int, seed: int = 0) -> list[Segmentation]:
    """Different segmentations, the start among them, by random splits and merges of objects."""
    generator, hierarchy = torch.Generator().manual_seed(seed), build_hierarchy(search_input.atoms)
    background, found = search_input.start.segments[0], [search_input.start]

    def drawn(below: int) -> int:
        return int(torch.randint(0, below, (1,), generator=generator))

    while len(found) < count:
        child = found[drawn(len(found))]
        pairs = [
            (a, b)
            for a, b in zip(*(side.tolist() for side in child.neighbours(search_input.atoms)), strict=True)
            if background not in (child.segments[a], child.segments[b])
        ]
        if drawn(3) == 0 and pairs:
            child = child.merge(*pairs[drawn(len(pairs))])
        else:
            index = 1 + drawn(len(child) - 1)
            parts = split(child.segments[index], search_input.atoms, hierarchy)
            child = child.replace(index, parts) if parts else child
        found += [child] * (child not in found)
    return found


def write_folder(frame: Frame, folder: Path) -> Path:
    """A scene folder that holds the frame."""
    folder.mkdir(parents=True)
    Image.fromarray(frame.color.numpy()).save(folder / "color.png")
    Image.fromarray((1000 * frame.depth).round().numpy().astype(np.uint16)).save(folder / "depth.png")
    assert frame.label is not None
    assert frame.up_camera is not None
    Image.fromarray(frame.label.numpy().astype(np.uint16)).save(folder / "label.png")
    meta = {
        **frame.camera.intrinsics,
        "depth_unit": "mm",
        "up_camera": frame.up_camera.tolist(),
        "background_ids": list(frame.background_ids),
    }
    (folder / "meta.json").write_text(json.dumps(meta))
    return folder
