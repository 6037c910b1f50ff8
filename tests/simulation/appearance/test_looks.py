"""How things are made up."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from blockstab.simulation.appearance.finish import Look
from blockstab.simulation.appearance.looks import draw_look, draw_paints
from blockstab.simulation.appearance.meshes import mesh_of
from tests.simulation.scenery import of_one_part

PAINTS = draw_paints(6, torch.Generator().manual_seed(1))
THINGS = [
    *(
        of_one_part("box", (0.1, 0.15, 0.03), style)
        for style in ("carton", "book", "block", "plank", "bracket")
    ),
    *(of_one_part("cylinder", (0.04, 0.06, 0.04), style) for style in ("tin", "can", "bottle")),
    *(of_one_part("sphere", (0.06, 0.06, 0.06), style) for style in ("ball", "bowl")),
    *(of_one_part("box", (0.8, 0.6, 0.7), style) for style in ("table", "floor", "wall", "shelf")),
]


def looked(index: int, seed: int) -> Look:
    solid = THINGS[index]
    return draw_look(solid, mesh_of(solid).patches, PAINTS, torch.Generator().manual_seed(seed))


def same(first: Look, second: Look) -> bool:
    pairs = zip(first.sheets, second.sheets, strict=True)
    return all(a.size == b.size and a.image.tobytes() == b.image.tobytes() for a, b in pairs)


@pytest.mark.parametrize("index", range(len(THINGS)), ids=[solid.style for solid in THINGS])
def test_equal_generators_make_things_up_alike_and_others_differently(index: int) -> None:
    first, again = looked(index, 1), looked(index, 1)
    assert same(first, again)
    assert first.grain == again.grain
    assert any(not same(first, looked(index, seed)) for seed in (2, 3, 4))
    patches = mesh_of(THINGS[index]).patches
    assert len(first.sheets) == len(first.finishes) == len(patches)


def test_the_faces_of_a_carton_differ_and_are_printed() -> None:
    printed, unlike = 0, 0
    for seed in range(8):
        look = looked(0, seed)
        faces = [np.asarray(look.sheets[face].image)[::3, ::3] for face in (0, 1, 4, 5)]
        printed += sum(len(np.unique(face.reshape(-1, 3), axis=0)) > 3 for face in faces)
        unlike += (faces[2] != faces[3]).mean() > 0.05
    # The rest are brown parcels, bare but for a label and tape.
    assert printed >= 16
    assert unlike >= 5


def test_there_are_fewer_paints_than_things() -> None:
    assert len(draw_paints(12, torch.Generator().manual_seed(0))) < 12
