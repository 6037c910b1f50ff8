"""The flat figures of a report."""

from __future__ import annotations

import pytest

from blockstab.output.figures.images import depth_figure, energy_figure, segments_figure
from blockstab.output.figures.marks import image_middles
from blockstab.parsing.parsed import Parsed
from tests.output.figures.drawn import checked
from tests.table_scene import TOPPLING, parsed_table


@pytest.fixture
def parsed() -> Parsed:
    return parsed_table()


def test_ids_sit_at_the_middle_of_their_pixels(parsed: Parsed) -> None:
    assert image_middles(parsed)[TOPPLING].tolist() == [14.5, 4.5]


def test_pictures_are_part_of_the_page(parsed: Parsed) -> None:
    assert checked(segments_figure)(parsed).data[0].source.startswith("data:image/jpeg;base64,")
    assert checked(depth_figure)(parsed).data[0].source.startswith("data:image/png;base64,")


def test_the_energy_of_every_round_is_drawn(parsed: Parsed) -> None:
    assert tuple(checked(energy_figure)(parsed).data[0].y) == parsed.trace
