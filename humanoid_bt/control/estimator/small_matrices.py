"""Small matrices and rotations in machine code, for the functions of the estimator."""

from __future__ import annotations

import math

from humanoid_bt.core.compiled import inlined
from humanoid_bt.core.messages import Array
from humanoid_bt.core.turns import of_vector, product


@inlined
def factored(matrix: Array, size: int) -> None:
    """Write the Cholesky factor L of a symmetric matrix, M = L L^T, into its lower triangle.

    Args:
        matrix: positive definite, shape (size, size); only its lower triangle is read.
        size: of it.
    """
    for column in range(size):
        pivot = matrix[column, column]
        for k in range(column):
            pivot -= matrix[column, k] * matrix[column, k]
        pivot = math.sqrt(pivot)
        matrix[column, column] = pivot
        for row in range(column + 1, size):
            rest = matrix[row, column]
            for k in range(column):
                rest -= matrix[row, k] * matrix[column, k]
            matrix[row, column] = rest / pivot


@inlined
def solved(factor: Array, vector: Array) -> None:
    """Put the solution of L L^T x = b in the place of b; ``factor`` has L in its lower triangle."""
    size = len(vector)
    for row in range(size):
        for k in range(row):
            vector[row] -= factor[row, k] * vector[k]
        vector[row] /= factor[row, row]
    for row in range(size - 1, -1, -1):
        for k in range(row + 1, size):
            vector[row] -= factor[k, row] * vector[k]
        vector[row] /= factor[row, row]


@inlined
def times(sparse: Array, matrix: Array, product: Array) -> None:
    """Write the product of two matrices, the first one mostly zeros, into the first columns of a third one."""
    rows, middle = sparse.shape
    columns = matrix.shape[1]
    for i in range(rows):
        for j in range(columns):
            product[i, j] = 0.0
        for k in range(middle):
            share = sparse[i, k]
            if share != 0.0:
                for j in range(columns):
                    product[i, j] += share * matrix[k, j]


@inlined
def measured(covariance: Array, measures: Array, doubt: Array, innovation: Array, spread: Array) -> None:
    """Correct the covariance P of a Kalman filter by a measurement.

    With L L^T = H P H^T + R it leaves L^-1 (H P | error) = (A | b) in ``innovation``: A^T b corrects the state.

    Args:
        covariance: P, shape (n, n).
        measures: H, shape (m, n), mostly zeros.
        doubt: the diagonal of R, shape (m,).
        innovation: shape (m, n + 1); its last column is the error.
        spread: is written, shape (m, m).
    """
    rows, size = measures.shape
    times(measures, covariance, innovation)
    for i in range(rows):
        for j in range(i + 1):
            total = 0.0
            for k in range(size):
                total += innovation[i, k] * measures[j, k]
            spread[i, j] = total
        spread[i, i] += doubt[i]
    factored(spread, rows)
    for i in range(rows):
        for k in range(i):
            share = spread[i, k]
            for j in range(size + 1):
                innovation[i, j] -= share * innovation[k, j]
        for j in range(size + 1):
            innovation[i, j] /= spread[i, i]
    for i in range(size):
        for j in range(i + 1):
            total = (covariance[i, j] + covariance[j, i]) / 2
            for k in range(rows):
                total -= innovation[k, i] * innovation[k, j]
            covariance[i, j] = covariance[j, i] = total


@inlined
def turn(quaternion: Array, matrix: Array, x: float, y: float, z: float) -> None:
    """Turn an orientation by a rotation vector in its own frame [rad], and write its matrix, shape (3, 3), too."""
    now = quaternion[0], quaternion[1], quaternion[2], quaternion[3]
    w, i, j, k = product(now, of_vector(x, y, z))
    length = math.sqrt(w * w + i * i + j * j + k * k)
    w, i, j, k = w / length, i / length, j / length, k / length
    quaternion[0], quaternion[1], quaternion[2], quaternion[3] = w, i, j, k
    matrix[0, 0], matrix[0, 1], matrix[0, 2] = 1 - 2 * (j * j + k * k), 2 * (i * j - w * k), 2 * (i * k + w * j)
    matrix[1, 0], matrix[1, 1], matrix[1, 2] = 2 * (i * j + w * k), 1 - 2 * (i * i + k * k), 2 * (j * k - w * i)
    matrix[2, 0], matrix[2, 1], matrix[2, 2] = 2 * (i * k - w * j), 2 * (j * k + w * i), 1 - 2 * (i * i + j * j)
