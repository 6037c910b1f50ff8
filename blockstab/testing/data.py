"""Contracts of sets of scenes and of simulated sensors."""

from __future__ import annotations

import torch
from torch import Tensor

from blockstab.datasets.sets import SceneSet
from blockstab.simulation.sensors import Sensor


class SceneSetContract:
    """Tests of a `SceneSet`; `part` is one with a scene or more."""

    part: SceneSet

    def test_its_scenes_have_different_names_that_are_fit_for_folders(self) -> None:
        """And come in the same order each time."""
        names = self.part.scenes()
        assert names
        assert names == self.part.scenes()
        assert len(set(names)) == len(names)
        assert all(name and "/" not in name and name not in (".", "..") for name in names)

    def test_a_scene_is_an_image_of_that_name_and_its_truth(self) -> None:
        """What the truth speaks of, the labels have."""
        for name in self.part.scenes()[:3]:
            frame, truth = self.part.read(name)
            assert frame.name == name
            assert frame.depth.dtype == torch.float64
            assert frame.color.shape == (*frame.depth.shape, 3)
            assert set(truth.background_ids) == set(frame.background_ids)
            ids = [one.id for one in truth.objects]
            assert len(set(ids)) == len(ids)
            assert not set(ids) & set(frame.background_ids)

    def test_reading_twice_gives_the_same(self) -> None:
        """And the stamp stays while the files do."""
        name = self.part.scenes()[0]
        (one, _), (other, _) = self.part.read(name), self.part.read(name)
        assert torch.equal(one.depth, other.depth)
        assert self.part.stamp(name) == self.part.stamp(name) != ""

    def test_an_official_split_speaks_of_its_scenes(self) -> None:
        """Where there is one."""
        names = set(self.part.scenes())
        assert all(set(part) <= names for part in self.part.official().values())


class SensorContract:
    """Tests of a `Sensor`."""

    part: Sensor

    def test_depth_is_whole_millimetres_that_16_bits_hold(self) -> None:
        """0 where there is none."""
        distances = torch.logspace(-9, 6, self.part.width_px, dtype=torch.float64)
        millimetres = 1000 * self._seen(distances.expand(self.part.height_px, -1))
        assert millimetres.dtype == torch.float64
        assert torch.allclose(millimetres, millimetres.round(), rtol=0, atol=1e-6)
        assert 0 <= float(millimetres.min()) <= float(millimetres.max()) < 65535.5

    def test_a_wall_is_measured_without_bias(self) -> None:
        """At one metre, within a millimetre on average."""
        wall = self._wall(1.0)
        measured = self._seen(wall)
        there = measured > 0
        assert float(there.double().mean()) > 0.5
        assert abs(float((measured - wall)[there].mean())) < 0.001

    def test_its_error_is_what_its_camera_says(self) -> None:
        """On a wall at one metre: at most twice the standard deviation of inverse depth."""
        wall = self._wall(1.0)
        measured = self._seen(wall)
        there = measured > 0
        off = (1.0 / measured[there] - 1.0 / wall[there]).abs()
        assert float(off.square().mean().sqrt()) < 2.0 * self.part.camera.noise.deviation

    def test_it_draws_from_its_generator_alone_and_as_often_whatever_it_sees(self) -> None:
        """So that a scene does not depend on what was drawn for another."""
        before, after = torch.get_rng_state(), []
        for depth in (self._wall(1.0), torch.zeros_like(self._wall(1.0))):
            generator = torch.Generator().manual_seed(3)
            self._seen(depth, generator)
            after.append(generator.get_state())
        assert torch.equal(torch.get_rng_state(), before)
        assert torch.equal(*after)

    def test_what_is_given_is_not_changed(self) -> None:
        """A sensor makes a new image."""
        wall = self._wall(1.0)
        self._seen(wall)
        assert torch.equal(wall, self._wall(1.0))

    def _wall(self, distance: float) -> Tensor:
        across = torch.linspace(-0.03, 0.03, self.part.width_px, dtype=torch.float64)
        return (distance + distance**2 * across).expand(self.part.height_px, -1).contiguous()

    def _seen(self, depth: Tensor, generator: torch.Generator | None = None) -> Tensor:
        flat = torch.zeros_like(depth)
        lit, echo = torch.ones_like(depth, dtype=torch.bool), torch.ones_like(depth)
        return self.part.measure(depth, flat, lit, echo, generator or torch.Generator().manual_seed(0))
