"""Potentials on disk: the numbers in safetensors, all else in JSON; nothing that is read can run code."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any

import safetensors.torch
import torch
from safetensors import SafetensorError
from torch import Tensor

from blockstab.output.export import write_whole
from models.potentials.heads import HEADS, Potential
from models.potentials.record import CheckpointError, Record, read_record

MAX_BYTES = 64 * 2**20  # of either file; potentials take kilobytes
PRETRAINED = Path(str(resources.files("models") / "pretrained"))
_PICKLES = (".ckpt", ".pt", ".pth", ".pkl", ".pickle", ".joblib", ".bin")


@dataclass(frozen=True)
class Potentials:
    """Potentials of a checkpoint, as a parse needs them.

    Args:
        unary: of segments (Eq. 3).
        pairwise: of boundaries (Eq. 4).
        alone: of segments judged by themselves.
        background: of segments judged by themselves, the share of them that is things.
        weight: of boundaries in the expected loss.
        name: of the checkpoint, without folder and suffix.
        sha256: of the safetensors file, in hexadecimal.
        provenance: data, seed, versions, scores: what its maker wrote down.
    """

    unary: Potential
    pairwise: Potential
    alone: Potential
    background: Potential
    weight: float
    name: str
    sha256: str
    provenance: dict[str, Any] = field(compare=False)


def save_potentials(
    path_stem: Path, potentials: dict[str, Potential], weight: float, provenance: dict[str, Any]
) -> None:
    """Write `<stem>.safetensors`, then `<stem>.json`, each whole or not at all.

    Args:
        path_stem: where to write, without a suffix; its folder is made where missing.
        potentials: by kind: "unary", "pairwise", "alone" and "background".
        weight: of boundaries in the expected loss.
        provenance: anything JSON can hold.

    Raises:
        ValueError: if a kind is missing or unknown, or a head's class has no name of its own.
    """
    # Copies, since safetensors refuses tensors that share memory: one potential may serve two kinds.
    weights = safetensors.torch.save({key: t.clone() for key, t in _tensors(potentials).items()})
    record = Record(hashlib.sha256(weights).hexdigest(), potentials, weight, provenance).text()
    record_file, weights_file = _files(path_stem)
    path_stem.parent.mkdir(parents=True, exist_ok=True)
    # The JSON holds the digest of the other file: killed in between, the pair is refused, not mixed.
    write_whole(weights_file, weights)
    write_whole(record_file, record.encode())


def load_potentials(path: Path | str, heads: Mapping[str, type[Any]] = HEADS) -> Potentials:
    """Read what `save_potentials` wrote.

    Args:
        path: a name without folder and suffix, such as "svm", for potentials that come with this package;
            else the path of the `.json` or of the `.safetensors`, or what the two share.
        heads: the classes that it may name; none is looked for anywhere else.

    Returns:
        Potentials equal, bit for bit, to those saved; their parameters ask for no gradient.

    Raises:
        CheckpointError: naming the file and what is wrong with it.
    """
    stem = _stem(path)
    record_file, weights_file = _files(stem)
    record = read_record(record_file, _content(record_file), heads)
    weights = _content(weights_file)
    digest = hashlib.sha256(weights).hexdigest()
    if digest != record.sha256:
        raise CheckpointError(
            f"{weights_file} is not the file that {record_file.name} describes: its SHA-256 is "
            f"{digest[:12]}..., not {record.sha256:.12}...; copy both files of one training run."
        )
    try:
        tensors = safetensors.torch.load(weights)
        _check_tensors(tensors, _tensors(record.potentials))
    except (SafetensorError, KeyError, ValueError, RuntimeError) as error:
        raise CheckpointError(f"{weights_file} does not hold the potentials' tensors: {error}.") from error
    for kind, potential in record.potentials.items():
        own = {key: tensors[f"{kind}.{key}"] for key in potential.state_dict()}
        potential.load_state_dict(own, assign=True)
        potential.requires_grad_(False)
        try:
            potential.head.check(len(potential.columns))
        except ValueError as error:
            raise CheckpointError(f"{weights_file} holds no {kind} potential: {error}.") from None
    return Potentials(
        unary=record.potentials["unary"],
        pairwise=record.potentials["pairwise"],
        alone=record.potentials["alone"],
        background=record.potentials["background"],
        weight=record.weight,
        name=stem.name,
        sha256=digest,
        provenance=record.provenance,
    )


def chosen_columns(potential: Potential, computed: tuple[str, ...]) -> Tensor:
    """(F,) int64 where the potential's columns stand among those that are computed.

    Raises:
        CheckpointError: if one is not among them.
    """
    missing = [name for name in potential.columns if name not in computed]
    if missing:
        raise CheckpointError(
            f"The potential needs the column {missing[0]!r}, which this version does not compute; "
            "say `columns=` for one of your own, or train it anew with this version."
        )
    return torch.tensor([computed.index(name) for name in potential.columns])


def _tensors(potentials: dict[str, Potential]) -> dict[str, Tensor]:
    """All tensors, named "<kind>.<name>"."""
    return {f"{kind}.{key}": t for kind, p in potentials.items() for key, t in p.state_dict().items()}


def _files(stem: Path) -> tuple[Path, Path]:
    """The JSON and the safetensors file; a dot in the stem is part of its name."""
    return stem.with_name(f"{stem.name}.json"), stem.with_name(f"{stem.name}.safetensors")


def _stem(path: Path | str) -> Path:
    """The path that the two files of a checkpoint share but for their suffix, from any way to name it."""
    is_name = not set(str(path)) & set("/\\.")
    path = Path(path)
    if path.suffix.lower() in _PICKLES:
        raise CheckpointError(
            f"{path} may be a pickle, which can run code when read, so it is not opened; "
            "pass the .json that training wrote, with its .safetensors beside it."
        )
    if not is_name:
        return path.with_suffix("") if path.suffix in (".json", ".safetensors") else path
    shipped = sorted(file.stem for file in PRETRAINED.glob("*.json"))
    if path.name not in shipped:
        raise CheckpointError(
            f"No potentials named {path.name!r} come with this package, only {', '.join(shipped) or 'none'}; "
            f"for a file of your own pass its path, such as ./{path.name}.json."
        )
    return PRETRAINED / path.name


def _content(path: Path) -> bytes:
    """All of an ordinary file, once its size is known to be sane."""
    if not path.is_file():
        raise CheckpointError(
            f"There is no file {path}; a checkpoint is a .json with its .safetensors beside it."
        )
    if path.stat().st_size > MAX_BYTES:
        raise CheckpointError(f"{path} is larger than {MAX_BYTES // 2**20} MiB, which no potentials are.")
    return path.read_bytes()


def _check_tensors(tensors: dict[str, Tensor], wanted: dict[str, Tensor]) -> None:
    """ValueError unless names, shapes and types are those wanted, and the numbers what training can give."""
    missing, surplus = sorted(wanted.keys() - tensors.keys()), sorted(tensors.keys() - wanted.keys())
    if missing or surplus:
        raise ValueError(f"{missing} are missing and {surplus} too many")
    for key, like in wanted.items():
        tensor = tensors[key]
        if tensor.shape != like.shape or tensor.dtype != like.dtype:
            raise ValueError(
                f"{key} must be {like.dtype} of shape {tuple(like.shape)}, "
                f"but is {tensor.dtype} of shape {tuple(tensor.shape)}"
            )
        if not bool(tensor.isfinite().all()) or (key.endswith(".scale") and bool((tensor <= 0).any())):
            raise ValueError(f"{key} holds a number that no training gives, {tensor.tolist()!r:.80}")
