"""One damaged scene is named, and costs no other."""

from __future__ import annotations

import pytest

from blockstab.datasets.readable import readable
from tests.datasets.scene_names import Names

DATA = Names(("a", "b", "c"), damaged=("b",))


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_damaged_scene_is_left_out_with_one_line(capsys: pytest.CaptureFixture[str], jobs: int) -> None:
    assert readable(DATA, DATA.scenes(), jobs=jobs) == ["a", "c"]
    said = capsys.readouterr().err
    assert "left out: b/depth.png: must be a whole image\n" in said


def test_a_strict_run_stops_at_it() -> None:
    with pytest.raises(ValueError, match=r"^b/depth\.png: must be a whole image$"):
        readable(DATA, DATA.scenes(), strict=True)


def test_a_set_of_which_nothing_can_be_read_is_refused() -> None:
    with pytest.raises(ValueError, match="None of the 1 scenes of names can be read"):
        readable(DATA, ["b"])
