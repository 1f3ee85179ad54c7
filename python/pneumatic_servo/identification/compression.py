"""Tall matrices of least squares."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

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
