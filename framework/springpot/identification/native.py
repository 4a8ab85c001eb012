"""The native solver, and what it gives: a model fitted to a measurement.

Levenberg-Marquardt from starts read off the data, all in one batch: descents that keep to the
search box and whose every model evaluation is recorded. A fit tells what it leaves, its slopes, and
what of the data it has followed; the places of a spectrum's lines follow some of it too, beside
the weights.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from time import perf_counter
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError, OptionError
from springpot.measurement.measurement import Measurement
from springpot.numerics import ALIKE, NEGLIGIBLE, ROUNDING, Tangent, non_negative
from springpot.rheology.elements import Continuum
from springpot.rheology.nodes import GRADIENT
from springpot.rheology.points import Real
from springpot.writing import counted

from .leastsquares import AGREE, Effort, Solution, Trial, levenberg_marquardt
from .material import FINE, QUICK, SpectrumSearch, is_material, own_parameters
from .material_fit import fit_spectrum, superposed
from .normal import Layout, LevelSlopes
from .problem import Objective, Problem, default_objective, numbers_of, weighted
from .recorder import Recorder
from .space import Expected, require_conditions, require_size
from .starts import shape_count
from .task import FLAT_SHAPES, Task

if TYPE_CHECKING:
    from springpot.rheology.model import Model


class FittedModel(Protocol):
    """A fitted model."""

    @property
    def model(self) -> Model:
        """The model."""

    @property
    def theta(self) -> Real:
        """Its parameters (p,)."""

    @property
    def reference(self) -> float:
        """Temperature in kelvin at which shifts are one."""


def followed_by_places(search: SpectrumSearch, theta: Real, residual: Real, known: Real) -> float:
    """Numbers that the places of the lines of a fitted spectrum have followed, beside the weights.

    A line stands where one explains most. Had the noise been other it would stand elsewhere: it
    moves by what the slope of its curve finds in the noise, against the curvature of what is left
    there. So far its place is a parameter, and its share of one lies between 0 and 1: with S the
    map from noise to curve, a residual has lost tr(2 S - S S') numbers (Hastie and Tibshirani,
    Generalized Additive Models, 1990, sec. 3.5). Of two lines side by side the weights move them,
    and nothing is left for the places.

    Parameters
    ----------
    search : SpectrumSearch
        For the model with its lines, which is a `Continuum` with effects.
    theta : ndarray, shape (p,)
        The parameters.
    residual : ndarray, shape (m,)
        Predicted less measured, weighted.
    known : ndarray, shape (m, q)
        Its slopes by the parameters that follow the data, in whatever unit.
    """
    material, own = search.model.material, own_parameters(search.model)
    assert isinstance(material, Continuum)
    count = len(material.parameters)
    weights, rates = theta[:count], np.log(material.rates)
    carrying = _followed(rates, weights[2:])
    if not len(carrying):
        return 0.0
    places = np.concatenate([rates[carrying] + step for step in (-FINE, 0.0, FINE)])
    beside = Trial(
        search.u_of(theta[own]),
        np.concatenate([rates, places]),
        np.concatenate([weights, np.zeros(len(places))]),
        np.inf,
    )
    columns = search.respond(beside).by_theta[count : count + len(places)]
    before, at, after = search.weigh(columns).reshape(3, len(carrying), -1)
    weight = weights[2:][carrying, None]
    slopes = weight * (after - before) / (2.0 * FINE)
    left = (weight * (2.0 * at - before - after) / FINE**2) @ -residual
    # What the weights and the effects' parameters follow is no gain of the places.
    slopes = Tangent.of(known).left(slopes.T)
    stiff = np.diag(np.sqrt(np.maximum(left, 0.0)))
    spread, sizes, _ = np.linalg.svd(np.concatenate([slopes, stiff]), full_matrices=False)
    # By their shares: of what is seen of one combination of places, how much the data move.
    moved = spread[: len(slopes), sizes > ROUNDING * sizes[0]]
    share = np.linalg.svd(moved, compute_uv=False) ** 2
    return float(np.sum(2.0 * share - share**2))


def _followed(rates: Real, weights: Real) -> NDArray[np.int64]:
    """Numbers of the lines that carry weight with none beside them; rates in logarithms."""
    carrying = np.flatnonzero(weights > 0.0)
    carrying = carrying[np.argsort(rates[carrying])]
    apart = np.diff(rates[carrying], prepend=-np.inf, append=np.inf) > FINE
    return carrying[apart[1:] & apart[:-1]]


@dataclass(frozen=True, eq=False)
class Fit:
    """A model fitted to a measurement.

    Attributes
    ----------
    model, measurement, objective
        What was fitted to what, and how the misfit was measured.
    theta : ndarray, shape (p,)
        The parameters.
    cost : float
        The objective there: the sum of squared residuals.
    evaluations : int
        Model evaluations spent, those of the start scan included.
    converged : bool
        Whether the best start came to rest.
    seconds : float
        Time taken.
    confirmed : bool
        Whether nothing but rounding is left, or at least two starts ended there.
    expected : Expected, optional
        What was expected of the effects' parameters beside the data.
    """

    model: Model
    measurement: Measurement
    objective: Objective
    theta: Real
    cost: float
    evaluations: int = 0
    converged: bool = True
    seconds: float = 0.0
    confirmed: bool = True
    expected: Expected | None = None

    @property
    def reference(self) -> float:
        """Temperature in kelvin at which shifts are one."""
        return self.measurement.reference_temperature

    @cached_property
    def task(self) -> Task:
        """The data as a batch of one."""
        return task_of(self.model, self.measurement, self.objective)

    @cached_property
    def dof(self) -> float:
        """Degrees of freedom.

        The numbers measured less those that the parameters follow, and the places of a spectrum.
        """
        left = numbers_of(self.task.weights) - len(self.theta) + self.silent
        if not is_material(self.model):
            return left
        search = SpectrumSearch.of(self.model, self.measurement, self.objective)
        follows = np.ones(len(self.theta), dtype=bool)
        follows[: len(self.model.material.parameters)] = self._weights > 0.0
        placed = followed_by_places(search, self.theta, self.residual, self.jacobian_u[:, follows])
        # Of exact data the lines stand for numbers, of which no place can take more than there are.
        return max(left - placed, min(left, 1.0))

    @property
    def silent(self) -> int:
        """Weights of a spectrum that the data put at zero: these follow nothing.

        See Meyer and Woodroofe 2000, doi:10.1214/aos/1015956708.
        """
        if not is_material(self.model):
            return 0
        return int(np.sum(self._weights == 0.0))

    @property
    def _weights(self) -> Real:
        return self.theta[: len(self.model.material.parameters)]

    @cached_property
    def residual(self) -> Real:
        """Weighted residuals (2n,): those of the real part, then those of the imaginary part."""
        return in_parts(self._at_solution[0])

    @cached_property
    def jacobian_u(self) -> Real:
        """Derivative of the residuals by the search coordinates, shape (2n, p)."""
        if self.by_level is not None:
            return self.by_level.layout.dense(self.by_level.jacobian).T
        return in_parts(self._at_solution[1]).T

    @cached_property
    def by_level(self) -> LevelSlopes | None:
        """The same by the parameters of the level of each, where levels have their own."""
        if self.task.levels is None:
            return None
        known = self.task.levels.layout
        layout = Layout(known.places, np.tile(known.number, 2))
        return LevelSlopes(layout, in_parts(self._at_solution[1]))

    @cached_property
    def _at_solution(self) -> tuple[Real, Real]:
        evaluate = self.task.evaluator(np.zeros(1, dtype=np.intp))
        with np.errstate(all="ignore"):
            residual, jacobian = evaluate(self.u[None, :], np.zeros(1, dtype=np.intp))
        return residual[0], jacobian[0]

    @cached_property
    def u(self) -> Real:
        """The solution in search coordinates, shape (p,)."""
        return self.to_u(self.theta)

    def to_u(self, theta: Real) -> Real:
        """Search coordinates (..., p) of parameters (..., p)."""
        return self.task.coordinates.u(theta, self.task.coordinates.size[0])

    def from_u(self, u: Real) -> Real:
        """Parameters (..., p) of search coordinates (..., p)."""
        return self.task.coordinates.theta(u, self.task.coordinates.size[0])


def in_parts(interleaved_values: Real) -> Real:
    """Real parts, then imaginary parts, along the last axis."""
    return np.concatenate([interleaved_values[..., ::2], interleaved_values[..., 1::2]], axis=-1)


def task_of(model: Model, measurement: Measurement, objective: Objective) -> Task:
    """The data as a batch of one."""
    weights = objective.weighing(measurement)
    return Task(
        model,
        measurement.points,
        measurement.stiffness[None],
        weights[None],
        objective.logarithmic,
        turn=objective.turn,
    )


COARSE_POINTS = 500
"""Larger data sets are first fitted at this many of their points."""
LAST = 20
"""Steps with all points of a large data set; most of the way was gone with a few of them."""
STOPS = 10.0
"""Ends within so many times what is not worth a step are one end: each may stop that far above it.
"""
JITTERS = 32
"""Places to which a scan can be moved: few, so that scans on one grid are made once."""
CONFIRMED = 2
"""The same of descents that went to their ends, which is no chance meeting of two that were stopped
on their way.
"""
SCANNED, NEAR = 1e-4, 1e-6
"""Damping at a start that a scan has found, and at one beside its end.

There a step of Gauss and Newton is right.
"""


def fit(
    model: Model,
    measurement: Measurement,
    objective: Objective | None = None,
    *,
    starts: int = 8,
    seeds_theta: Sequence[Real] = (),
    rng: np.random.Generator | None = None,
    effort: Effort | None = None,
    expected: Expected | None = None,
) -> Fit:
    """Fit a model to a measurement.

    Parameters
    ----------
    model : Model
        What is fitted.
    measurement : Measurement
        To what.
    objective : Objective, optional
        How the misfit is measured; by default weighted by given standard deviations, else relative.
    starts : int
        Starts read off the data.
    seeds_theta : sequence of ndarray, shape (p,)
        Further starts, such as the fit of a simpler model with a small effect added; they come
        first.
    rng : numpy.random.Generator, optional
        Moves the scanned shapes; without it they are always the same.
    effort : Effort, optional
        How far it goes; by default until nothing but rounding is left.
    expected : Expected, optional
        Of any material only: what is known of the effects' parameters beforehand. `Fit.cost` is
        that of the data alone.

    Returns
    -------
    Fit
        The best of all starts.

    Raises
    ------
    ModelError
        If the data lack a column that the model needs.
    DataError
        If there are more unknowns than data.

    Examples
    --------
    >>> import springpot
    >>> from springpot.identification import fit
    >>> data = springpot.read("artificial-hidden@frequency=..1")
    >>> best = fit(springpot.parse_model("fractional-maxwell"), data)
    >>> best.converged, best.dof
    (True, 9)
    """
    began = perf_counter()
    require_conditions(model, measurement)
    require_size(measurement)
    model = model.bound_to(measurement.points)
    require_enough(model, measurement)
    if objective is None:
        objective = default_objective(measurement)
    if is_material(model):
        known = None if expected is None else expected.weighted
        search, end, converged = fit_spectrum(
            model, measurement, objective, seeds_theta, starts, effort, known
        )
        model, theta, cost = search.result(end)
        spent, seconds = search.evaluations, perf_counter() - began
        return Fit(
            model, measurement, objective, theta, cost, spent, converged, seconds, expected=expected
        )
    # One data set is a batch of one: single fits and simulated ones by the thousand run through the
    # same code.
    task = task_of(model, measurement, objective)
    seeds, starts = _placed(model, measurement, objective, seeds_theta, starts)
    solution, evaluations = _solved(task, seeds, starts, rng, effort or Effort())
    best = solution.best
    # By way of a logarithm and back, a value at its bound comes to lie a rounding beyond it.
    theta = within_bounds(model, task.coordinates.theta(solution.u[best], task.coordinates.size[0]))
    return Fit(
        model,
        measurement,
        objective,
        theta,
        float(solution.cost[best]),
        evaluations,
        bool(solution.converged[best]),
        perf_counter() - began,
        _agreed(solution, task.floor[0], CONFIRMED, NEGLIGIBLE),
    )


def _placed(
    model: Model,
    measurement: Measurement,
    objective: Objective,
    seeds_theta: Sequence[Real],
    starts: int,
) -> tuple[Sequence[Real], int]:
    """Given starts (p,) and the number of those read off the data.

    Where none can be read, others are placed.
    """
    if model.constrained:
        # With its times held a sum of relaxations is one convex problem: no start is better.
        if (solved := _if_linear(model, measurement, objective)) is not None:
            return [*seeds_theta, solved], 0
        # The scan of shapes needs gains that scale a whole branch; here some are held or end at a
        # bound.
        placed = [*seeds_theta, *_released_starts(model, measurement, objective, starts)]
        if model.own and starts:
            # Where one of each would fit all levels best, each begins.
            one = fit(model.of_any_level, measurement, objective, starts=starts)
            placed.append(model.at_all_levels(one.theta))
        return placed, 0
    if starts and any(effect.by_levels for effect in model.effects):
        # A scan of one dimension for each level would find nothing; the data say where its factor
        # lies.
        return [*seeds_theta, _superposed_start(model, measurement, objective, starts)], 0
    return seeds_theta, starts


def _solved(
    task: Task,
    seeds_theta: Sequence[Real],
    starts: int,
    rng: np.random.Generator | None,
    effort: Effort,
) -> tuple[Solution, int]:
    """Solutions from all starts, and the evaluations spent; of many points a few show the way."""
    size = task.coordinates.size[0]
    # Two axes even where nothing is given, so that other starts can be joined on.
    seeds = np.reshape(
        [task.coordinates.u(np.asarray(t, dtype=float), size) for t in seeds_theta], (-1, len(size))
    )
    offset = 0.0
    if rng is not None:
        offset = _offset(rng)  # drawn for any model, that the generator goes on alike
    # The way to the optimum is the same with a few points; only its last steps need all of them.
    coarse = task.thin(COARSE_POINTS * task.level_count)
    if task.model.constrained:
        # Every start is given, and gains cannot be projected out of a model that holds some of
        # them.
        solution = coarse.solve(seeds[None], flat=effort.negligible)
        evaluations = solution.evaluations
    else:
        solution, evaluations = _search(
            coarse, seeds, starts, offset, effort.of_part(coarse.count / task.count)
        )
    if coarse is not task:
        # The best two, because with all points the second may turn out to be the better one.
        solution = task.solve(
            solution.u[np.argsort(solution.cost)[:2]][None], iterations=LAST, damping=NEAR
        )
        evaluations += solution.evaluations
    return solution, evaluations


def _if_linear(model: Model, measurement: Measurement, objective: Objective) -> Real | None:
    """The best parameters (p,) of a model that is linear in them, all of them from zero up.

    None where it is not, where levels have parameters of their own, or the objective is not of
    differences of K.
    """
    ends = {(parameter.lower, parameter.upper) for parameter in model.parameters}
    if model.own or objective.logarithmic or ends != {(0.0, np.inf)}:
        return None
    size = float(np.mean(measurement.magnitude))
    count = len(model.parameters)
    one, other = (
        model.network.respond(size * theta, measurement.points, GRADIENT)
        for theta in (np.ones(count), np.arange(1.0, count + 1.0))
    )
    if not np.allclose(one.by_theta, other.by_theta, rtol=ALIKE, atol=0.0):
        return None
    weights = objective.weighing(measurement)
    columns = weighted(one.by_theta, weights, objective.turn).T
    rest = measurement.stiffness - (one.value - size * one.by_theta.sum(axis=0))
    return non_negative(columns, weighted(rest, weights, objective.turn))[0]


def _superposed_start(
    model: Model, measurement: Measurement, objective: Objective, starts: int
) -> Real:
    """A start (p,) from the fit to data that are laid over one another."""
    rest, reduced, values = superposed(model, measurement)
    laid_over = fit(rest, reduced, objective, starts=starts)
    return model.picked(values | rest.named(laid_over.theta))


def _released_starts(
    model: Model, measurement: Measurement, objective: Objective, starts: int
) -> list[Real]:
    """Starts (p,) of a model with held or bounded parameters.

    Those of the free one, where it may go.
    """
    if not starts:
        return []
    free = model.released()
    known = task_of(free, measurement, objective)
    u = known.starts(starts)[1][0]
    best = fit(free, measurement, objective, starts=starts).theta
    full = np.concatenate([known.coordinates.theta(u, known.coordinates.size[0]), best[None]])
    # A start that ran away without limit becomes a number again, which the bounds of this model
    # then cut.
    return list(within_bounds(model, np.nan_to_num(model.started(full), posinf=1e300)))


def _search(
    task: Task, seeds: Real, starts: int, offset: float, effort: Effort
) -> tuple[Solution, int]:
    """Solutions for one data set, and the evaluations spent.

    From `seeds` (s, p) and from starts read off the data.

    Most fits are settled by a few steps in all parameters. Where they are not, a narrow curved
    valley holds them up: then the shapes are searched, with the gains projected out.
    """
    u, evaluations = seeds, 0
    if starts:
        shapes, placed = task.starts(starts, offset)
        u, evaluations = np.concatenate([seeds, placed[0]]), shape_count(task.branches)
    # In all parameters and few steps first: it settles most fits, and costs less than projecting
    # the gains out.
    quick = task.solve(u[None], iterations=QUICK, damping=SCANNED, flat=effort.negligible)
    evaluations += quick.evaluations
    alike = max(ALIKE, STOPS * effort.negligible)
    agreed = _agreed(quick, task.floor[0], AGREE, alike)
    # Where none but given starts are asked for, their ends are the answer.
    ended = not starts and bool(quick.converged.all())
    if agreed or ended or float(quick.cost.min()) > effort.hopeless:
        return quick, evaluations
    # What was reached goes along, so that the longer way cannot end higher.
    best = quick.u[np.argsort(quick.cost)[:1]]
    # Fewer dimensions: with the best gains at each shape the valley is short and straight.
    v = task.shaped(np.concatenate([best, seeds]))
    if starts:
        v = np.concatenate([v, shapes[0]])
    # Descents that stop that far above their end agree as the quick ones do; else all would go on
    # to the last step.
    valley = task.solve_shapes(v[None], flat=max(effort.negligible, FLAT_SHAPES), alike=alike)
    # As many as must agree go on to the search in all parameters.
    keen = valley.u[np.argsort(valley.cost)[:AGREE]]
    near_ends = np.concatenate([task.full(keen[None])[0], best])[None]
    last = task.solve(near_ends, damping=NEAR, flat=effort.negligible, alike=alike)
    return last, evaluations + valley.evaluations + last.evaluations


def _offset(rng: np.random.Generator) -> float:
    """How far the scanned shapes are moved.

    One of a few, so that their scan on a grid need not be repeated.
    """
    return float(rng.integers(JITTERS)) / JITTERS


def _agreed(solution: Solution, floor: float, votes: int, slack: float) -> bool:
    """Whether a start has reached the floor, or enough of them rest at the best objective."""
    # No optimum can be proved the best; starts from different places that meet in one are the
    # evidence.
    least = solution.cost.min()
    agree = solution.converged & (solution.cost <= least * (1.0 + slack))
    return bool(least <= floor or np.count_nonzero(agree) >= votes)


def scanned_starts(problem: Problem, rng: np.random.Generator) -> Real:
    """Search points (Q, d) of a scan of the model's shapes, with their best gains, best first."""
    task = task_of(problem.model, problem.measurement, problem.objective)
    u = task.starts(shape_count(task.branches), _offset(rng))[1]
    with np.errstate(all="ignore"):
        theta = task.coordinates.theta(u[0], task.coordinates.size[0])
        points: Real = problem.space.from_theta(within_bounds(problem.model, theta))
    return points


def require_enough(model: Model, measurement: Measurement) -> None:
    """Check that there are no more unknowns than data.

    Raises
    ------
    DataError
        If there are.
    """
    unknowns, data = len(model.parameters), 2 * len(measurement)
    if is_material(model):
        # The lines of a spectrum are chosen anew for each data, no more than these can bear.
        unknowns = len(Continuum().parameters) + len(own_parameters(model))
    if unknowns > data:
        points = counted(len(measurement), "measured point")
        raise DataError(
            f"{measurement.name}: {model.name} has {unknowns} parameters, but there are only {data}"
            f" numbers in {points}; choose a simpler model or measure at more frequencies"
        )


def within_bounds(model: Model, theta: Real) -> Real:
    """Parameters (..., p) moved to the bounds of the model where they lie beyond them."""
    return np.clip(theta, *model.box)


class BoundedDescent:
    """Levenberg-Marquardt in coordinates in which every parameter is a ratio.

    Logarithms, or fractions of the box.

    Parameters
    ----------
    recorder : Recorder
        Where values come from; it counts them and ends the descent.
    """

    def __init__(self, recorder: Recorder) -> None:
        self.recorder = recorder
        self._log = np.array(
            [p.scale == "log" and p.lower >= 0 for p in recorder.problem.space.parameters]
        )

    def from_scan(self, rng: np.random.Generator, starts: int) -> tuple[Real, Real]:
        """Ends (starts, d) of descents from the best of one scan of shapes, and their objectives.

        Parameters
        ----------
        rng : numpy.random.Generator
            Moves the scan.
        starts : int
            Descents side by side.

        Raises
        ------
        OptionError
            If it is not a sweep that is fitted.
        """
        problem = self.recorder.problem
        if not isinstance(problem, Problem):
            raise OptionError("shapes are scanned among sweeps only")
        # A scanned shape costs a model evaluation too: the recorder is asked for the objective at
        # each. The scan gives the best first, of which a run that has counted a few of them must
        # know nothing yet.
        scanned = rng.permutation(self._admitted(scanned_starts(problem, rng)))
        best = scanned[np.argsort(self.recorder.batch(scanned))[:starts]]
        # In the box of the study, so that this descent searches where all others do.
        return self.from_points(best)

    def from_points(self, x: Real) -> tuple[Real, Real]:
        """Where descents from points (s, d) of the box end (s, d), and their objectives (s,)."""
        low, high = self._inner(self.recorder.lower), self._inner(self.recorder.upper)
        end = levenberg_marquardt(self._evaluate, self._inner(x), low, high)
        return self._outer(end.u), end.cost

    def _admitted(self, x: Real) -> Real:
        """The points that are finite, moved into the box."""
        return np.clip(x[np.all(np.isfinite(x), axis=1)], self.recorder.lower, self.recorder.upper)

    def _inner(self, x: Real) -> Real:
        """Inner coordinates of search points (..., d)."""
        return np.log(x, out=np.array(x), where=self._log)

    def _outer(self, y: Real) -> Real:
        """Search points of inner coordinates (..., d)."""
        return np.exp(y, out=np.array(y), where=self._log)

    def _evaluate(self, y: Real, rows: object) -> tuple[Real, Real]:
        """Residuals (r, 2n) and their derivative (r, d, 2n) by the inner coordinates (r, d)."""
        x = self._outer(y)
        residual, jacobian = self.recorder.residual_batch(x)
        slope: Real = jacobian.swapaxes(-1, -2) * np.where(self._log, x, 1.0)[:, :, None]
        return residual, slope


def minima_in_box(problem: Problem, scans: int = 4, starts: int = 8) -> Real:
    """Objectives (n,) at the ends of descents from several scans, smallest first.

    Parameters
    ----------
    problem : Problem
        What is minimised.
    scans, starts : int
        Scans, and descents from each.
    """
    descent, rng = BoundedDescent(Recorder(problem, sys.maxsize)), np.random.default_rng(0)
    with np.errstate(all="ignore"):
        return np.sort(np.concatenate([descent.from_scan(rng, starts)[1] for _ in range(scans)]))
