"""Potentials on disk: what is written comes back, and nothing else gets in."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import safetensors.torch
import torch

from models.potentials import checkpoint
from models.potentials.checkpoint import chosen_columns, load_potentials, save_potentials
from models.potentials.heads import HEADS, Head, LinearHead, MLPHead, Potential, initialised
from models.potentials.record import CheckpointError
from models.potentials.rows import KINDS

COLUMNS = ("volume", "tilt", "density")


def potential(head: Callable[[int], Head] = LinearHead, columns: tuple[str, ...] = COLUMNS) -> Potential:
    n = len(columns)
    return Potential(columns, initialised(head, n, 0), torch.arange(n).double(), torch.ones(n), a=3.0, b=-1.0)


def kinds(**others: Potential) -> dict[str, Potential]:
    """A linear potential of every kind, but for `others`."""
    return {kind: potential() for kind in KINDS} | others


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    """The stem of a checkpoint on disk."""
    stem = tmp_path / "mine"
    save_potentials(stem, kinds(unary=potential(MLPHead)), 0.5, {"data": "toy"})
    return stem


def edit(stem: Path, change: Callable[[dict[str, Any]], Any]) -> None:
    """Change the JSON of a checkpoint."""
    file = stem.with_suffix(".json")
    record = json.loads(file.read_text())
    change(record)
    file.write_text(json.dumps(record))


def replace_weights(stem: Path, content: bytes) -> None:
    """Put other bytes in the safetensors file, and their digest in the JSON."""
    stem.with_suffix(".safetensors").write_bytes(content)
    edit(stem, lambda record: record.update(sha256=hashlib.sha256(content).hexdigest()))


def edit_tensors(stem: Path, change: Callable[[dict[str, torch.Tensor]], Any]) -> None:
    tensors = safetensors.torch.load(stem.with_suffix(".safetensors").read_bytes())
    change(tensors)
    replace_weights(stem, safetensors.torch.save(tensors))


def test_everything_comes_back(tmp_path):
    kept = kinds(unary=potential(MLPHead), alone=potential(columns=("x", "y")))
    save_potentials(tmp_path / "new" / "v1.2", kept, 0.75, {"seed": 7, "scores": {"f": 0.5}})
    loaded = load_potentials(tmp_path / "new" / "v1.2")
    assert loaded.provenance == {"seed": 7, "scores": {"f": 0.5}}
    assert loaded.name == "v1.2"
    weights = (tmp_path / "new" / "v1.2.safetensors").read_bytes()
    assert loaded.sha256 == hashlib.sha256(weights).hexdigest()
    assert loaded.weight == 0.75
    assert loaded.alone.columns == ("x", "y")
    for kind, wanted in kept.items():
        state = getattr(loaded, kind).state_dict()
        assert all(torch.equal(state[key], value) for key, value in wanted.state_dict().items())
        assert not any(p.requires_grad for p in getattr(loaded, kind).parameters())
    assert sorted(f.name for f in (tmp_path / "new").iterdir()) == ["v1.2.json", "v1.2.safetensors"]


def test_the_width_of_a_network_comes_back(tmp_path):
    wide = potential(lambda features: MLPHead(features, hidden=7))
    save_potentials(tmp_path / "wide", kinds(unary=wide, pairwise=wide), 0.0, {})
    assert load_potentials(tmp_path / "wide").unary.head.arguments == {"hidden": 7}


@pytest.mark.parametrize("form", ["{}", "{}.json", "{}.safetensors"])
@pytest.mark.parametrize("kind", [str, Path])
def test_a_checkpoint_is_found_by_either_file_or_what_they_share(form, kind, saved):
    assert load_potentials(kind(form.format(saved))).name == "mine"


def test_a_bare_name_means_potentials_that_come_with_the_package(saved, monkeypatch, tmp_path):
    monkeypatch.setattr(checkpoint, "PRETRAINED", tmp_path)
    monkeypatch.chdir("/")
    assert load_potentials("mine").name == "mine"
    with pytest.raises(CheckpointError, match=r"'yours' come with .* only mine; .* such as \./yours\.json"):
        load_potentials("yours")


def test_the_same_potentials_give_the_same_files(saved, tmp_path):
    save_potentials(tmp_path / "again", kinds(unary=potential(MLPHead)), 0.5, {"data": "toy"})
    for suffix in (".json", ".safetensors"):
        assert (tmp_path / f"again{suffix}").read_bytes() == saved.with_suffix(suffix).read_bytes()


def test_reading_draws_no_random_number(saved):
    before = torch.get_rng_state()
    load_potentials(saved)
    assert torch.equal(torch.get_rng_state(), before)


def test_a_failed_write_leaves_the_old_checkpoint_whole(saved):
    class Unknown(LinearHead):
        pass

    with pytest.raises(ValueError, match="Unknown has no name to be stored under"):
        save_potentials(saved, kinds(unary=potential(Unknown)), 0.5, {})
    assert load_potentials(saved).provenance == {"data": "toy"}


@pytest.mark.parametrize("names", [("unary",), KINDS[:3], (*KINDS, "fifth"), (*KINDS[:3], "merge")])
def test_kinds_missing_or_unknown_are_not_saved(names, tmp_path):
    with pytest.raises(ValueError, match="the potentials must hold"):
        save_potentials(tmp_path / "odd", {kind: potential() for kind in names}, 0.0, {})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("suffix", [".ckpt", ".pt", ".pth", ".pkl", ".PT", ".bin"])
def test_a_pickle_is_not_opened(suffix, tmp_path):
    class Trap:
        def __reduce__(self) -> tuple[Any, ...]:
            return (Path.touch, (tmp_path / "sprung",))

    torch.save(Trap(), tmp_path / f"model{suffix}")
    with pytest.raises(CheckpointError, match=r"can run code when read.*pass the \.json"):
        load_potentials(tmp_path / f"model{suffix}")
    assert not (tmp_path / "sprung").exists()


@pytest.mark.parametrize("suffix", [".json", ".safetensors"])
def test_either_file_missing_is_named(suffix, saved):
    saved.with_suffix(suffix).unlink()
    with pytest.raises(CheckpointError, match=rf"There is no file .*mine\{suffix}"):
        load_potentials(saved)


@pytest.mark.parametrize("suffix", [".json", ".safetensors"])
def test_an_oversized_file_is_refused_unread(suffix, saved):
    with saved.with_suffix(suffix).open("r+b") as file:
        file.truncate(2**40)  # sparse: takes no room on disk
    with pytest.raises(CheckpointError, match=rf"mine\{suffix} is larger than 64 MiB"):
        load_potentials(saved)


def test_files_of_two_runs_are_not_mixed(saved):
    other = saved.with_name("other")
    save_potentials(other, kinds(), 0.5, {})
    other.with_suffix(".safetensors").replace(saved.with_suffix(".safetensors"))
    with pytest.raises(CheckpointError, match=r"mine\.safetensors is not the file that mine\.json describes"):
        load_potentials(saved)


@pytest.mark.parametrize(
    "text",
    ["", "{", "[]", "null", "3", "\x00\xff", "[" * 100_000, '{"format": 2}', '{"format": 2, "sha256": NaN}'],
)
def test_a_malformed_record_is_refused(text, saved):
    saved.with_suffix(".json").write_text(text)
    with pytest.raises(CheckpointError, match=r"mine\.json is not the record of a checkpoint"):
        load_potentials(saved)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda r: r.update(format=1), "format 1, but this version reads 2"),
        (lambda r: r.update(more=1), r"\['more'\] are unknown"),
        (lambda r: r.pop("provenance"), r"\['provenance'\] are missing"),
        (lambda r: r.update(provenance=[]), "provenance must be an object"),
        (lambda r: r.pop("weight"), r"\['weight'\] are missing"),
        (lambda r: r.update(weight=-0.1), "weight must be a number of 0 or more, but is -0.1"),
        (lambda r: r.update(weight=float("nan")), "weight must be a number of 0 or more, but is nan"),
        (lambda r: r.update(weight=float("inf")), "weight must be a number of 0 or more, but is inf"),
        (lambda r: r.update(weight=True), "weight must be a number of 0 or more, but is True"),
        (lambda r: r.update(weight="0.5"), "weight must be a number of 0 or more, but is '0.5'"),
        (lambda r: r.update(sha256="0" * 64), "its SHA-256 is"),
        (lambda r: r.update(sha256=7), "sha256 must be 64 hexadecimal digits, but is 7"),
        (lambda r: r.update(sha256="two\nlines"), "sha256 must be 64 hexadecimal digits, but is 'two"),
        (lambda r: r.update(format="x" * 10**5), "format 'xxx.*, but this version reads 2"),
        (lambda r: r.update({"x" * 10**5: 1}), "are unknown"),
        (lambda r: r["potentials"].pop("pairwise"), r"\['pairwise'\] are missing"),
        (lambda r: r["potentials"].pop("alone"), r"\['alone'\] are missing"),
        (lambda r: r["potentials"].update(merge={}), r"\['merge'\] are unknown"),
        (lambda r: r["potentials"].update(unary=[]), r"unary must be an object"),
        (
            lambda r: r["potentials"]["unary"].update(head="torch.nn.Linear"),
            "must be one of linear, mlp, trees",
        ),
        (lambda r: r["potentials"]["unary"].update(head=["mlp"]), "must be one of linear, mlp, trees"),
        (lambda r: r["potentials"]["unary"].update(_target_="os.system"), r"\['_target_'\] are unknown"),
        (lambda r: r["potentials"]["unary"].update(columns="volume"), "columns must be a list of names"),
        (lambda r: r["potentials"]["unary"].update(columns=[]), "columns must be a list of names"),
        (lambda r: r["potentials"]["unary"].update(columns=[1, 2, 3]), "columns must be a list of names"),
        (lambda r: r["potentials"]["unary"].update(columns=["volume"]), "unary.mean must be .* shape"),
        (
            lambda r: r["potentials"]["unary"].update(arguments={"hidden": 33}),
            "unary.head.layers.0.weight must",
        ),
        (
            lambda r: r["potentials"]["unary"].update(arguments={"hidden": 10**12}),
            "unary.head.layers.0.weight",
        ),
        (
            lambda r: r["potentials"]["unary"].update(arguments={"hidden": 10**30}),
            "does not take the arguments",
        ),
        (lambda r: r["potentials"]["unary"].update(arguments={"hidden": -1}), "does not take the arguments"),
        (
            lambda r: r["potentials"]["unary"].update(arguments={"hidden": "32"}),
            "does not take the arguments",
        ),
        (lambda r: r["potentials"]["unary"].update(arguments={"depth": 3}), "does not take the arguments"),
        (lambda r: r["potentials"]["unary"].update(arguments=[1]), "does not take the arguments"),
        (lambda r: r["potentials"]["unary"].update(head="linear"), "does not take the arguments"),
    ],
)
def test_a_record_that_lies_is_refused(change, message, saved):
    edit(saved, change)
    with pytest.raises(CheckpointError, match=message) as caught:
        load_potentials(saved)
    assert "mine." in str(caught.value)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < len(str(saved)) + 300


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: t.pop("unary.scale"), r"\['unary.scale'\] are missing"),
        (lambda t: t.update(stray=torch.zeros(1)), r"\['stray'\] too many"),
        (
            lambda t: t.update({"unary.mean": torch.zeros(4).double()}),
            r"unary.mean must .* \(3,\).* is .* \(4,\)",
        ),
        (lambda t: t.update({"unary.mean": torch.zeros(3)}), "must be torch.float64 .* is torch.float32"),
        (lambda t: t["unary.mean"].fill_(torch.inf), "unary.mean holds a number .* inf"),
        (lambda t: t["pairwise.head.linear.weight"].fill_(torch.nan), "nan"),
        (lambda t: t["unary.scale"].zero_(), "unary.scale holds a number"),
    ],
)
def test_tensors_that_do_not_fit_are_refused(change, message, saved):
    edit_tensors(saved, change)
    with pytest.raises(CheckpointError, match=message) as caught:
        load_potentials(saved)
    assert "mine.safetensors" in str(caught.value)


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\x00" * 8,
        (2**62).to_bytes(8, "little") + b"{}",  # a header of four exabytes
        (2).to_bytes(8, "little") + b"[]",
        (65).to_bytes(8, "little")
        + b'{"unary.a":{"dtype":"F64","shape":[1099511627776],"data_offsets":[0,8]}}',
        b"\x80\x04\x95pickle",
    ],
)
def test_weights_that_are_no_safetensors_are_refused(content, saved):
    replace_weights(saved, content)
    with pytest.raises(CheckpointError, match=r"mine\.safetensors does not hold the potentials' tensors"):
        load_potentials(saved)


def test_weights_cut_short_or_damaged_anywhere_are_refused(saved, generator):
    whole = saved.with_suffix(".safetensors").read_bytes()
    for cut in torch.randint(len(whole), (50,), generator=generator).tolist():
        replace_weights(saved, whole[:cut])
        with pytest.raises(CheckpointError):
            load_potentials(saved)
        saved.with_suffix(".safetensors").write_bytes(
            whole[:cut] + bytes([whole[cut] ^ 1]) + whole[cut + 1 :]
        )
        with pytest.raises(CheckpointError, match="is not the file"):
            load_potentials(saved)


def test_columns_are_found_by_name_wherever_they_stand():
    computed = ("colour", "density", "height", "tilt", "volume")
    assert chosen_columns(potential(), computed).tolist() == [4, 3, 1]


@pytest.mark.parametrize("computed", [("volume", "density"), ("volume", "lean", "density"), ()])
def test_a_column_that_is_not_computed_is_named_in_one_line(computed):
    missing = next(name for name in COLUMNS if name not in computed)
    with pytest.raises(CheckpointError, match=f"needs the column '{missing}'") as caught:
        chosen_columns(potential(), computed)
    assert "\n" not in str(caught.value)


class Doubled(LinearHead):
    name = "doubled"


def test_a_head_of_ones_own_is_read_by_who_says_its_class_and_by_nobody_else(tmp_path):
    save_potentials(tmp_path / "own", kinds(unary=potential(Doubled)), 0.5, {})
    assert type(load_potentials(tmp_path / "own", {**HEADS, "doubled": Doubled}).unary.head) is Doubled
    with pytest.raises(
        CheckpointError, match=r"'doubled', but must be one of linear, mlp, trees; say `heads="
    ):
        load_potentials(tmp_path / "own")
