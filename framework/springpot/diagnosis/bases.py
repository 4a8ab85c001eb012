"""Orthonormal bases of what curves span."""

from __future__ import annotations

import numpy as np
from scipy.linalg import svd

from springpot.rheology import Real


def orthonormal(columns: Real, tolerance: float = 1e-9) -> Real:
    """Orthonormal basis of the column space; columns are scaled first, so that units do not matter."""
    size = np.sqrt(np.sum(columns * columns, axis=0))
    columns = columns[:, size > 0] / size[size > 0]
    if columns.shape[1] == 0:
        return np.zeros((len(columns), 0))
    try:
        u, s, _ = np.linalg.svd(columns, full_matrices=False)
    except np.linalg.LinAlgError:
        # The divide-and-conquer algorithm gives up on rare well-formed matrices; the older one does not.
        u, s, _ = svd(columns, full_matrices=False, lapack_driver="gesvd")
    return u[:, s > tolerance * s[0]]
