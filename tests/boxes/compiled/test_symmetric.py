"""Symmetric matrices of three rows, against LAPACK."""

from __future__ import annotations

import numpy as np
import pytest

from blockstab.boxes.compiled.symmetric import least_axis, solved


def drawn(seed: int, least: float) -> tuple[np.ndarray, np.ndarray]:
    """A symmetric matrix of known eigenvalues, and its eigenvectors."""
    generator = np.random.default_rng(seed)
    vectors, _ = np.linalg.qr(generator.standard_normal((3, 3)))
    values = np.array([least, *(least + generator.uniform(0.1, 1.0, 2))])
    return (vectors * values) @ vectors.T, vectors


@pytest.mark.parametrize("least", [0.0, 1e-6, 0.5])
def test_the_axis_of_least_spread_is_that_of_lapack_with_its_largest_coordinate_positive(least):
    axis = np.empty(3)
    for seed in range(200):
        matrix, vectors = drawn(seed, least)
        least_axis(matrix, axis)
        assert abs(axis @ vectors[:, 0]) == pytest.approx(1.0, abs=1e-14)
        assert axis[np.abs(axis).argmax()] > 0


@pytest.mark.parametrize("matrix", [np.zeros((3, 3)), np.eye(3), np.diag([3.0, 1.0, 2.0])])
def test_what_is_diagonal_already_has_an_axis_of_its_frame(matrix):
    axis = np.empty(3)
    least_axis(matrix, axis)
    assert sorted(axis) == [0.0, 0.0, 1.0]
    assert matrix[axis.argmax(), axis.argmax()] == matrix.diagonal().min()


def test_systems_are_solved_as_by_lapack():
    for seed in range(200):
        matrix, _ = drawn(seed, 1e-3)
        right = np.random.default_rng(seed).standard_normal(3)
        expected = np.linalg.solve(matrix, right)
        assert solved(matrix.copy(), right) == pytest.approx(expected, rel=1e-9, abs=1e-12)
