"""An organised point cloud as a frame: its depth, and the camera that its points tell."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from blockstab.datasets.formats.pcd import OrganisedCloud, read_cloud
from blockstab.datasets.truth import LARGEST_ID, ObjectTruth, Truth
from blockstab.rgbd.frame import Camera, Frame, check_depth
from blockstab.rgbd.reading import FrameError, label_file

_NEAREST, _FARTHEST = 1e-3, 1e3  # metres
_MISFIT_PX = 1.0
# A tangent, a twentieth of a pixel of most cameras: points within it lie on one line of sight.
_NARROWEST = 1e-4


def read_frame(path: Path, name: str) -> Frame:
    """Read an organised .pcd cloud, with the ids of its label field, if it has one, as they are.

    Raises:
        FrameError: as `read_cloud` and `fitted_camera`; a label is over 65535; or the median depth lies
            outside 0.1 to 20 m.
    """
    cloud = read_cloud(path)
    camera = fitted_camera(cloud, path)
    depth = np.nan_to_num(cloud.points[..., 2])
    check_depth(depth, path, "m")
    label = None if cloud.label is None else torch.from_numpy(_checked(cloud.label, path))
    return Frame(name, torch.from_numpy(cloud.color), torch.from_numpy(depth), camera, label)


def fitted_camera(cloud: OrganisedCloud, path: Path) -> Camera:
    """The pinhole camera that took an organised cloud.

    Its pixel (u, v) shows the point (x, y, z) with u z = fx x + cx z and v z = fy y + cy z: two linear least
    squares over all points.

    Args:
        path: of the cloud, for messages.

    Raises:
        FrameError: no camera in front of the points takes each within a pixel of its place.
    """
    height, width = cloud.points.shape[:2]
    v, u = np.nonzero(~np.isnan(cloud.points[..., 2]))
    points = cloud.points[v, u]
    x, y, z = points.T
    if not z.size or z.min() < _NEAREST or np.abs(points).max() > _FARTHEST:
        raise FrameError(
            f"{path}: must hold points in front of the camera, a millimetre to a kilometre away, but has "
            "none, or one elsewhere; write the cloud in metres and in the frame of its camera."
        )
    fx, cx, off_u = _line(x, z, u)
    fy, cy, off_v = _line(y, z, v)
    sane = fx > 0 and fy > 0 and 0 < cx < width and 0 < cy < height
    if not (sane and max(off_u, off_v) <= _MISFIT_PX):
        raise FrameError(
            f"{path}: must be what one pinhole camera saw, each point within {_MISFIT_PX:g} pixel of its place, but "
            f"the best camera (fx {fx:.4g}, fy {fy:.4g}, cx {cx:.4g}, cy {cy:.4g}) misses one by "
            f"{max(off_u, off_v):.3g}; write the cloud in the frame of its camera, its rows and columns kept."
        )
    return Camera(fx, fy, cx, cy)


def _line(
    across: NDArray[np.float64], z: NDArray[np.float64], pixel: NDArray[np.int64]
) -> tuple[float, float, float]:
    """Focal length and principal point along one axis, and the largest misfit, all in pixels."""
    sides = np.stack([across, z], axis=1)
    (focal, center), _, rank, _ = np.linalg.lstsq(sides, pixel * z, rcond=_NARROWEST)
    off = np.abs(sides @ (focal, center) - pixel * z) / z
    # Points all on one line of sight tell no focal length.
    return float(focal), float(center), float(off.max()) if rank == 2 else np.inf


def read_ids(path: Path, like: Frame) -> Tensor:
    """Read a label image, a PNG of one channel of 8 or 16 bits, that lies pixel upon pixel with a frame.

    Returns:
        (H, W) int64 ids.

    Raises:
        FrameError: the file is missing, damaged or of another size.
    """
    file, (height, width) = label_file(path), like.depth.shape
    if (file.width, file.height) != (width, height):
        raise FrameError(
            f"{path}: must have the {width} x {height} pixels of the depth of {like.name}, but has "
            f"{file.width} x {file.height}; register the images to one camera."
        )
    return torch.from_numpy(np.asarray(file.decode()).astype(np.int64))


def truth_of(label: Tensor, background_ids: tuple[int, ...]) -> Truth:
    """The truth that labels alone tell: every id that is neither 0 nor background is an object."""
    ids = torch.unique(label).tolist()
    objects = tuple(ObjectTruth(i) for i in ids if i and i not in background_ids)
    return Truth(background_ids, objects, None, support_annotated=False)


def inside(path: Path, root: Path) -> Path:
    """The path, if it leads to no place outside `root`.

    Raises:
        FrameError: it is a link that leads out, or to itself.
    """
    if not lies_in(path, root):
        raise FrameError(f"{path}: must lie in {root}, but links out of it; put a copy in its place.")
    return path


def lies_in(path: Path, root: Path) -> bool:
    """True if the path, links followed, leads to no place outside `root`."""
    try:
        return path.resolve().is_relative_to(root.resolve())
    except (OSError, RuntimeError):  # a link to itself
        return False


def _checked(label: NDArray[np.int64], path: Path) -> NDArray[np.int64]:
    if label.max() > LARGEST_ID:
        raise FrameError(
            f"{path}: labels must be at most {LARGEST_ID}, but one is {label.max()}; number the objects anew."
        )
    return label
