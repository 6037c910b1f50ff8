"""Potentials on disk: the numbers in safetensors, everything else in JSON; nothing here can run code."""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

import safetensors.torch
from safetensors import SafetensorError
from torch import Tensor

from blockstab.export import write_whole
from models.heads import Potential
from models.record import CheckpointError, described, parsed_record, record_of

MAX_BYTES = 64 * 2**20  # of either file; potentials take kilobytes
PRETRAINED = Path(str(resources.files("models") / "pretrained"))
_PICKLES = (".ckpt", ".pt", ".pth", ".pkl", ".pickle", ".joblib", ".bin")


@dataclass(frozen=True)
class Potentials:
    """What a parse needs of a checkpoint.

    Args:
        unary: of segments (Eq. 3).
        pairwise: of boundaries (Eq. 4).
        merge: of merging two neighbours (section 6.1), where the checkpoint holds one.
        name: of the checkpoint, without folder and suffix.
        sha256: of the safetensors file, in hexadecimal.
        provenance: data, seed, versions, scores: what its maker wrote down.
    """

    unary: Potential
    pairwise: Potential
    merge: Potential | None
    name: str
    sha256: str
    provenance: dict[str, Any]


def save_potentials(path_stem: Path, potentials: dict[str, Potential], provenance: dict[str, Any]) -> None:
    """Write `<stem>.safetensors`, then `<stem>.json`, each whole or not at all.

    Args:
        path_stem: where to write, without a suffix; its folder exists.
        potentials: by kind: "unary", "pairwise" and, where there is one, "merge".
        provenance: anything JSON can hold.

    Raises:
        ValueError: if a kind is missing or unknown, or a head's class is not in `models.heads.HEADS`.
    """
    if not {"unary", "pairwise"} <= set(potentials) <= set(KINDS):
        raise ValueError(
            f"A checkpoint holds unary, pairwise and perhaps merge, but got {sorted(potentials)}."
        )
    tensors = {
        f"{kind}.{key}": value.contiguous()
        for kind, potential in potentials.items()
        for key, value in potential.state_dict().items()
    }
    weights = safetensors.torch.save(tensors)
    record = {
        "format": FORMAT,
        "sha256": hashlib.sha256(weights).hexdigest(),
        "potentials": {kind: _description(potential) for kind, potential in potentials.items()},
        "provenance": provenance,
    }
    text = json.dumps(record, indent=2) + "\n"
    # The JSON names the digest of the other file, so it comes last: a killed run cannot leave a mixed pair unnoticed.
    _write(_with_suffix(path_stem, ".safetensors"), weights)
    _write(_with_suffix(path_stem, ".json"), text.encode())


def load_potentials(path: Path | str) -> Potentials:
    """Read potentials that `save_potentials` wrote.

    Args:
        path: a name without folder and suffix, such as "svm", for one that comes with this package; else
            the path of the `.json` or the `.safetensors`, or what the two share.

    Returns:
        Potentials whose parameters ask for no gradient; equal, bit for bit, to those saved.

    Raises:
        CheckpointError: naming the file, what is wrong with it, and what to pass instead.
    """
    stem = _stem(path)
    record_file, weights_file = _with_suffix(stem, ".json"), _with_suffix(stem, ".safetensors")
    record = _checked_record(record_file)
    weights = _read(weights_file)
    digest = hashlib.sha256(weights).hexdigest()
    if digest != record["sha256"]:
        raise CheckpointError(
            f"{weights_file} is not the file that {record_file.name} describes: its SHA-256 is {digest[:12]}..., "
            f"not {str(record['sha256'])[:12]}...; copy both files of one training run."
        )
    try:
        tensors = safetensors.torch.load(weights)
    except (SafetensorError, KeyError, ValueError, RuntimeError) as error:
        raise CheckpointError(f"{weights_file} is not a safetensors file of tensors: {error}.") from error
    described = {kind: _empty(record_file, kind, d) for kind, d in record["potentials"].items()}
    _check_tensors(weights_file, described, tensors)
    for kind, potential in described.items():
        potential.load_state_dict({k: tensors[f"{kind}.{k}"] for k in potential.state_dict()}, assign=True)
        potential.requires_grad_(False)
    return Potentials(
        described["unary"],
        described["pairwise"],
        described.get("merge"),
        stem.name,
        digest,
        record["provenance"],
    )


def check_columns(potential: Potential, expected: tuple[str, ...]) -> None:
    """Raise CheckpointError unless the potential was trained on the columns that the features have now.

    Args:
        expected: names of the columns that will be given to `potential`, in order.
    """
    for i, (stored, wanted) in enumerate(zip(potential.columns, expected, strict=False)):
        if stored != wanted:
            raise CheckpointError(
                f"Column {i} of the potential is {stored!r}, but the features have {wanted!r} there; "
                "train the potential anew with this version."
            )
    if len(potential.columns) != len(expected):
        raise CheckpointError(
            f"The potential was trained on {len(potential.columns)} columns, but the features have "
            f"{len(expected)}; train the potential anew with this version."
        )


def _with_suffix(stem: Path, suffix: str) -> Path:
    return stem.with_name(stem.name + suffix)


def _stem(path: Path | str) -> Path:
    """What the two files of a checkpoint share, from any way to name it."""
    path, bare = Path(path), os.sep not in str(path)
    if path.suffix.lower() in _PICKLES:
        raise CheckpointError(
            f"{path} may hold a pickle, which can run code when read, so it is not opened; "
            "pass the .json that training wrote beside its .safetensors."
        )
    if path.suffix in (".json", ".safetensors"):
        return path.with_suffix("")
    if not bare:
        return path
    shipped = sorted(file.stem for file in PRETRAINED.glob("*.json"))
    if path.name not in shipped:
        raise CheckpointError(
            f"No potentials named {path.name!r} come with this package, which has {', '.join(shipped) or 'none'}; "
            f"for a file of your own pass its path, such as ./{path.name}.json."
        )
    return PRETRAINED / path.name


def _read(path: Path) -> bytes:
    """The whole of an ordinary file of a sane size."""
    if not path.is_file():
        raise CheckpointError(
            f"There is no file {path}; a checkpoint is a .safetensors and the .json beside it."
        )
    with path.open("rb") as file:
        content = file.read(MAX_BYTES + 1)
    if len(content) > MAX_BYTES:
        raise CheckpointError(f"{path} is larger than {MAX_BYTES // 2**20} MiB, which no potentials are.")
    return content


def _check_tensors(path: Path, described: dict[str, Potential], tensors: dict[str, Tensor]) -> None:
    """Raise CheckpointError unless the tensors are those of the potentials described, finite, scales positive."""
    wanted = {f"{kind}.{key}": t for kind, p in described.items() for key, t in p.state_dict().items()}
    missing, surplus = sorted(wanted.keys() - tensors.keys()), sorted(tensors.keys() - wanted.keys())
    if missing or surplus:
        raise CheckpointError(f"{path} lacks the tensors {missing} and has {surplus} too many.")
    for key, tensor in tensors.items():
        if tensor.shape != wanted[key].shape or tensor.dtype != wanted[key].dtype:
            raise CheckpointError(
                f"{path}: {key} must be {wanted[key].dtype} of shape {tuple(wanted[key].shape)}, "
                f"but is {tensor.dtype} of shape {tuple(tensor.shape)}."
            )
        if not bool(tensor.isfinite().all()) or (key.endswith(".scale") and bool((tensor <= 0).any())):
            raise CheckpointError(
                f"{path}: {key} holds a number that no training gives: {tensor.tolist()!r:.80}."
            )
