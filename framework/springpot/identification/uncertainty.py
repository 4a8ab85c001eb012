"""How well the parameters are known: intervals from the Jacobian, from profiles of the objective, from bootstrap."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from springpot.rheology import Complex, Real

from .coordinates import WIDEST, Coordinates
from .leastsquares import Rows, levenberg_marquardt
from .native import Fit, fit_batch
from .task import Task

LEVEL = 0.95
"""Probability of an interval, where no other is asked for."""
RANK = 1e-10
"""Directions whose singular value is this small a fraction of the largest are not determined by the data."""
NUMBERS = 4_000_000
"""Simulated numbers held at once."""


def student(level: float, dof: float) -> float:
    """Two-sided quantile of Student's t: ``level`` of the distribution lies within plus and minus this value.

    Exact for one and two degrees of freedom, else by the expansion of Abramowitz and Stegun 26.7.5 (0.3 % at three).
    """
    tail = 0.5 * (1.0 + level)
    if dof <= 0:
        return float("inf")
    if dof < 2:
        return float(np.tan(np.pi * (tail - 0.5)))
    if dof < 3:
        return float((2 * tail - 1) * np.sqrt(2 / (4 * tail * (1 - tail))))
    z = NormalDist().inv_cdf(tail)
    terms = (
        (z**3 + z) / 4,
        (5 * z**5 + 16 * z**3 + 3 * z) / 96,
        (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / 384,
        (79 * z**9 + 776 * z**7 + 1482 * z**5 - 1920 * z**3 - 945 * z) / 92160,
    )
    return z + sum(term / dof ** (i + 1) for i, term in enumerate(terms))


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """What the Jacobian says about a fit.

    Parameters
    ----------
    fit : Fit
        The fit.
    absolute : bool
        Whether the weights are known standard deviations; otherwise the scatter of the residuals sets the scale.
    level : float
        Probability of the intervals.
    """

    fit: Fit
    absolute: bool
    level: float = LEVEL

    @classmethod
    def of(cls, fit: Fit, level: float = LEVEL) -> Uncertainty:
        """Intervals at `level`, in absolute terms where the objective uses given standard deviations."""
        return cls(fit, uses_sd(fit), level)

    @property
    def scale(self) -> float:
        """Standard deviation of a weighted residual."""
        if self.absolute:
            return 1.0
        return float(np.sqrt(self.fit.cost / self.fit.dof)) if self.fit.dof > 0 else float("inf")

    @property
    def quantile(self) -> float:
        """Standard deviations to the end of an interval."""
        return student(self.level, float("inf") if self.absolute else self.fit.dof)

    @cached_property
    def at_bound(self) -> NDArray[np.int64]:
        """-1 where a parameter rests on its lower bound or is as good as zero, 1 on its upper, 0 elsewhere (p,)."""
        low, high = (bound[0] for bound in self.fit.task.coordinates.bounds())
        log, u = self.fit.task.coordinates.log, self.fit.u
        linear = 1e-9 * np.where(np.isfinite(high - low), high - low, 1.0)
        free = log & (np.abs(np.where(np.isfinite(low), low, -WIDEST)) >= WIDEST)
        traceless = np.linalg.norm(self.fit.jacobian_u, axis=0) <= 1e-6 * np.linalg.norm(self._data_size)
        below = (u <= low + np.where(log, _slack(low), linear)) | (free & traceless & (u < 0))
        above = (u >= high - np.where(log, _slack(high), linear)) | (log & traceless & (u > 0))
        return np.where(below, -1, np.where(above, 1, 0))

    @cached_property
    def _data_size(self) -> Real:
        task = self.fit.task
        return np.abs(task.weights if task.logarithmic else task.weights * np.abs(task.stiffness))

    @cached_property
    def covariance(self) -> Real:
        """Covariance (p, p) in search coordinates; infinite variance where the data say nothing, 0 at a bound."""
        free = np.flatnonzero(self.at_bound == 0)
        inner = self.fit.jacobian_u[:, free]
        size = np.linalg.norm(inner, axis=0)
        size[size == 0] = 1.0
        _, values, directions = np.linalg.svd(inner / size, full_matrices=False)
        known = values > RANK * values.max(initial=0.0)
        spread = np.where(known, 1.0 / np.where(known, values, 1.0), 0.0)[:, None] * directions / size
        covariance = np.zeros((len(self.fit.u),) * 2)
        with np.errstate(invalid="ignore"):
            covariance[np.ix_(free, free)] = self.scale**2 * (spread.T @ spread)
        # A direction without a trace in the data takes all parameters along that have a part in it.
        lost = free[np.any(np.abs(directions[~known]) > 1e-3, axis=0)]
        covariance[lost, lost] = np.inf
        return np.nan_to_num(covariance, nan=np.inf, posinf=np.inf)

    @property
    def sd_u(self) -> Real:
        """Standard deviations (p,) in search coordinates: relative ones for logarithmic parameters."""
        return np.sqrt(np.diag(self.covariance))

    @cached_property
    def correlation(self) -> Real:
        """Correlation (p, p) of the parameters as printed; NaN where undetermined or at a bound."""
        fit = self.fit
        turn = fit.task.coordinates.slopes(fit.theta, fit.task.coordinates.size[0])
        with np.errstate(all="ignore"):
            covariance = turn @ self.covariance @ turn.T
            sd = np.sqrt(np.diag(covariance))
            correlation: Real = covariance / (sd[:, None] * sd[None, :])
        return correlation

    def interval(self) -> tuple[Real, Real]:
        """Ends (p,) of the intervals of all parameters; zero or infinite where the data give no end."""
        fit, coordinates = self.fit, self.fit.task.coordinates
        turn = _printed_slopes(fit)
        with np.errstate(invalid="ignore"):  # of a parameter on its bound nothing is known from here
            reach = self.quantile * spread_of(turn, self.covariance)
        low, high = ends(fit.theta, reach, coordinates.log, _bounds(fit))
        rest = np.flatnonzero(self.at_bound)
        for i in rest.tolist():
            low[i], high[i] = self._one_sided(i)
        return low, high

    def _one_sided(self, i: int) -> tuple[float, float]:
        """Interval of a parameter on its bound: in the parameter itself, as a logarithm has no end there."""
        fit, (lower, upper) = self.fit, _bounds(self.fit)
        slope = _linear_slope(fit, i)
        others = fit.jacobian_u[:, self.at_bound == 0]
        if others.size:
            slope = slope - others @ np.linalg.lstsq(others, slope, rcond=RANK)[0]
        size = float(np.linalg.norm(slope))
        # From a bound there is one way only: the whole tail lies on that side.
        side = student(2.0 * self.level - 1.0, float("inf") if self.absolute else fit.dof)
        reach = side * self.scale / size if size > 0 else float("inf")
        value = float(fit.theta[i])
        if self.at_bound[i] < 0:
            return float(lower[i]), min(value + reach, float(upper[i]))
        if np.isinf(upper[i]):
            # Compliances add where a stiffness has grown without limit, so its inverse has the finite interval.
            inverse = 1.0 / value + reach / value**2
            return max(1.0 / inverse, float(lower[i])) if np.isfinite(inverse) else float(lower[i]), float("inf")
        return max(value - reach, float(lower[i])), float(upper[i])


def _slack(bound: Real) -> Real:
    """How near to its bound a logarithm counts as resting there.

    Zero and infinity are no places: whatever comes near the end of the range has gone there. A bound that a user
    gives is one.
    """
    return np.where(np.abs(bound) >= WIDEST, 0.5, 1e-6)


def uses_sd(fit: Fit) -> bool:
    """Whether the objective weighs each difference by its given standard deviation."""
    sd = fit.measurement.sd
    if sd is None or fit.objective.logarithmic:
        return False
    weights = fit.task.weights[0]
    return bool(np.allclose(weights.real * sd.real, 1.0) and np.allclose(weights.imag * sd.imag, 1.0))


def spread_of(turn: Real, covariance: Real) -> Real:
    """Standard deviations (q,) of what depends on u by `turn` (q, p); infinite where undetermined."""
    lost = np.isinf(np.diag(covariance))
    known = np.where(lost[:, None] | lost[None, :], 0.0, covariance)
    spread = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", turn, known, turn), 0.0))
    touched = np.any((np.abs(turn) > 1e-9) & lost, axis=1) | ~np.all(np.isfinite(turn), axis=1)
    return np.where(touched, np.inf, spread)


def ends(value: Real, reach: Real, log: NDArray[np.bool_], bounds: tuple[Real, Real]) -> tuple[Real, Real]:
    """Ends of intervals: a factor exp(reach) either way for logarithmic parameters, plus and minus for others."""
    with np.errstate(all="ignore"):
        factor = np.exp(np.where(log, reach, 0.0))
        low = np.where(log, value / factor, value - np.where(log, 0.0, reach))
        high = np.where(log, value * factor, value + np.where(log, 0.0, reach))
    return np.maximum(low, bounds[0]), np.minimum(high, bounds[1])


def _bounds(fit: Fit) -> tuple[Real, Real]:
    parameters = fit.model.parameters
    return np.array([p.lower for p in parameters]), np.array([p.upper for p in parameters])


def _printed_slopes(fit: Fit) -> Real:
    """Derivative (p, p) of ln theta (logarithmic parameters) or theta (others) by the search coordinates."""
    coordinates = fit.task.coordinates
    turn = coordinates.slopes(fit.theta, coordinates.size[0])
    scale: Real = np.where(coordinates.log, np.where(fit.theta == 0.0, 1.0, fit.theta), 1.0)
    return turn / scale[:, None]


def _linear_slope(fit: Fit, i: int) -> Real:
    """Derivative (2n,) of the residuals by parameter i itself."""
    jacobian = fit.model.jacobian(fit.theta, fit.measurement.points)[:, i]
    weights = fit.task.weights[0]
    if fit.task.logarithmic:
        jacobian = jacobian / fit.model.stiffness(fit.theta, fit.measurement.points)
    slope: Real = np.nan_to_num(np.concatenate([jacobian.real * weights.real, jacobian.imag * weights.imag]))
    return slope


def profile(fit: Fit, parameter: str, level: float = LEVEL) -> tuple[float, float]:
    """Profile-likelihood interval of one parameter: all others are refitted while it is held.

    Parameters
    ----------
    fit : Fit
        The fit.
    parameter : str
        Name of the parameter.
    level : float
        Probability.

    Returns
    -------
    low, high : float
        Where the best objective has risen by the quantile's square; a bound or infinity where it never does.

    Notes
    -----
    D. J. Venzon and S. H. Moolgavkar, 1988, doi:10.2307/2347496.
    """
    known = Uncertainty.of(fit, level)
    i = fit.model.names.index(parameter)
    allowed = fit.cost + known.quantile**2 * (1.0 if known.absolute else fit.cost / max(fit.dof, 1))
    if fit.dof <= 0 and not known.absolute:
        allowed = float("inf")
    path = _Path.of(fit, i)
    step = _first_step(known, i, path.coordinates)
    low, high = (path.crossing(sign, step, allowed) for sign in (-1.0, 1.0))
    lower, upper = (float(bound[i]) for bound in _bounds(fit))
    # Where the objective never rises that far, the interval ends at the bound of the parameter.
    if low is not None:
        lower = max(low, lower)
    if high is not None:
        upper = min(high, upper)
    return lower, upper


def held_costs(fit: Fit, parameter: str, values: Real) -> Real:
    """Best objectives with one parameter held at each of some values and all others refitted.

    Parameters
    ----------
    fit : Fit
        The fit.
    parameter : str
        Name of the parameter.
    values : ndarray, shape (m,)
        Where it is held, in SI.

    Returns
    -------
    ndarray, shape (m,)
        The objectives.
    """
    i = fit.model.names.index(parameter)
    path = _Path.of(fit, i)
    held = np.asarray(values, dtype=float) / float(path.coordinates.size[0, i])
    return path.costs(np.log(held) if path.coordinates.log[i] else held)


def _first_step(known: Uncertainty, i: int, plain: Coordinates) -> float:
    """Standard deviation of parameter i in plain coordinates, or a small step where there is none."""
    sd = float(spread_of(_printed_slopes(known.fit)[i : i + 1], known.covariance)[0])
    sd /= 1.0 if plain.log[i] else float(plain.size[0, i])
    return sd if np.isfinite(sd) and sd > 0 else 1e-3


@dataclass(frozen=True, eq=False)
class _Path:
    """The best fits along one parameter.

    The coordinate of the solver for a constant of a springpot mixes it with the order: held there, it would move.
    So the coordinates here are plain: each parameter or its logarithm.
    """

    task: Task
    u: Real
    i: int

    @classmethod
    def of(cls, fit: Fit, i: int) -> _Path:
        plain = replace(fit.task.coordinates, pairs=())
        return cls(replace(fit.task, given=plain), plain.u(fit.theta, plain.size[0]), i)

    @property
    def coordinates(self) -> Coordinates:
        return self.task.coordinates

    def crossing(self, sign: float, sd: float, allowed: float) -> float | None:
        """Value of the parameter where its profile reaches `allowed` on one side; None if it never does."""
        bounds = self.coordinates.bounds()
        start = float(self.u[self.i])
        room = abs(float(bounds[0 if sign < 0 else 1][0, self.i]) - start)
        # Doubled from half a deviation on: an interval may be far longer than the Jacobian says.
        inner, steps = 0.0, sd * 2.0 ** np.arange(-1.0, 12.0)
        if np.isfinite(room):
            steps = np.geomspace(min(0.5 * sd, room), room, 16) if room > 0.0 else np.zeros(1)
        for _ in range(4):
            over = np.flatnonzero(self.costs(start + sign * steps) > allowed)
            if not len(over):
                return None
            k = int(over[0])
            outer, inner = float(steps[k]), float(steps[k - 1]) if k else inner
            if outer - inner <= 1e-4 * outer:
                break
            steps = np.linspace(inner, outer, 10)[1:]
        end, size = start + sign * outer, float(self.coordinates.size[0, self.i])
        return size * (float(np.exp(end)) if self.coordinates.log[self.i] else end)

    def costs(self, held: Real) -> Real:
        """Best objective with the parameter held at each of `held`."""
        lower, upper = (np.repeat(bound, len(held), axis=0) for bound in self.coordinates.bounds())
        lower[:, self.i] = upper[:, self.i] = held
        u = np.tile(self.u, (len(held), 1))
        u[:, self.i] = held
        owner: Rows = np.zeros(len(held), dtype=np.intp)
        solve = levenberg_marquardt
        return solve(self.task.evaluator(owner), u, lower, upper, floor=0.0, flat=1e-9, iterations=60).cost


def bootstrap(fit: Fit, n: int, rng: np.random.Generator, *, parametric: bool = True) -> Real:
    """Refit simulated data.

    Parameters
    ----------
    fit : Fit
        The fit that is taken for the truth.
    n : int
        Number of simulated data sets.
    rng : numpy.random.Generator
        The only source of randomness.
    parametric : bool
        Draw Gaussian errors; otherwise draw from the residuals, with replacement.

    Returns
    -------
    ndarray, shape (n, p)
        Their parameters. Quantiles of a column are an interval (B. Efron, 1979, doi:10.1214/aos/1176344552).
    """
    points = len(fit.measurement)
    block = max(1, NUMBERS // (2 * points))
    found = []
    for first in range(0, n, block):
        errors = _errors(fit, min(block, n - first), rng, parametric)
        found.append(_refitted(fit, errors))
    return np.concatenate(found)


def _errors(fit: Fit, n: int, rng: np.random.Generator, parametric: bool) -> Complex:
    """Simulated weighted errors (n, points)."""
    size, count = Uncertainty.of(fit).scale, len(fit.measurement)
    if parametric:
        drawn = rng.standard_normal((n, 2 * count)) * size
    else:
        grown = np.sqrt(2 * count / max(fit.dof, 1))
        drawn = rng.choice(fit.residual * grown, size=(n, 2 * count))
    errors: Complex = drawn[:, :count] + 1j * drawn[:, count:]
    return errors


def _refitted(fit: Fit, errors: Complex) -> Real:
    weights = fit.task.weights[0]
    shift = errors.real / weights.real + 1j * (errors.imag / weights.imag)
    base = fit.model.stiffness(fit.theta, fit.measurement.points)
    data = base * np.exp(shift) if fit.objective.logarithmic else base + shift
    seeds = np.broadcast_to(fit.theta, (len(data), 1, len(fit.theta)))
    points = fit.measurement.points
    return fit_batch(
        fit.model, points, data, weights, starts=2, seeds_theta=seeds, logarithmic=fit.objective.logarithmic
    )[0]
