"""Everyday things are of their size, shape and weight."""

from __future__ import annotations

import pytest
import torch

from blockstab.simulation.layouts.products import PRODUCTS, draw_product

SHAPES = {
    "can": "cylinder",
    "tin": "cylinder",
    "pen": "cylinder",
    "bottle": "bottle",
    "ball": "sphere",
    "bowl": "bowl",
    "plate": "bowl",
    "bracket": "l_shape",
    **{style: style for style in ("screen", "laptop", "mouse")},
}


@pytest.mark.parametrize("name", PRODUCTS)
def test_a_product_is_within_a_fifth_of_its_usual_size(name: str, generator: torch.Generator) -> None:
    usual = torch.tensor(PRODUCTS[name].size, dtype=torch.float64)
    sizes = torch.stack([2 * draw_product(generator, name).half_extent for _ in range(20)])
    assert ((sizes / usual - 1).abs() <= 0.2 + 1e-9).all()
    assert (sizes.amax(dim=0) / sizes.amin(dim=0) > 1.1).all()


@pytest.mark.parametrize("name", PRODUCTS)
def test_a_product_has_the_shape_of_its_style(name: str, generator: torch.Generator) -> None:
    solid = draw_product(generator, name, number=4)
    assert solid.style == PRODUCTS[name].style
    assert solid.kind == SHAPES.get(solid.style, "box")
    assert solid.density == PRODUCTS[name].density
    assert solid.product == 4


def test_a_full_can_weighs_about_a_third_of_a_kilogram_and_a_cereal_box_about_700_grams() -> None:
    for name, kilograms in (("soup", 0.34), ("cereal", 0.72), ("book", 0.86), ("water", 1.4)):
        product = PRODUCTS[name]
        wide, tall, deep = product.size
        solid_share = 0.785 if product.style in ("can", "bottle") else 1.0
        assert product.density * solid_share * wide * tall * deep == pytest.approx(kilograms, rel=0.03)


def test_screens_swallow_light_and_one_in_ten_other_things_does(generator: torch.Generator) -> None:
    assert all(draw_product(generator, "monitor").parts[-1].echo <= 0.4 for _ in range(20))
    books = [draw_product(generator, "book").parts[0].echo for _ in range(300)]
    assert 15 <= sum(echo < 1.0 for echo in books) <= 50
    assert min(books) > 0
