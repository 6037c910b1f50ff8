import pytest
from hydra.errors import InstantiationException
from hydra.utils import instantiate

from blockstab.datasets.sets import FolderScenes
from blockstab.proposals.files import LabelFile
from blockstab.search.moves.every import EVERY
from blockstab.testing.photographs import BLOCKS, photograph
from models.entry import one_line_errors
from models.gathering import examples_of
from models.potentials.examples import ExampleMaker
from tests.synthetic import write_folder


def test_a_callers_mistake_becomes_one_line_and_exit_status_1():
    with pytest.raises(SystemExit) as stop, one_line_errors():
        raise ValueError("the root\nholds no scene")
    assert stop.value.code == "the root holds no scene"


def test_what_a_part_of_the_configuration_refuses_becomes_one_line():
    with pytest.raises(SystemExit) as stop, one_line_errors():
        instantiate({"_target_": "models.stages.stages.silberman", "stages": "missing.json"})
    assert stop.value.code == "missing.json is not there; train it with `python train.py task=stages`."


def test_a_part_of_the_configuration_that_breaks_keeps_its_traceback():
    with pytest.raises(InstantiationException), one_line_errors():
        instantiate({"_target_": "operator.truediv", "_args_": [1, 0]})


def test_a_defect_of_our_own_keeps_its_traceback():
    with pytest.raises(RuntimeError), one_line_errors():
        raise RuntimeError("a defect")


def test_a_scene_without_labels_is_named_and_not_missed_as_a_file(tmp_path):
    folder = write_folder(photograph(*BLOCKS).frame, tmp_path / "scene")
    (folder / "label.png").unlink()
    with pytest.raises(ValueError, match=r"scene has no label\.png"):
        examples_of("scene", FolderScenes(tmp_path), ExampleMaker((LabelFile(),), EVERY), 0, tmp_path)
