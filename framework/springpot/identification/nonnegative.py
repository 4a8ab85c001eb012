"""Non-negative least squares: the weights of a spectrum, none of which may be below zero."""

from __future__ import annotations

import numpy as np

from springpot.rheology import Real


def non_negative(columns: Real, target: Real) -> tuple[Real, float]:
    """Weights >= 0 of columns (m, q) that come nearest to a target (m,), and the sum of squares that is left.

    Raises
    ------
    RuntimeError
        If the active set does not settle.
    """
    from scipy.optimize import nnls  # loading the plugins must not take its time

    # Columns of one size: the active set is chosen by slopes, which depend on the units otherwise.
    size = np.linalg.norm(columns, axis=0)
    size = np.where(size > 0.0, size, 1.0)
    scaled = columns / size
    system, wanted = scaled, target
    if scaled.shape[0] > 2 * scaled.shape[1]:
        # The same problem in as many rows as columns: the active set then moves among small matrices.
        basis, system = np.linalg.qr(scaled)
        wanted = basis.T @ target
    weights, _ = nnls(system, wanted, maxiter=20 * scaled.shape[1])
    # From the columns themselves: a mass that a spring takes back would leave a difference of large squares.
    with np.errstate(all="ignore"):
        left = target - scaled @ weights
        cost = float(left @ left)
    # What is too large for a number is no fit.
    if not np.isfinite(cost):
        cost = np.inf
    return weights / size, cost
