"""Intervals beyond those of slopes: profiles of the objective, and fits of simulated data."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from springpot.distributions import autoregressive, student
from springpot.errors import OptionError
from springpot.numerics import ALIKE, AT_ONCE, FAR, NEGLIGIBLE, PRINTED, ROUNDING
from springpot.rheology.model import Model
from springpot.rheology.parameters import Coordinates
from springpot.rheology.points import Complex, Points, Real
from springpot.thresholds import INTERVAL

from .leastsquares import WHOLE, Evaluate, Rows, Solution, levenberg_marquardt
from .native import CONFIRMED, NEAR, Fit, within_bounds
from .normal import Equations, matrix_of
from .task import Task
from .uncertainty import Uncertainty, ends, printed_spread
from .value import LOST

IDENTIFIABLE = "identifiable", "practically not", "not at all"
"""Whether data tell a parameter.

Its interval has two ends, three decades apart at most; it has not, though a value fits best or one
end is known; or other parameters make up for whatever it is.
"""
NOTHING = 1e-3
"""Share of the rise at an interval's end that is none: what is left of a search's tolerance."""


def profile(fit: Fit, parameter: str, level: float = INTERVAL) -> tuple[float, float]:
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
        Where the best objective has risen by the quantile's square; a bound or infinity where it
        never does.

    Notes
    -----
    D. J. Venzon and S. H. Moolgavkar, 1988, doi:10.2307/2347496. Of specimens that were fitted
    together the rise is that of a parameter that scatters as they do (A. Rotnitzky and N. P.
    Jewell, 1990, doi:10.1093/biomet/77.3.485).

    Examples
    --------
    >>> import springpot
    >>> from springpot.identification import fit, profile
    >>> data = springpot.read("artificial-hidden@frequency=..1")
    >>> best = fit(springpot.parse_model("fractional-maxwell"), data)
    >>> low, high = profile(best, "alpha")
    >>> bool(low < best.theta[best.model.names.index("alpha")] < high)
    True
    """
    found = profiled(Uncertainty.of(fit, level), fit.model.names.index(parameter))
    return found.low, found.high


class Profile(NamedTuple):
    """What the best fits along one parameter tell of it.

    Attributes
    ----------
    low, high : float
        Ends of its interval.
    verdict : str
        One of `IDENTIFIABLE`.
    """

    low: float
    high: float
    verdict: str


def profiled(known: Uncertainty, i: int) -> Profile:
    """The profile of parameter i; see `profile`."""
    fit = known.fit
    rise = known.widening(i) * (allowed_cost(known) - fit.cost)
    path = Path.of(fit, i)
    return path.profile(_first_step(known, i, path.coordinates), fit.cost, rise)


def allowed_cost(known: Uncertainty) -> float:
    """The objective at the ends of a profile's interval."""
    fit = known.fit
    # Nothing is left over from which the scatter could be known: no rise is too much for it.
    if not np.isfinite(known.scale):
        return float("inf")
    # t^2 is F with one degree of freedom: the rise that a single parameter is allowed.
    return fit.cost + (known.quantile * known.scale) ** 2


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

    Examples
    --------
    >>> import springpot
    >>> from springpot.identification import fit, held_costs
    >>> data = springpot.read("artificial-hidden@frequency=..1")
    >>> best = fit(springpot.parse_model("fractional-maxwell"), data)
    >>> bool((held_costs(best, "alpha", [0.4, 0.6]) > best.cost).all())
    True
    """
    i = fit.model.names.index(parameter)
    path = Path.of(fit, i)
    places = np.asarray(values, dtype=float) / float(path.coordinates.size[0, i])
    if path.coordinates.log[i]:
        places = np.log(places)
    return path.costs(places)


def bent(known: Uncertainty) -> list[int]:
    """Parameters along whose valley the objective goes otherwise than by its slopes at the fit.

    To the ends of an interval by slopes it rises by what these foretell where they hold (Bates and
    Watts 1980, doi:10.1111/j.2517-6161.1980.tb01094.x); where it has risen to twice that, or half
    of it, the interval is not what they say.
    """
    fit, covariance = known.fit, known.covariance
    # Blocks of levels and the scatter of specimens have rules of their own; on its way a search is
    # in no valley.
    if fit.by_level is not None or known.specimens is not None or not fit.converged:
        return []
    rows = np.flatnonzero(known.at_bound == 0)
    spread = np.sqrt(np.diag(matrix_of(covariance)))
    # Of computed data the objective rises by rounding alone, and no interval has a digit.
    seen = known.quantile * spread[rows] > NEGLIGIBLE
    rows = rows[np.isfinite(spread[rows]) & seen]
    steps = known.quantile * matrix_of(covariance)[rows] / spread[rows, None]

    def evaluate(u: Real, numbers: Rows) -> tuple[Real, Real]:
        return fit.task.evaluator(np.zeros(len(u), dtype=np.intp))(u, numbers)

    off = off_their_slopes(evaluate, fit.u, steps, fit.task.coordinates.bounds)
    return [int(i) for i in rows[off]]


def off_their_slopes(
    evaluate: Evaluate, u: Real, steps: Real, bounds: tuple[Real, Real]
) -> NDArray[np.bool_]:
    """Whether along each of some steps the objective rises otherwise than by its slopes.

    To twice of what they foretell on one side at least, or to half of it.

    Parameters
    ----------
    evaluate : callable
        Residuals and their slopes by the coordinates, as `levenberg_marquardt` asks for them.
    u : ndarray, shape (p,)
        The best fit.
    steps : ndarray, shape (r, p)
        From it to one end of each interval, and as far to the other one.
    bounds : tuple of ndarray, each of shape (1, p)
        Of the coordinates.

    Returns
    -------
    ndarray of bool, shape (r,)
    """
    both = np.concatenate([steps, -steps])
    low, high = (bound[0] for bound in bounds)
    places = np.concatenate([u[None], np.clip(u + both, low, high)])
    with np.errstate(all="ignore"):
        residual, slopes = evaluate(places, np.arange(len(places)))
        by_slopes, objective = both @ slopes[0], np.sum(residual**2, axis=1)
        # A search may rest a little beside the bottom, from where one side falls at first.
        risen = objective[1:] - objective[0] - 2.0 * by_slopes @ residual[0]
        risen /= np.sum(by_slopes**2, axis=1)
    off = np.reshape(~((risen > 0.5) & (risen < 2.0)), (2, -1))
    return np.asarray(off.any(axis=0))


def _first_step(known: Uncertainty, i: int, plain: Coordinates) -> float:
    """Standard deviation of parameter i in plain coordinates."""
    sd = float(printed_spread(known.fit, known.covariance)[i])
    if not plain.log[i]:
        sd /= float(plain.size[0, i])
    return sd


@dataclass(frozen=True, eq=False)
class Path:
    """The best fits along one parameter.

    The coordinate of the solver for a constant of a springpot mixes it with the order: held there,
    it would move. So the coordinates here are plain: each parameter or its logarithm.

    Parameters
    ----------
    coordinates : Coordinates
        Without pairs.
    u : ndarray, shape (p,)
        The best fit in these.
    i : int
        Number of the parameter.
    evaluate : callable
        Residuals and their slopes by the coordinates, as `levenberg_marquardt` asks for them.
    equations : Equations
        How these are squared.
    """

    coordinates: Coordinates
    u: Real
    i: int
    evaluate: Evaluate
    equations: Equations = WHOLE

    @classmethod
    def of(cls, fit: Fit, i: int) -> Path:
        """That of a parameter of a fit."""
        plain = replace(fit.task.coordinates, pairs=())
        task = replace(fit.task, given=plain)

        def evaluate(u: Real, rows: Rows) -> tuple[Real, Real]:
            # All places are of the one data set.
            return task.evaluator(np.zeros(len(u), dtype=np.intp))(u, np.arange(len(u)))

        return cls(plain, plain.u(fit.theta, plain.size[0]), i, evaluate, task.equations)

    def profile(self, step: float, cost: float, rise: float) -> Profile:
        """Where the best objective has risen by so much from its least, and what that tells.

        The verdicts are those of Raue et al. 2009, doi:10.1093/bioinformatics/btp358.
        """
        # Any step will do where the slopes know none: the search along the profile doubles it.
        low, high = self.interval(step if 0.0 < step < np.inf else 1e-3, cost + rise)
        told = np.isfinite([low, high])
        if log := bool(self.coordinates.log[self.i]):
            told &= np.array([low, high]) > 0.0
        yes, practically, never = IDENTIFIABLE
        if told.all() and not (log and high > LOST * low):
            return Profile(low, high, yes)
        places = self._about()
        moved = np.tile(self.u, (len(places), 1))
        moved[:, self.i] = places
        residual, _ = self.evaluate(moved, np.arange(len(places)))
        alone = np.sum(residual**2, axis=1) - cost > NOTHING * rise
        flat = self.costs(places) - cost <= NOTHING * rise
        # What others make up for, or what nothing shows on either side.
        if np.any(alone & flat) or (flat.all() and not told.any()):
            return Profile(low, high, never)
        return Profile(low, high, practically)

    def _about(self) -> Real:
        """A place on either side: half and twice the parameter, or as far as there is room."""
        ends = np.array([bound[0, self.i] for bound in self.coordinates.bounds])
        start, reach = float(self.u[self.i]), np.log(2.0)
        if not self.coordinates.log[self.i]:
            reach = max(0.5 * abs(start), 0.1)
        return np.asarray(np.clip(start + reach * np.array([-1.0, 1.0]), *ends))

    def interval(self, step: float, allowed: float) -> tuple[float, float]:
        """Where the best objective has risen to `allowed` on either side, else the bounds."""
        parameter = self.coordinates.parameters[self.i]
        low, high = (self.crossing(sign, step, allowed) for sign in (-1.0, 1.0))
        lower, upper = parameter.lower, parameter.upper
        # Where the objective never rises that far, the interval ends at the bound of the parameter.
        if low is not None:
            lower = max(low, lower)
        if high is not None:
            upper = min(high, upper)
        return lower, upper

    def crossing(self, sign: float, sd: float, allowed: float) -> float | None:
        """Value of the parameter where its profile reaches `allowed` on one side.

        None if it never does.
        """
        limit, upper = self.coordinates.bounds
        if sign > 0:
            limit = upper
        start = float(self.u[self.i])
        room = abs(float(limit[0, self.i]) - start)
        # Doubled from half a deviation on: an interval may be far longer than the Jacobian says.
        inner, steps = 0.0, sd * 2.0 ** np.arange(-1.0, 12.0)
        if np.isfinite(room):
            steps = np.zeros(1)
            if room > 0.0:
                steps = np.geomspace(min(0.5 * sd, room), room, 16)
        # The coarse way first, then in nine pieces a round.
        for _ in range(4):
            over = np.flatnonzero(self.costs(start + sign * steps) > allowed)
            if not len(over):
                return None
            first = int(over[0])
            outer = float(steps[first])
            if first:
                inner = float(steps[first - 1])
            if outer - inner <= PRINTED * outer:
                break
            steps = np.linspace(inner, outer, 10)[1:]
        end, size = start + sign * outer, float(self.coordinates.size[0, self.i])
        if self.coordinates.log[self.i]:
            end = float(np.exp(end))
        return size * end

    def costs(self, places: Real) -> Real:
        """Best objective with the parameter held at each of `places`."""
        return self.held(places).cost

    def held(self, places: Real) -> Solution:
        """The best fits with the parameter held at each of `places`."""
        lower, upper = (np.repeat(bound, len(places), axis=0) for bound in self.coordinates.bounds)
        # Bounds that meet hold a parameter in place without a solver of its own.
        lower[:, self.i] = upper[:, self.i] = places
        # All places begin at the best fit, and are solved side by side.
        u = np.tile(self.u, (len(places), 1))
        u[:, self.i] = places
        return levenberg_marquardt(
            self.evaluate,
            u,
            lower,
            upper,
            flat=ALIKE,
            iterations=60,
            equations=self.equations,
        )

    def beside_others(self, rise: float) -> Iterator[tuple[Real, Real]]:
        """Ends of all intervals where this parameter, which has no end, is of a natural size.

        By the slopes there; none where the best fit is worse by more than `rise`.
        """
        at, log, size = self.coordinates, self.coordinates.log, self.coordinates.size[0]
        least = float(np.sum(self.evaluate(self.u[None], np.arange(1))[0] ** 2))
        near = replace(self, u=np.where(log & (np.abs(self.u) > FAR), 0.0, self.u))
        # A factor of e either way, as the very size may be more than the data allow.
        found = near.held(np.array([-1.0, 0.0, 1.0]))
        good = found.u[found.cost - least <= rise]
        if not len(good):
            return
        _, slopes = self.evaluate(good, np.arange(len(good)))
        lower = np.array([each.lower for each in at.parameters])
        upper = np.array([each.upper for each in at.parameters])
        for u, by_u in zip(good, slopes, strict=True):
            reach = np.sqrt(rise * np.diag(inverse_of(by_u @ by_u.T)))
            # No end of an interval that says nothing is a number.
            reach[log & (2.0 * reach > np.log(LOST))] = np.inf
            theta = at.theta(u, size)
            low, high = ends(theta, np.where(log, reach, reach * size), log, (lower, upper))
            # How far this one goes itself its own slopes say, or that it is here.
            low[self.i] = high[self.i] = theta[self.i]
            yield low, high


def inverse_of(information: Real) -> Real:
    """Covariance (p, p): a direction without information has an endless one."""
    scale = np.sqrt(np.maximum(np.diag(information), ROUNDING))
    scaled = information / np.outer(scale, scale) + ROUNDING * np.eye(len(scale))
    covariance: Real = np.linalg.inv(scaled) / np.outer(scale, scale)
    return covariance


def beside_endless(paths: Iterable[Path], rise: float, low: Real, high: Real) -> tuple[Real, Real]:
    """Intervals (p,) by the slopes, and by those where a parameter without an end is elsewhere.

    At a limit, such as a spring that does not give, the slopes tell only what is beside it: a
    fit as good with that parameter of a natural size may have all others elsewhere.

    Parameters
    ----------
    paths : iterable of Path
        One for each parameter.
    rise : float
        Of the objective, at the ends of an interval.
    low, high : ndarray, shape (p,)
        By the slopes at the best fit.
    """
    lows, highs = [low], [high]
    for path, least, most in zip(paths, low, high, strict=True):
        if path.coordinates.log[path.i] and not most <= LOST * least:
            for each in path.beside_others(rise):
                lows.append(each[0])
                highs.append(each[1])
    return np.min(lows, axis=0), np.max(highs, axis=0)


def bootstrap(fit: Fit, n: int, rng: np.random.Generator) -> Real:
    """Refit data that are simulated with normal errors.

    Parameters
    ----------
    fit : Fit
        The fit that is taken for the truth.
    n : int
        Number of simulated data sets.
    rng : numpy.random.Generator
        The only source of randomness.

    Returns
    -------
    ndarray, shape (n, p)
        Their parameters. Quantiles of a column are an interval (B. Efron, 1979,
        doi:10.1214/aos/1176344552).

    Examples
    --------
    >>> import numpy as np
    >>> import springpot
    >>> from springpot.identification import bootstrap, fit
    >>> data = springpot.read("artificial-hidden@frequency=..1")
    >>> best = fit(springpot.parse_model("kelvin"), data)
    >>> bootstrap(best, 5, np.random.default_rng(1)).shape
    (5, 2)
    """
    points = len(fit.measurement)
    # In blocks, as all simulated data at once may be more than memory holds.
    block = max(1, AT_ONCE // (2 * points))
    refitted = []
    for first in range(0, n, block):
        refitted.append(_refitted(fit, _errors(fit, min(block, n - first), rng)))
    return np.concatenate(refitted)


def over_specimens(known: Uncertainty, n: int, rng: np.random.Generator) -> Real:
    """Refit files that are drawn anew, with replacement.

    How parameters scatter when other specimens are tested.

    Parameters
    ----------
    known : Uncertainty
        Of a fit of several specimens.
    n : int
        Number of draws.
    rng : numpy.random.Generator
        The only source of randomness.

    Returns
    -------
    ndarray, shape (n, p)
        Their parameters, spread about the fit as Student's t asks of so few specimens: among G of
        them a draw scatters too little by (G - 1) / G, and no draw lies beyond the most extreme of
        them (T. C. Hesterberg, 2015, doi:10.1080/00031305.2015.1089789).
    """
    fit, specimens = known.fit, known.specimens
    assert specimens is not None, "of a fit of several specimens"
    count = specimens.count
    drawn = rng.multinomial(count, np.full(count, 1.0 / count), size=n)[:, specimens.number]
    # A file that was drawn twice counts twice; one that was not, not at all.
    weights = np.sqrt(drawn) * fit.task.weights[0]
    measured = np.broadcast_to(fit.measurement.stiffness, weights.shape)
    seeds = np.broadcast_to(fit.theta, (n, 1, len(fit.theta)))
    points, logarithmic = fit.measurement.points, fit.objective.logarithmic
    theta = fit_batch(fit.model, points, measured, weights, 2, seeds, logarithmic)[0]
    wider = known.quantile / student(known.level, np.inf) * np.sqrt(count / (count - 1))
    log = fit.task.coordinates.log & (fit.theta > 0.0) & np.all(theta > 0.0, axis=0)
    at = np.where(log, fit.theta, 1.0)
    factors = at * np.exp(wider * np.log(np.where(log, theta, 1.0) / at))
    spread = np.where(log, factors, fit.theta + wider * (theta - fit.theta))
    return within_bounds(fit.model, spread)


def _errors(fit: Fit, n: int, rng: np.random.Generator) -> Complex:
    """Simulated weighted errors (n, points)."""
    known, count = Uncertainty.of(fit), len(fit.measurement)
    drawn = rng.standard_normal((n, 2 * count)) * known.scale
    for rows in known.lines if known.memory else ():
        drawn[:, rows] = autoregressive(drawn[:, rows], known.memory)
    return drawn[:, :count] + 1j * drawn[:, count:]


def _refitted(fit: Fit, errors: Complex) -> Real:
    weights = fit.task.weights[0]
    shift = errors.real / weights.real + 1j * (errors.imag / weights.imag)
    # In the middle of the box the objective has the size of the data, whatever a search has come
    # to.
    base = fit.model.stiffness(fit.theta, fit.measurement.points)
    data = base + shift
    if fit.objective.logarithmic:
        data = base * np.exp(shift)
    # Begun at the fit that they come from, and at two places of their own, should noise have made
    # another valley deeper.
    seeds = np.broadcast_to(fit.theta, (len(data), 1, len(fit.theta)))
    points = fit.measurement.points
    return fit_batch(
        fit.model,
        points,
        data,
        weights,
        starts=2,
        seeds_theta=seeds,
        logarithmic=fit.objective.logarithmic,
    )[0]


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
    if task.levels is not None:
        return _of_levels(task, starts, seeds_theta)
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


def _of_levels(task: Task, starts: int, seeds_theta: Real | None) -> tuple[Real, Real]:
    """The same where levels have parameters of their own, by their blocks.

    No shapes are scanned, of which there is one for each level: where no start is given, each level
    begins where one of each would fit all of them best.
    """
    count, model = len(task.stiffness), task.model
    if seeds_theta is None:
        known = task.points, task.stiffness, task.weights
        one = fit_batch(model.of_any_level, *known, starts, None, task.logarithmic)[0]
        seeds_theta = model.at_all_levels(one)[:, None, :]
    size = task.coordinates.size
    solution = task.solve(task.coordinates.u(np.asarray(seeds_theta, float), size[:, None, :]))
    cost = solution.cost.reshape(count, -1)
    rows, best = np.arange(count), np.argmin(cost, axis=1)
    u = solution.u.reshape(count, cost.shape[1], -1)[rows, best]
    return within_bounds(model, task.coordinates.theta(u, size)), cost[rows, best]


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
