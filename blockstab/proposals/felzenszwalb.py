"""The graph-based segmentation of Felzenszwalb and Huttenlocher (2004), on colour, normals and depth."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import torch
from skimage.segmentation import felzenszwalb
from torch import Tensor

from blockstab.observation import Observation
from blockstab.proposals import Proposed


@dataclass(frozen=True)
class Felzenszwalb:
    """Merge neighbouring pixels whose difference is small beside the differences within their regions.

    Args:
        scale: larger makes larger regions.
        blur_px: standard deviation of the blur before.
        least_px: a smaller region joins a neighbour.
        depth_m: difference of depth that weighs as much as that of black and white.
    """

    scale: float = 1000.0
    blur_px: float = 0.8
    least_px: int = 100
    depth_m: float = 0.3

    def __post_init__(self) -> None:
        if not (self.scale > 0 and self.depth_m > 0):
            raise ValueError(
                f"Scale and depth_m must be above 0, but are {self.scale} and {self.depth_m}; raise them."
            )

    def __call__(self, observation: Observation) -> Proposed:
        """Divide the image; pixels without depth belong to no region."""
        cloud = observation.cloud
        color = observation.frame.color.double() / 255.0
        channels = torch.cat([color, cloud.normals, cloud.depth[..., None] / self.depth_m], dim=2)
        with warnings.catch_warnings():
            # More than three channels make scikit-image suspect a volume.
            warnings.simplefilter("ignore", RuntimeWarning)
            regions = felzenszwalb(channels.numpy(), self.scale, self.blur_px, self.least_px)
        label: Tensor = torch.from_numpy(regions).to(torch.int64) + 1
        return Proposed(torch.where(cloud.valid, label, 0))
