"""Long least-squares problems as short ones with the same costs, slopes and steps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Function = Callable[[Array], Array]

ROWS = 1000
"""Rows that are decomposed at once, as far as they are at least four times as many as the columns.

Longer blocks are shared among threads, which costs more than the decomposition of so few columns.
"""


def triangle(matrix: Array) -> Array:
    """Return the triangle of a QR decomposition: it has the same products of columns as the matrix."""
    columns = matrix.shape[1]
    size = max(ROWS, 4 * columns)
    whole = len(matrix) // size * size
    blocks = np.asarray(np.linalg.qr(matrix[:whole].reshape(-1, size, columns), mode="r"))
    return np.asarray(np.linalg.qr(np.vstack([blocks.reshape(-1, columns), matrix[whole:]]), mode="r"))


def compressed(residuals: Function, jacobian: Function) -> tuple[Function, Function]:
    """Return residuals and their derivatives as few as there are parameters, and one more.

    Least squares do not change as all residuals are rotated; a rotation, another one for each vector, makes them a
    single one, the root of their squares, and their derivatives a triangle.
    """

    def short(x: Array) -> Array:
        return np.append(np.linalg.norm(residuals(x)), np.zeros(len(x)))

    def slopes(x: Array) -> Array:
        found = triangle(np.column_stack([residuals(x), jacobian(x)]))
        return np.asarray(found[:, 1:] * np.copysign(1.0, found[0, 0]))

    return short, slopes
