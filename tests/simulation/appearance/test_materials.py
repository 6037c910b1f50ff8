"""The colour of points of a room."""

from __future__ import annotations

import torch

from blockstab.simulation.appearance.materials import Materials, draw_materials, linear
from blockstab.simulation.physics.solids import concatenate
from tests.simulation.scenery import Scenery, of_one_part, scenery, standing
from tests.tolerance import LEARNED

PRODUCT = (0.037, 0.055, 0.037)
PILE = standing(
    (of_one_part("cylinder", PRODUCT, "tin", product=5), -0.2, 0.0),
    (of_one_part("cylinder", PRODUCT, "tin", product=5), -0.1, 0.0),
    (of_one_part("cylinder", PRODUCT, "tin"), 0.0, 0.0),
    (of_one_part("box", (0.05, 0.1, 0.03), "carton"), 0.15, 0.0),
)


def made_up(scene: Scenery, variety: float, seed: int = 1) -> Materials:
    room = concatenate([scene.room, scene.pile])
    generator = torch.Generator().manual_seed(seed)
    return draw_materials(room, scene.caster.patches, len(scene.pile), variety, generator)


def colors(scene: Scenery, materials: Materials) -> torch.Tensor:
    """Linear RGB (H, W, 3)."""
    hit = scene.seen.solid >= 0
    seen, solids = scene.seen[hit], concatenate([scene.room, scene.pile])
    offset = (seen.points - solids.center[seen.solid])[:, None]
    local = (offset @ solids.rotation[seen.solid])[:, 0].to(torch.float32)
    image = torch.zeros(*hit.shape, 3)
    image[hit] = materials.albedo(seen, local)
    return image


def test_without_variety_every_solid_has_one_colour_and_with_it_many() -> None:
    scene = scenery(PILE, 1)
    plain, full = (colors(scene, made_up(scene, variety)) for variety in (0.0, 1.0))
    for solid in scene.seen.solid.unique().tolist():
        own = scene.seen.solid == solid
        assert float(plain[own].std(dim=0).max()) < LEARNED
    for solid in range(len(scene.room), len(scene.room) + 4):
        assert float(full[scene.seen.solid == solid].std(dim=0).max()) > 0.02


def test_equal_products_have_equal_prints_and_others_do_not() -> None:
    scene = scenery(PILE, 1)
    first = len(scene.room)
    for seed in range(3):
        made = made_up(scene, 1.0, seed)
        start, width, height = made.print[made.first_patch[first : first + 3]][:, :3].long().unbind(dim=1)
        labels = [made.texels[s : s + w * h] for s, w, h in zip(start, width, height, strict=True)]
        assert torch.equal(labels[0], labels[1])
        assert float((labels[0] - labels[2]).abs().mean()) > 0.02


def test_prints_follow_the_texels_and_begin_again_at_their_end() -> None:
    texels = torch.arange(6.0)[:, None].expand(6, 3)  # two rows of three
    sheet = torch.tensor([[0.0, 3.0, 2.0, 0.3, 0.2]])
    made = Materials(texels, sheet, *[torch.empty(0)] * 4, None, torch.empty(0))  # type: ignore[arg-type]
    middles = torch.tensor([[0.05, 0.15], [0.25, 0.15], [0.15, 0.05], [0.35, 0.15], [0.1, 0.15]])
    values = made._printed(sheet.expand(5, 5), middles)[:, 0]
    assert torch.allclose(values, torch.tensor([0.0, 2.0, 4.0, 0.0, 0.5]), atol=LEARNED)


def test_linear_light_of_the_srgb_standard() -> None:
    # IEC 61966-2-1: mid grey 0.5 has 21.4 % of the light of white.
    values = linear(torch.tensor([0.0, 0.04045, 0.5, 1.0]))
    assert torch.allclose(values, torch.tensor([0.0, 0.0031308, 0.2140, 1.0]), atol=1e-4)
