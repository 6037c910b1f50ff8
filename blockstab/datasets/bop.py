"""Sets in the BOP format: known objects with their poses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from reprlib import repr as shown
from typing import Any

import numpy as np
import torch
from torch import Tensor

from blockstab.datasets.bop_entries import bounds, camera_of, entries, numbers
from blockstab.datasets.organised import inside, lies_in
from blockstab.datasets.truth import ObjectTruth, Truth
from blockstab.determinism.sources import stamp_of_files
from blockstab.rgbd.frame import Frame, check_same_size, decoded
from blockstab.rgbd.reading import FrameError, ImageFile, Meta, color_file, depth_file, label_file, read_meta

_COLORS = ("rgb/{}.png", "rgb/{}.jpg", "gray/{}.png", "gray/{}.jpg")
_RIGID = 1e-3


@dataclass(frozen=True)
class BOP:
    """A split of a set in the format of the BOP challenge (Hodan et al. 2018).

    Layout::

        root/models/models_info.json                       optional: sizes of the objects; or models_eval
        root/SPLIT/000001/scene_camera.json, scene_gt.json, and optionally scene_gt_info.json
        root/SPLIT/000001/{rgb,gray}/000000.png or .jpg, depth/000000.png, mask_visib/000000_000000.png

    The objects are numbered from 1 in the order of scene_gt.json; a mask takes its pixels from those before it.
    What is not an object is not labelled. A box is the model's bounding box, where its size is known.

    Args:
        root: the folder of the set.
        split: the folder of scenes below it, such as "test".
    """

    root: str | Path
    split: str = "test"

    @property
    def name(self) -> str:
        """The folder's own name, and the split's."""
        return f"{Path(self.root).resolve().name}_{self.split}"

    def scenes(self) -> list[str]:
        """Scene and image, joined by "-", in the order of both.

        Raises:
            ValueError: there is none.
        """
        return list(self._views)

    def read(self, scene: str) -> tuple[Frame, Truth]:
        """One image.

        Raises:
            FrameError: a file is missing, damaged or links out of the root.
        """
        folder, stem = self._view(scene)
        color = next((f for f in self._images(folder, stem) if f.is_file()), folder / _COLORS[0].format(stem))
        said = read_meta(self._inside(folder / "scene_camera.json"))
        camera, scale = camera_of(said, stem)
        depth = depth_file(self._inside(folder / "depth" / f"{stem}.png"))
        frame = decoded(
            color_file(self._inside(color)),
            depth,
            camera,
            lambda raw: raw.astype(np.float64) * scale / 1000.0,
            scene,
            str(said.path),
        )
        placed = entries(read_meta(self._inside(folder / "scene_gt.json")), stem)
        pixels = self._total_pixels(folder, stem, len(placed))
        label = self._label(folder, stem, depth, len(placed))
        present = set(torch.unique(label).tolist())
        found = (self._object(i, entry, folder) for i, entry in enumerate(placed, start=1))
        objects = tuple(replace(o, total_pixels=pixels.get(o.id)) for o in found if o.id in present)
        return replace(frame, label=label), Truth((), objects, None, support_annotated=False)

    def stamp(self, scene: str) -> str:
        """A hash of the image's files."""
        folder, stem = self._view(scene)
        said = [folder / f"scene_{what}.json" for what in ("camera", "gt", "gt_info")]
        masks = sorted((folder / "mask_visib").glob(f"{stem}_*.png"))
        files = [*self._images(folder, stem), folder / "depth" / f"{stem}.png", *said, *masks]
        return stamp_of_files([file for file in files if lies_in(file, Path(self.root))])

    def official(self) -> Mapping[str, Sequence[str]]:
        """Each split is a folder of its own, so there is none within."""
        return {}

    @cached_property
    def _views(self) -> dict[str, tuple[Path, str]]:
        """Folder and number of each image, by name."""
        top = Path(self.root) / self.split
        views: dict[str, tuple[Path, str]] = {}
        for folder in sorted(top.iterdir()) if top.is_dir() else ():
            if folder.is_dir() and not folder.is_symlink():
                stems = [depth.stem for depth in (folder / "depth").glob("*.png")]
                views |= {f"{folder.name}-{s}": (folder, s) for s in sorted(stems) if s.isdecimal()}
        if not views:
            raise ValueError(f"{top} holds no scene (a folder with depth/000000.png or the like in it).")
        return views

    def _view(self, scene: str) -> tuple[Path, str]:
        if scene not in self._views:
            raise FrameError(f"{self.root}: holds no image {scene}; choose one of scenes().")
        return self._views[scene]

    def _images(self, folder: Path, stem: str) -> list[Path]:
        return [folder / pattern.format(stem) for pattern in _COLORS]

    def _inside(self, path: Path) -> Path:
        return inside(path, Path(self.root))

    def _label(self, folder: Path, stem: str, depth: ImageFile, count: int) -> Tensor:
        """(H, W) int64: each object's visible mask, by its number from 1."""
        label = torch.zeros(depth.height, depth.width, dtype=torch.int64)
        for number in range(1, count + 1):
            mask = label_file(self._inside(folder / "mask_visib" / f"{stem}_{number - 1:06d}.png"))
            check_same_size(mask, depth)
            label[torch.from_numpy(np.asarray(mask.decode()) > 0)] = number
        return label

    def _total_pixels(self, folder: Path, stem: str, count: int) -> dict[int, int]:
        """Pixels of each object as if nothing stood in front, where scene_gt_info.json tells."""
        file = self._inside(folder / "scene_gt_info.json")
        if not file.is_file():
            return {}
        told = entries(read_meta(file), stem)
        counts = [Meta(file, entry).number("px_count_all") for entry in told]
        if len(counts) != count or min(counts, default=0) < 0:
            raise FrameError(
                f"{file}: image {int(stem)} must have {count} objects, but has {len(counts)}; copy it again."
            )
        return {i: int(pixels) for i, pixels in enumerate(counts, start=1)}

    def _object(self, number: int, entry: dict[str, Any], folder: Path) -> ObjectTruth:
        file = folder / "scene_gt.json"
        model = entry.get("obj_id")
        if type(model) is not int:
            raise FrameError(f"{file}: obj_id must be a whole number, but is {shown(model)}; copy it again.")
        rotation = numbers(entry, "cam_R_m2c", 9, file).view(3, 3)
        if not torch.allclose(rotation @ rotation.T, torch.eye(3, dtype=torch.float64), atol=_RIGID):
            raise FrameError(
                f"{file}: cam_R_m2c must be a rotation, but is {shown(entry['cam_R_m2c'])}; copy it again."
            )
        pose = torch.eye(4, dtype=torch.float64)
        pose[:3, :3], pose[:3, 3] = rotation, numbers(entry, "cam_t_m2c", 3, file) / 1000.0
        truth = ObjectTruth(number, category=f"obj_{model:06d}")
        box = bounds(self._models, model)
        if box is None:
            return replace(truth, pose_camera=pose)
        low, extent = box
        pose[:3, 3] += rotation @ (low + extent / 2)
        return replace(truth, pose_camera=pose, half_extent=extent / 2)

    @cached_property
    def _models(self) -> Meta:
        """Sizes by model; empty where no file gives any."""
        for folder in ("models", "models_eval"):
            file = self._inside(Path(self.root) / folder / "models_info.json")
            if file.is_file():
                return read_meta(file)
        return Meta(Path(self.root), {})
