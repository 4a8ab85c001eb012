"""Non-negative least squares: the weights of a spectrum, none of which may be below zero."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Real: TypeAlias = NDArray[np.float64]
ROUNDS = 20
"""Changes of the active set for each column, before another algorithm takes over.

A spectrum takes about one.
"""


def non_negative(columns: Real, target: Real) -> tuple[Real, float]:
    """Weights >= 0 of columns (m, q) that come nearest to a target (m,).

    With the sum of squares that is left.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.nonnegative import non_negative
    >>> weights, left = non_negative(np.eye(2), np.array([3.0, -4.0]))
    >>> weights, left
    (array([3., 0.]), 16.0)
    """
    from scipy.optimize import lsq_linear, nnls  # loading the plugins must not take its time

    # Columns of one size: the active set is chosen by slopes, which depend on the units otherwise.
    size = np.linalg.norm(columns, axis=0)
    # One whose squares are below any number is none.
    seen = size > 0.0
    size = np.where(seen, size, 1.0)
    scaled = np.where(seen, columns, 0.0) / size
    system, wanted = scaled, target
    if scaled.shape[0] > 2 * scaled.shape[1]:
        # The same problem in as many rows as columns: the active set then moves among small
        # matrices. With the target beside them no basis is needed, which would take twice as long.
        whole: Real = np.array(np.linalg.qr(np.column_stack([scaled, target]), mode="r"))
        system, wanted = whole[:-1, :-1], whole[:-1, -1]
    try:
        weights, _ = nnls(system, wanted, maxiter=ROUNDS * scaled.shape[1])
    except RuntimeError:
        # Where columns are nearly one, the active set may go round in circles; an inner point does
        # not.
        weights = lsq_linear(system, wanted, (0.0, np.inf)).x
    # From the columns themselves: a mass that a spring takes back would leave a difference of large
    # squares.
    with np.errstate(all="ignore"):
        left = target - scaled @ weights
        cost = float(left @ left)
    # What is too large for a number is no fit.
    if not np.isfinite(cost):
        cost = np.inf
    return weights / size, cost
