"""Energy and score in the course of a search."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from blockstab.evaluation.metrics import overlap_score
from blockstab.evaluation.scoring.course import Course, Following, followed_course, mean_course, read_course
from blockstab.parsing.look import Look
from blockstab.parsing.parser import Parser
from blockstab.proposals.watershed import Watershed
from blockstab.search.greedy import Greedy
from blockstab.search.rsamp import RSamp
from blockstab.testing.photographs import BLOCKS, photograph
from tests.tolerance import EXACT
from tests.toy_potentials import toy_potentials

PARSER = Parser(Watershed(), RSamp(rounds=3), toy_potentials())
OBJECTS = (2, 3, 4, 5)


def course(*energy: float, overlap: tuple[float, ...]) -> Course:
    return Course(energy, overlap, energy, overlap)


@pytest.fixture(scope="module")
def followed() -> tuple[Look, Course]:
    look = Look(photograph(*BLOCKS).frame)
    return look, followed_course(PARSER, look, OBJECTS)


def test_the_search_that_is_followed_is_the_parsers(followed):
    look, found = followed
    parsed = PARSER.understand(look)
    assert found.energy == parsed.trace
    painted = overlap_score(look.frame.label, parsed.label, OBJECTS)
    assert found.overlap[-1] == pytest.approx(painted, abs=EXACT)
    assert len(found.overlap) == len(found.energy)


def test_the_best_of_all_that_was_visited_is_what_the_search_came_to(followed):
    _, found = followed
    assert min(found.visited_energy) == found.energy[-1]
    assert len(found.visited_energy) == len(found.visited_overlap) > len(found.energy)


def test_a_file_tells_the_same_course(followed, tmp_path):
    look, found = followed
    Following(PARSER, lambda _: OBJECTS)(look, tmp_path / "scene")
    assert read_course(tmp_path / "scene") == found


def test_an_image_without_labels_is_refused():
    frame = replace(photograph(*BLOCKS).frame, label=None)
    parser = Parser(Watershed(), Greedy(), toy_potentials())
    with pytest.raises(ValueError, match="blocks has no labelled objects"):
        followed_course(parser, Look(frame), OBJECTS)


def test_ranks_decide_the_correlation_worked_by_hand():
    assert course(1.0, 2.0, 9.0, overlap=(0.9, 0.3, 0.1)).correlation() == (pytest.approx(-1.0), 1)
    # Ranks 1 2 3 and 2 1 3: 1 - 6 (1 + 1 + 0) / (3 * 8).
    assert course(1.0, 2.0, 3.0, overlap=(0.5, 0.4, 0.6)).correlation() == (pytest.approx(0.5), 1)


def test_where_all_are_alike_there_is_no_correlation():
    assert course(1.0, 1.0, overlap=(0.2, 0.3)).correlation().things == 0
    assert course(1.0, 2.0, overlap=(0.3, 0.3)).correlation().things == 0


def test_a_search_that_ended_early_stays_where_it_is():
    one, two = course(0.4, 0.2, overlap=(0.5, 0.7)), course(0.6, 0.6, 0.2, overlap=(0.1, 0.1, 0.3))
    found = mean_course([one, two], seed=0)
    assert found["energy"]["mean"] == pytest.approx([0.5, 0.4, 0.2], abs=EXACT)
    assert found["overlap"]["mean"] == pytest.approx([0.3, 0.4, 0.5], abs=EXACT)


def test_the_band_tells_of_the_change_and_not_of_how_images_differ():
    easy, hard = course(0.1, 0.0, overlap=(0.9, 1.0)), course(0.9, 0.8, overlap=(0.1, 0.2))
    found = mean_course([easy, hard], seed=0)["overlap"]
    assert found["low"] == pytest.approx([0.5, 0.6], abs=EXACT)
    assert found["high"] == pytest.approx([0.5, 0.6], abs=EXACT)
    json.dumps(found)
