"""The native solver: Levenberg-Marquardt from starts read off the data, all in one batch.

Descents that keep to the search box and whose every model evaluation is recorded.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from time import perf_counter

import numpy as np

from springpot.errors import DataError, OptionError
from springpot.measurement.measurement import Measurement
from springpot.numerics import ALIKE, NEGLIGIBLE, non_negative
from springpot.rheology.elements import Continuum
from springpot.rheology.model import Model
from springpot.rheology.nodes import GRADIENT
from springpot.rheology.points import Real
from springpot.writing import counted

from .fitted import Fit, task_of
from .leastsquares import AGREE, Effort, Solution, levenberg_marquardt
from .material import QUICK, is_material, own_parameters
from .material_fit import fit_spectrum, superposed
from .problem import Objective, Problem, default_objective, weighted
from .recorder import Recorder
from .space import Expected, require_conditions, require_size
from .starts import shape_count
from .task import FLAT_SHAPES, Task

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
