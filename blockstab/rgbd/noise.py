"""Depth noise of sensors with two eyes, which grows with the square of distance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from torch import Tensor


@dataclass(frozen=True)
class DepthNoise:
    """Resolution and error of a depth sensor; even in inverse depth, as for all that triangulate.

    Args:
        step: 1/m; at z metres, depths closer than `step * z ** 2` metres are not told apart.
        deviation: standard deviation of inverse depth, 1/m.
        baseline_m: between the two eyes, at most; 0 where there is one. What only one of them sees has no depth.

    Raises:
        ValueError: step and deviation are not above 0, or the baseline is below.
    """

    step: float = 2.9e-3
    deviation: float = 1.5e-3
    baseline_m: float = 0.08

    def __post_init__(self) -> None:
        if not (self.step > 0 and self.deviation > 0 and self.baseline_m >= 0):
            raise ValueError(
                f"Depth noise has a step and a deviation above 0 and a baseline from 0, but they are {self.step}, "
                f"{self.deviation} and {self.baseline_m}; correct them."
            )

    def at(self, squared: Tensor) -> Tensor:
        """Steps (...) in metres at distances whose squares (...) are given, square metres."""
        return self.step * squared

    @property
    def coarseness(self) -> float:
        """Times the step of a Kinect: what thresholds that were chosen for one must grow by."""
        return self.step / KINECT.step


KINECT = DepthNoise()
"""Structured light, Kinect v1 and Xtion: a step of 2.9e-3 z^2 m (Gupta et al. 2013) and a random error of
1.425e-3 z^2 m (Khoshelham and Oude Elberink 2012); 7.5 cm between projector and camera."""

REALSENSE = DepthNoise(step=5.2e-3, deviation=2.6e-3, baseline_m=0.055)
"""Active stereo, D435: disparity errs by 0.08 pixels at 5 cm and 615 pixels of focal length (Grunnet-Jepsen et al.,
Best-Known-Methods for Tuning Intel RealSense D400 Depth Cameras for Best Performance); a step of twice that."""

IDEAL = DepthNoise(step=1e-3, deviation=5e-4, baseline_m=0.0)
"""Depth without error, but for the millimetres that it is stored in."""

NOISES = {"kinect": KINECT, "realsense": REALSENSE, "ideal": IDEAL}


def noise_from(said: Any) -> DepthNoise:
    """Noise as a scene's `meta.json` says it: a name of `NOISES`, or the numbers of one.

    Raises:
        ValueError: it is neither.
    """
    if isinstance(said, str) and said in NOISES:
        return NOISES[said]
    numbers = said if isinstance(said, dict) else None
    if numbers is None or not all(type(value) in (int, float) for value in numbers.values()):
        raise ValueError(
            f"depth_noise must be one of {', '.join(NOISES)}, or an object with the numbers step, deviation and "
            f"baseline_m, but it is {said!r:.80}"
        )
    try:
        return DepthNoise(**numbers)
    except (TypeError, ValueError) as error:
        raise ValueError(f"depth_noise: {error}") from None
