"""One model fitted to many data sets on one grid, such as simulated ones, side by side."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from springpot.errors import OptionError
from springpot.rheology.model import Model
from springpot.rheology.points import Complex, Points, Real

from ..numerics import NEGLIGIBLE
from .leastsquares import Rows, Solution
from .native import CONFIRMED, NEAR, within_bounds
from .task import Task


def fit_batch(
    model: Model,
    points: Points,
    stiffness: Complex,
    weights: ArrayLike,
    starts: int = 8,
    seeds_theta: Real | None = None,
    logarithmic: bool = False,
) -> tuple[Real, Real]:
    """Fit one model to many data sets on one grid.

    Parameters
    ----------
    model : Model
        What is fitted.
    points : Points
        The n points.
    stiffness : ndarray of complex, shape (B, n)
        Data.
    weights : ndarray, shape (B, n)
        Complex: weights of the real parts and of the imaginary parts; real: of both alike. One for
        all, or shape (n,) for all data sets, serves too.
    starts : int
        Starts for a data set at most. The best one goes first; only data sets that are not yet at
        the noise-free level or whose optimum no second start has confirmed get more.
    seeds_theta : ndarray, shape (B, s, p), optional
        Given starts, taken before those read off the data.
    logarithmic : bool
        Compare ln K rather than K.

    Returns
    -------
    theta : ndarray, shape (B, p)
        The parameters.
    cost : ndarray, shape (B,)
        The sum of squared residuals.

    Raises
    ------
    OptionError
        If shapes do not fit each other, or a weight is no finite number from zero up.

    Examples
    --------
    >>> import numpy as np
    >>> import springpot
    >>> from springpot.identification import fit_batch
    >>> from springpot.rheology import Points
    >>> model, at = springpot.parse_model("kelvin"), Points.at([1.0, 3.0, 10.0])
    >>> data = model.stiffness(np.array([[2.0, 0.5], [3.0, 0.1]]), at)
    >>> fit_batch(model, at, data, np.ones(data.shape))[0].round(6)
    array([[2. , 0.5],
           [3. , 0.1]])
    """
    stiffness = np.asarray(stiffness, dtype=np.complex128)
    if stiffness.ndim != 2 or stiffness.shape[1] != points.omega.shape[-1]:
        raise OptionError(
            f"stiffness has the shape {stiffness.shape}: write (B, {points.omega.shape[-1]}), a row"
            " of all points for each data set; one data set is stiffness[None, :]"
        )
    task = Task(model, points, stiffness, _of_both_parts(weights, stiffness.shape), logarithmic)
    v = task.starts(starts)[0]
    if seeds_theta is not None:
        given = task.coordinates.u(
            np.asarray(seeds_theta, dtype=float), task.coordinates.size[:, None, :]
        )
        v = np.concatenate([task.shaped(given), v], axis=1)
    # The best scanned shape stands in until a descent has given something better.
    best, cost = v[:, 0].copy(), np.full(len(v), np.inf)
    _rounds(task, v, best, cost)
    solution = task.solve(task.full(best[:, None, :]), damping=NEAR)
    return (
        within_bounds(model, task.coordinates.theta(solution.u, task.coordinates.size)),
        solution.cost,
    )


def _of_both_parts(weights: ArrayLike, shape: tuple[int, ...]) -> Complex:
    """Weights as complex numbers of that shape; real ones weigh both parts of the data."""
    given = np.asarray(weights)
    if not np.iscomplexobj(given):
        # As a complex number a real weight would leave the imaginary part without any.
        given = given.astype(float) * (1.0 + 1.0j)
    try:
        full = np.broadcast_to(given, shape)
    except ValueError:
        raise OptionError(
            f"weights have the shape {given.shape}: write that of the stiffness, {shape}"
        ) from None
    if not np.isfinite(full).all() or (full.real < 0).any() or (full.imag < 0).any():
        raise OptionError(
            "weights must be finite and not negative, such as 1 over the standard deviations"
        )
    return np.asarray(full, dtype=np.complex128)


def _rounds(task: Task, v: Real, best: Real, cost: Real) -> None:
    """Search shapes from ever more of the starts (B, s, d); `best` and `cost` take the results."""
    rows, first, width, iterations = np.arange(len(v)), 0, 1, 15
    while len(rows) and first < v.shape[1]:
        # Most data sets are done with their best start: only the others get more starts, and more
        # steps for each.
        part = task
        if len(rows) < len(v):
            part = task.rows(rows)
        trials = v[rows, first : first + width]
        # What is best so far goes along: a new start that ends there confirms it.
        if first:
            trials = np.concatenate([best[rows, None], trials], axis=1)
        solution = part.solve_shapes(trials, iterations)
        agreed = _take_best(solution, best, cost, rows)
        rows = rows[~(agreed | (cost[rows] <= part.shape_floor))]
        first, width, iterations = first + width, width + (first > 0), 2 * iterations


def _take_best(solution: Solution, best: Real, cost: Real, rows: Rows) -> NDArray[np.bool_]:
    """Enter improvements.

    Says which data sets have now come to rest at their best objective from two starts.
    """
    starts = len(solution.cost) // len(rows)
    costs, at = solution.cost.reshape(len(rows), starts), solution.u.reshape(len(rows), starts, -1)
    which = np.argmin(costs, axis=1)
    least = costs[np.arange(len(rows)), which]
    # One that was stopped on its way may be as low by chance: only those at rest confirm.
    agree = solution.converged.reshape(costs.shape) & (costs <= least[:, None] * (1.0 + NEGLIGIBLE))
    better = least < cost[rows]
    best[rows[better]] = at[better, which[better]]
    cost[rows[better]] = least[better]
    agreed: NDArray[np.bool_] = np.sum(agree, axis=1) >= CONFIRMED
    return agreed
