"""Symmetric matrices of three rows, in machine code."""

from __future__ import annotations

import numpy as np
from numba import njit

_SWEEPS = 12  # each squares what is off the diagonal; after six, rounding is all that is left


@njit(error_model="numpy")
def least_axis(matrix, axis):
    """Write the unit eigenvector of the least eigenvalue of a symmetric matrix (3, 3), by turns of Jacobi (1846).

    The largest of its coordinates is positive, so that all machines have the same one.
    """
    values, vectors = matrix.copy(), np.eye(3)
    for _ in range(_SWEEPS):
        for p in range(2):
            for q in range(p + 1, 3):
                _turn(values, vectors, p, q)
    least = 0
    for k in range(1, 3):
        if values[k, k] < values[least, least]:
            least = k
    largest = 0
    for k in range(1, 3):
        if abs(vectors[k, least]) > abs(vectors[largest, least]):
            largest = k
    sign = -1.0 if vectors[largest, least] < 0 else 1.0
    for k in range(3):
        axis[k] = sign * vectors[k, least]


@njit(error_model="numpy")
def _turn(values, vectors, p, q):
    """One turn in the plane of two axes, after which the two do not mix."""
    mixed = values[p, q]
    if mixed == 0.0:
        return
    theta = (values[q, q] - values[p, p]) / (2 * mixed)
    tangent = (-1.0 if theta < 0 else 1.0) / (abs(theta) + np.sqrt(theta * theta + 1))
    cosine = 1 / np.sqrt(tangent * tangent + 1)
    sine = tangent * cosine
    for k in range(3):
        one, other = values[k, p], values[k, q]
        values[k, p], values[k, q] = cosine * one - sine * other, sine * one + cosine * other
    for k in range(3):
        one, other = values[p, k], values[q, k]
        values[p, k], values[q, k] = cosine * one - sine * other, sine * one + cosine * other
    values[p, q] = values[q, p] = 0.0
    for k in range(3):
        one, other = vectors[k, p], vectors[k, q]
        vectors[k, p], vectors[k, q] = cosine * one - sine * other, sine * one + cosine * other


@njit(error_model="numpy")
def solved(matrix, right):
    """The solution (3,) of a positive definite system, by the factor of Cholesky; `matrix` is overwritten."""
    for k in range(3):
        for j in range(k):
            for i in range(k, 3):
                matrix[i, k] -= matrix[i, j] * matrix[k, j]
        root = np.sqrt(matrix[k, k])
        for i in range(k, 3):
            matrix[i, k] /= root
    found = np.empty(3)
    for i in range(3):
        found[i] = right[i]
        for j in range(i):
            found[i] -= matrix[i, j] * found[j]
        found[i] /= matrix[i, i]
    for i in range(2, -1, -1):
        for j in range(i + 1, 3):
            found[i] -= matrix[j, i] * found[j]
        found[i] /= matrix[i, i]
    return found
