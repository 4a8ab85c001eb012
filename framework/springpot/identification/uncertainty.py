"""How well the parameters are known: intervals from the Jacobian, in the published form too."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import (
    LIKENESS,
    Links,
    covariance_along,
    effective_share,
    fitted_memory,
    student,
)
from springpot.measurement.mixed_up import longest_memory, sweeps_of
from springpot.measurement.units import Units
from springpot.rheology.parameters import WIDEST, SearchForm, box_of
from springpot.rheology.points import Real
from springpot.rheology.tied import Follower
from springpot.thresholds import INTERVAL, VERDICT

from ..numerics import ALIKE, NEGLIGIBLE, ROUNDING, Tangent
from .material import prior_residual_of, prior_slopes
from .normal import (
    PART,
    RANK,
    Bordered,
    Covariance,
    Eliminated,
    among,
    matrix_of,
    spread_of,
)
from .population import Specimens, follows_specimens
from .problem import weighted
from .value import Value, printed

if TYPE_CHECKING:
    from springpot.rheology.model import Model

    from .native import Fit


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """What the Jacobian says about a fit.

    Parameters
    ----------
    fit : Fit
        The fit.
    absolute : bool
        Whether the weights are known standard deviations; otherwise the scatter of the residuals
        sets the scale.
    level : float
        Probability of the intervals.
    spread : tuple of (float, float), optional
        Standard deviation of a weighted residual and its degrees of freedom, where those of the
        scatter are not what the parameters are known by; see `lack_of_fit`.
    shared : ndarray, shape (p, p), optional
        Covariance in search coordinates of what all points have in common; see `calibration`.
    memory : float
        Correlation of the errors of neighbouring points of a sweep.

    Examples
    --------
    >>> import springpot
    >>> from springpot.identification import Uncertainty, fit
    >>> data = springpot.read("artificial-hidden@frequency=..1")
    >>> best = fit(springpot.parse_model("fractional-maxwell"), data)
    >>> low, high = Uncertainty.of(best).interval()
    >>> bool((low < best.theta).all() and (best.theta < high).all())
    True
    """

    fit: Fit
    absolute: bool
    level: float = INTERVAL
    spread: tuple[float, float] | None = None
    shared: Real | None = None
    memory: float = 0.0

    @classmethod
    def of(cls, fit: Fit, level: float = INTERVAL) -> Uncertainty:
        """Intervals at `level`, absolute where the objective uses given standard deviations.

        With the memory that the noise has along the sweeps, where that is likelier than none.
        """
        # Weights that are no standard deviations know shares only: what a residual of one means,
        # the scatter says.
        known = cls(fit, uses_sd(fit), level)
        return replace(known, memory=known._memory_of_noise())

    @property
    def scale(self) -> float:
        """Standard deviation of a weighted residual."""
        if self.spread is not None:
            return self.spread[0]
        if self.absolute:
            return 1.0
        # As many parameters as numbers: whatever the scatter is, the fit goes through all of it.
        if self.fit.dof <= 0:
            return float("inf")
        return float(np.sqrt(self.fit.cost / (self.fit.dof * self._left)))

    @property
    def freedom(self) -> float:
        """Degrees of freedom of the scale: without end where it is known beforehand."""
        dof = self.fit.dof if self.spread is None else self.spread[1]
        if self.spread is None and self.absolute:
            return float("inf")
        return dof * effective_share(self.memory)

    @property
    def quantile(self) -> float:
        """Standard deviations to the end of an interval."""
        if self.specimens is not None:
            return student(self.level, self.specimens.count - 1)
        return student(self.level, self.freedom)

    @cached_property
    def specimens(self) -> Specimens | None:
        """The specimens whose scatter sets the intervals; None where that of the points does."""
        return follows_specimens(self.fit)

    @cached_property
    def at_bound(self) -> NDArray[np.int64]:
        """-1 where a parameter (p,) is at its lower bound or about zero, 1 at its upper, else 0."""
        low, high = (bound[0] for bound in self.fit.task.coordinates.bounds)
        log, u = self.fit.task.coordinates.log, self.fit.u
        linear = ALIKE * np.where(np.isfinite(high - low), high - low, 1.0)
        # Zero is infinitely far from a logarithm: one that has left no trace in the data is as good
        # as there.
        free = log & (np.abs(np.where(np.isfinite(low), low, -WIDEST)) >= WIDEST)
        if self.fit.by_level is None:
            traces = np.linalg.norm(self.fit.jacobian_u, axis=0)
        else:
            traces = self.fit.by_level.sizes
        traceless = traces <= NEGLIGIBLE * np.linalg.norm(self._data_size)
        below = (u <= low + np.where(log, _slack(low), linear)) | (free & traceless & (u < 0))
        above = (u >= high - np.where(log, _slack(high), linear)) | (log & traceless & (u > 0))
        return np.where(below, -1, np.where(above, 1, 0))

    @cached_property
    def _data_size(self) -> Real:
        task = self.fit.task
        # Of a logarithm the weight alone is relative; of K itself it is one over its size.
        if task.logarithmic:
            return np.abs(task.weights)
        return np.abs(task.weights * np.abs(task.stiffness))

    @cached_property
    def covariance(self) -> Covariance:
        """Covariance (p, p) in search coordinates.

        Infinite variance where the data say nothing, 0 at a bound.
        """
        covariance = self._covariance(self.specimens, self.memory)
        for beside in (self._moved, self.shared):
            if beside is not None:
                covariance = matrix_of(covariance) + beside
        return covariance

    @property
    def _moved(self) -> Real | None:
        """Covariance (p, p) of what the evidence did not ask for, and may be there."""
        expected = self.fit.expected
        if expected is None or expected.moved is None:
            return None
        moved = np.zeros(len(self.fit.u))
        moved[-len(expected.moved) :] = expected.moved
        moved[self.at_bound != 0] = 0.0
        return np.outer(moved, moved)

    def widening(self, i: int) -> float:
        """Variance of parameter i over that by points whose errors are independent."""
        if self.specimens is None and not self.memory:
            return 1.0
        alone, whole = (
            float(printed_spread(self.fit, self._covariance(*by))[i])
            for by in ((None, 0.0), (self.specimens, self.memory))
        )
        if not (np.isfinite(whole) and np.isfinite(alone) and alone > 0.0):
            return 1.0
        return (whole / alone) ** 2

    @cached_property
    def eliminated(self) -> Eliminated | None:
        """Own parameters of levels eliminated from the slopes; None where all are shared."""
        if self.fit.by_level is None:
            return None
        return Eliminated(self.fit.by_level, self.at_bound == 0)

    def _memory_of_noise(self) -> float:
        """That of what the parameters leave; none where white noise is as likely.

        Nor where specimens tell the scatter, or levels have parameters of their own.
        """
        fit = self.fit
        if self.eliminated or self.specimens or not fit.dof >= VERDICT.enough_spare:
            return 0.0
        n, sweeps = len(fit.measurement), sweeps_of(fit.measurement)
        columns = np.column_stack([self._followed.basis[: 2 * n], fit.residual])
        if not np.all(np.isfinite(columns)):
            return 0.0
        told = fitted_memory(columns, Links.along(self.lines), longest_memory(sweeps))
        # What hardly ever comes back is no noise but a misfit, as wide as the intervals say it is.
        return told.memory if told.gain > 0.0 and told.likeliest <= LIKENESS else 0.0

    @property
    def lines(self) -> list[NDArray[np.int64]]:
        """Numbers of the residual (2n,) that follow one another."""
        data = self.fit.measurement
        return [rows + k for k in (0, len(data)) for rows, _ in sweeps_of(data)]

    @property
    def _left(self) -> float:
        """Variance that fitted parameters leave of noise with a memory, over that of white noise.

        They follow more of what is slow.
        """
        if not self.memory:
            return 1.0
        size, free = np.shape(self._followed.basis)
        return float((size - np.trace(self._of_sums)) / max(size - free, 1))

    @cached_property
    def _of_sums(self) -> Real:
        """Covariance (k, k) of what such noise of size one has along the basis."""
        return covariance_along(self._followed.basis, self.memory, self.lines)

    def _covariance(self, specimens: Specimens | None, memory: float) -> Covariance:
        if self.eliminated is not None:
            if specimens is None:
                return self.eliminated.covariance(self.scale)
            unit, slopes = self.eliminated.covariance(1.0), self.eliminated.slopes
            return specimens.sandwich_of_levels(slopes, self.fit.residual, unit)
        free, back = self._free, self._followed.back
        # A direction without a trace in the data takes all parameters along that have a part in it.
        lost = free[self._followed.lost > PART]
        covariance: Real = np.zeros((len(self.fit.u),) * 2)
        with np.errstate(invalid="ignore"):
            whole = self.scale**2 * (back @ back.T)
            if specimens is not None:
                inner = self.slopes[:, free]
                whole = specimens.sandwich(inner, self.fit.residual, back @ back.T)
            elif memory:
                whole = self.scale**2 * back @ self._of_sums @ back.T
            covariance[np.ix_(free, free)] = whole
        covariance[lost, lost] = np.inf
        return np.nan_to_num(covariance, nan=np.inf, posinf=np.inf)

    @cached_property
    def _free(self) -> NDArray[np.intp]:
        """Numbers of the parameters that move with the data.

        What rests on a bound takes no part, and the others are the surer for it.
        """
        return np.flatnonzero(self.at_bound == 0)

    @cached_property
    def _followed(self) -> Tangent:
        """What these follow of the data."""
        return Tangent.of(self.slopes[:, self._free], RANK)

    @property
    def prior_residual(self) -> Real:
        """How far the effects' parameters lie from what was expected of them, (r,)."""
        if self.fit.expected is None:
            return np.zeros(0)
        rows = self.fit.expected.weighted
        return prior_residual_of(rows, self.fit.theta[-rows.shape[1] :])

    @property
    def slopes(self) -> Real:
        """Derivative (2n + r, p) of residuals and departures from what is expected.

        By the search coordinates.
        """
        if self.fit.expected is None:
            return self.fit.jacobian_u
        rows = self.fit.expected.weighted
        own = self.fit.theta[-rows.shape[1] :]
        turn = self.fit.task.coordinates.slopes(self.fit.theta, self.fit.task.coordinates.size[0])
        return np.concatenate([self.fit.jacobian_u, prior_slopes(rows, own, turn[-len(own) :])])

    @cached_property
    def correlation(self) -> Real:
        """Correlation (p, p) of the parameters as printed; NaN where undetermined or at a bound."""
        fit = self.fit
        if isinstance(self.covariance, Bordered):
            return correlation_of(printed_covariance(fit, self.covariance).dense())
        turn = fit.task.coordinates.slopes(fit.theta, fit.task.coordinates.size[0])
        with np.errstate(all="ignore"):
            return correlation_of(turn @ self.covariance @ turn.T)

    def interval(self) -> tuple[Real, Real]:
        """Ends (p,) of the intervals of all parameters.

        Zero or infinite where the data give no end.
        """
        fit, coordinates = self.fit, self.fit.task.coordinates
        with np.errstate(
            invalid="ignore"
        ):  # of a parameter on its bound nothing is known from here
            reach = self.quantile * printed_spread(fit, self.covariance)
        low, high = ends(fit.theta, reach, coordinates.log, fit.model.box)
        rest = np.flatnonzero(self.at_bound)
        for i in rest.tolist():
            low[i], high[i] = self._one_sided(i)
        return low, high

    @cached_property
    def leanings(self) -> Real | None:
        """Moves (p, b) of theta by one standard deviation away from each bound it rests on.

        The others go along, to make up for it. None where levels have parameters of their own.
        """
        if self.eliminated is not None:
            return None
        fit, free = self.fit, self._free
        turn, moves = slopes_of(fit)[:, free], []
        for i in np.flatnonzero(self.at_bound).tolist():
            reach, made_up = self._reach(i)
            room = fit.theta[i] - fit.model.box[0][i]
            if self.at_bound[i] < 0:
                room = fit.model.box[1][i] - fit.theta[i]
            # Where the data give no end the others make up for all of it.
            if np.isfinite(reach):
                far = -self.at_bound[i] * min(reach, float(room))
                move = -far * (turn @ made_up)
                move[i] += far
                moves.append(move / self.quantile)
        return np.array(moves).reshape(-1, len(fit.theta)).T

    def _reach(self, i: int) -> tuple[float, Real]:
        """How far a parameter on its bound may be from it, and what others do for each of that."""
        slope = _linear_slope(self.fit, i)
        made_up: Real = np.zeros(0)
        whole = float(np.linalg.norm(slope))
        # What the others can make up for tells nothing of this one.
        if self.eliminated is not None:
            size = self.eliminated.left(slope)
        else:
            others = self.fit.jacobian_u[:, self._free]
            made_up = Tangent.of(others, RANK).step(slope)
            slope = slope - others @ made_up
            size = float(np.linalg.norm(slope))
        # From a bound there is one way only: the whole tail lies on that side.
        side = student(2.0 * self.level - 1.0, self.freedom)
        # What rounding leaves of a slope that the others make up for is none.
        if size > RANK * whole:
            along = np.eye(1)
            if self.memory:
                along = covariance_along(slope[:, None] / size, self.memory, self.lines)
            return side * self.scale * float(np.sqrt(along[0, 0])) / size, made_up
        return float("inf"), made_up

    def _one_sided(self, i: int) -> tuple[float, float]:
        """Interval of a parameter on its bound.

        In the parameter itself, as a logarithm has no end there.
        """
        fit, (lower, upper) = self.fit, self.fit.model.box
        (reach, _), value = self._reach(i), float(fit.theta[i])
        if self.at_bound[i] < 0:
            return float(lower[i]), min(value + reach, float(upper[i]))
        if np.isinf(upper[i]):
            # Compliances add where a stiffness has grown without limit, so its inverse has the
            # finite interval.
            inverse = (1.0 + reach / value) / value
            if not np.isfinite(inverse):
                return float(lower[i]), float("inf")
            return max(1.0 / inverse, float(lower[i])), float("inf")
        return max(value - reach, float(lower[i])), float(upper[i])


def _slack(bound: Real) -> Real:
    """How near to its bound a logarithm counts as resting there.

    Zero and infinity are no places: whatever comes near the end of the range has gone there. A
    bound that a user gives is one.
    """
    return np.where(np.abs(bound) >= WIDEST, 0.5, 1e-6)


def uses_sd(fit: Fit) -> bool:
    """Whether the objective weighs each difference by its given standard deviation."""
    sd = fit.measurement.sd
    if sd is None or fit.objective.logarithmic:
        return False
    weights = fit.task.weights[0]
    return bool(
        np.allclose(weights.real * sd.real, 1.0) and np.allclose(weights.imag * sd.imag, 1.0)
    )


def correlation_of(covariance: Real) -> Real:
    """Correlations (p, p) of what has a covariance; NaN where that is no number."""
    with np.errstate(all="ignore"):
        sd = np.sqrt(np.diag(covariance))
        correlation: Real = covariance / (sd[:, None] * sd[None, :])
    return correlation


def ends(
    value: Real, reach: Real, log: NDArray[np.bool_], bounds: tuple[Real, Real]
) -> tuple[Real, Real]:
    """Ends of intervals.

    A factor exp(reach) either way for logarithmic parameters, plus and minus for others.
    """
    with np.errstate(all="ignore"):
        factor = np.exp(np.where(log, reach, 0.0))
        low = np.where(log, value / factor, value - np.where(log, 0.0, reach))
        high = np.where(log, value * factor, value + np.where(log, 0.0, reach))
    return np.maximum(low, bounds[0]), np.minimum(high, bounds[1])


def _printed_slopes(fit: Fit) -> Real:
    """Derivative (p, p) of ln theta (logarithmic parameters) or theta by the search coordinates."""
    coordinates = fit.task.coordinates
    turn = coordinates.slopes(fit.theta, coordinates.size[0])
    return turn / _printed_scale(fit)[:, None]


def _printed_scale(fit: Fit) -> Real:
    log = fit.task.coordinates.log
    return np.where(log, np.where(fit.theta == 0.0, 1.0, fit.theta), 1.0)


def slopes_of(fit: Fit) -> Real:
    """Derivative (p, p) of theta by the search coordinates; level by level (G, q, q) if own."""
    coordinates, levels = fit.task.coordinates, fit.task.levels
    if levels is not None:
        return levels.slopes(fit.theta, coordinates.size[0])
    return coordinates.slopes(fit.theta, coordinates.size[0])


def printed_covariance(fit: Fit, covariance: Bordered) -> Bordered:
    """That of theta."""
    return covariance.carried(slopes_of(fit))


def printed_spread(fit: Fit, covariance: Covariance) -> Real:
    """Standard deviations (p,) of ln theta (logarithmic parameters) or theta."""
    if isinstance(covariance, Bordered):
        scale = _printed_scale(fit)
        return np.sqrt(printed_covariance(fit, covariance).variance) / scale
    return spread_of(_printed_slopes(fit), covariance)


def _linear_slope(fit: Fit, i: int) -> Real:
    """Derivative (2n,) of the residuals by parameter i itself."""
    points, levels = fit.measurement.points, fit.task.levels
    if levels is None:
        jacobian = fit.model.jacobian(fit.theta, points)[:, i]
    else:
        jacobian = levels.derivative(fit.theta, i)
    weights = fit.task.weights[0]
    if fit.task.logarithmic:
        jacobian = jacobian / fit.model.stiffness(fit.theta, points)
    return np.nan_to_num(weighted(jacobian, weights, fit.objective.turn))


def tied_values(
    model: Model,
    theta: Real,
    interval: tuple[Real, Real],
    covariance: Covariance,
    quantile: float,
    units: Units,
) -> dict[str, tuple[str, Value]]:
    """The tied parameters by name, each with the name that its levels share.

    What follows from a single parameter has the ends of that one's interval, wherever these come
    from; the others follow the covariance.

    Parameters
    ----------
    model : Model
        The fitted model.
    theta : ndarray, shape (p,)
        Its parameters.
    interval : tuple of ndarray, shape (p,)
        Ends of their intervals.
    covariance : ndarray, shape (p, p)
        Of theta.
    quantile : float
        Standard deviations to the end of an interval.
    units : Units
        Those of the data.
    """
    found = {}
    for each in model.followers(theta) if model.ties else ():
        mine, ends_of = theta[each.at], np.array([end[each.at] for end in interval])
        low, high = _by_covariance(each, among(covariance, each.at), quantile)
        parents = np.flatnonzero(each.slopes).tolist()
        moved = [i for i in parents if mine[i] in ends_of[:, i]]
        if len(parents) == 1:
            low, high, moved = np.inf, -np.inf, parents
        # Where each of them alone goes to the ends of its own interval.
        for i in moved:
            values = list(_moved(each, mine, ends_of[:, i], i))
            low, high = min(low, *values), max(high, *values)
        low, high = max(low, each.parameter.lower), min(high, each.parameter.upper)
        factor, label = units.of(each.parameter.unit)
        value = Value(
            factor * each.value, factor * float(low), factor * float(high), label, tied=each.text
        )
        found[each.parameter.name] = (each.origin, value)
    return found


def _moved(each: Follower, theta: Real, places: Real, i: int) -> Iterator[float]:
    """What follows where parameter i alone goes to some places."""
    for place in places.tolist():
        moved = theta.copy()
        moved[i] = place
        with np.errstate(all="ignore"):
            yield each.follow(moved)


def _by_covariance(each: Follower, covariance: Real, quantile: float) -> tuple[float, float]:
    log = np.array([each.parameter.scale == "log" and each.value > 0.0])
    turn = each.slopes[None] / (each.value if log[0] else 1.0)
    reach = quantile * spread_of(turn, covariance)
    bounds = np.array([each.parameter.lower]), np.array([each.parameter.upper])
    low, high = ends(np.array([each.value]), reach, log, bounds)
    return float(low[0]), float(high[0])


def search_parameters(known: Uncertainty, ends_low: Real, ends_high: Real) -> dict[str, Value]:
    """The parameters in the model's published search form, by linear propagation.

    None where it has no such form.
    """
    estimate, form = known.fit, known.fit.model.search
    if form is None:
        return {}
    q = len(form.parameters)
    with np.errstate(all="ignore"):
        # The elements come first in theta; what follows are effects, which the published form does
        # not know.
        x = form.from_elements(estimate.theta[:q])
        reach = _reach(known, form, x)
        log = np.array([p.scale == "log" for p in form.parameters])
        bounds = box_of(form.parameters)
        low, high = ends(x, np.where(np.isfinite(reach), reach, np.inf), log, bounds)
        # A slope tells nothing of a step away from a bound: there the ends themselves are carried
        # over.
        for moved in _at_ends(known, ends_low[:q], ends_high[:q]):
            other = np.nan_to_num(form.from_elements(moved), nan=np.inf)
            low, high = (
                np.fmax(np.fmin(low, other), bounds[0]),
                np.fmin(np.fmax(high, other), bounds[1]),
            )
    for i, j in _shared(estimate, form, x):
        low[i], high[i] = ends_low[j], ends_high[j]
    return printed(form.parameters, x, low, high, estimate.measurement.units)


def _at_ends(known: Uncertainty, low: Real, high: Real) -> list[Real]:
    """The parameters of the form, those at a bound put at both ends of their interval in turn."""
    moved = []
    at_bound = known.at_bound[: len(low)]
    for i in np.flatnonzero(at_bound).tolist():
        # An upper end is often infinite, where the form has limits that its formulas do not reach.
        places = [low[i]]
        if at_bound[i] < 0:
            places.append(high[i])
        for place in places:
            theta = known.fit.theta[: len(low)].copy()
            theta[i] = place
            moved.append(theta)
    return moved


def _shared(fit: Fit, form: SearchForm, x: Real) -> list[tuple[int, int]]:
    """Places (in the form, in the model) of parameters that both have.

    These have one interval, not two.
    """
    names = fit.model.names[: len(form.parameters)]
    places = [(i, names.index(p.name)) for i, p in enumerate(form.parameters) if p.name in names]
    return [(i, j) for i, j in places if np.isclose(x[i], fit.theta[j], rtol=ROUNDING)]


def _reach(known: Uncertainty, form: SearchForm, x: Real) -> Real:
    """Half the width of the intervals of ln x (logarithmic parameters) or x."""
    coordinates = known.fit.task.coordinates
    q = len(form.parameters)
    turn = coordinates.slopes(known.fit.theta, coordinates.size[0])[:q]
    by_theta = form.jacobian(x)
    # Where several values of the form give the same elements, the data say nothing of its
    # parameters.
    if not np.all(np.isfinite(by_theta)) or np.linalg.matrix_rank(by_theta) < q:
        return np.full(q, np.inf)
    by_u: Real = np.asarray(np.linalg.solve(by_theta, turn), dtype=float)
    log = np.array([p.scale == "log" for p in form.parameters])
    by_u /= np.where(log, x, 1.0)[:, None]
    return known.quantile * spread_of(by_u, matrix_of(known.covariance))
