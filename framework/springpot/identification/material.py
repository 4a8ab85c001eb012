"""Fitting any linear passive material: its spectrum by non-negative least squares, what surrounds it by iteration.

For given parameters of the effects around it the weights of a `Continuum` are a convex problem with one solution:
no start, no local minimum. The effects' own parameters are found by variable projection (Golub and Pereyra 2003,
doi:10.1088/0266-5611/19/2/201) with the exact derivative on the lines that carry weight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from time import perf_counter

import numpy as np
from scipy.optimize import nnls

from springpot.measurement import Measurement
from springpot.rheology import GRADIENT, Complex, Continuum, Model, Node, Points, Real, Response

from .coordinates import Coordinates
from .objective import Objective, weighted
from .settings import Window, settings

PER_DECADE = 4
"""Lines a decade of the first lattice: a smooth spectrum is followed to 2 exp(-4.29 * 4) = 1e-7 (timedomain.md)."""
BEYOND = 2.0
"""Decades beyond the reduced frequencies: what relaxes further off is a spring or a dashpot to 1 %, squared."""
REFINEMENTS = 3
"""Times that the lattice is halved about the lines that carry weight; a single Maxwell element lies between lines."""
SETTINGS = 48
"""Settings of the effects' parameters that are tried for each of them."""
MOST_SETTINGS = 192
KEPT = 3
"""Settings from which the search begins."""
ITERATIONS = 40
STILL = 1e-9
"""Relative drop of the objective below which a step changes nothing that is printed."""
REACH = 3.0
"""Longest step of a coordinate: a factor of e^3 for a parameter searched by its logarithm."""
INNER = 6
"""Solutions for the weights where K is not linear in them, as behind a spring in series."""
LINEAR = 1e-6
"""Relative difference between foretold and real objective up to which K counts as linear in the weights."""
STEP = float(np.log(10.0)) / PER_DECADE


def is_material(model: Model) -> bool:
    """Whether the model's material is any linear passive one, whose spectrum the data choose."""
    return isinstance(model.material, Continuum)


def own_parameters(model: Model) -> list[int]:
    """Numbers of the parameters of the effects around a material, in the order of theta."""
    return list(range(len(model.material.parameters), len(model.parameters)))


@dataclass(frozen=True, eq=False)
class Spectral:
    """A material with effects at fitted parameters.

    Attributes
    ----------
    model : Model
        With the lines that carry weight.
    theta : ndarray, shape (p,)
        K_e, c, the weights of the lines, and the effects' parameters.
    cost : float
        Sum of squared weighted residuals.
    evaluations : int
        Evaluations spent.
    converged : bool
        Whether the last step changed nothing.
    """

    model: Model
    theta: Real
    cost: float
    evaluations: int
    converged: bool


@dataclass(frozen=True)
class _Probe(Node):
    """Stands in a material's place and keeps the reduced frequencies that reach it."""

    seen: list[tuple[float, float]]

    def respond(self, theta: Real, at: Points, depth: int = 0) -> Response:
        self.seen.append((float(np.min(at.log_omega.real)), float(np.max(at.log_omega.real))))
        one = np.ones(at.log_omega.shape, dtype=np.complex128)
        empty = np.zeros((*theta.shape[:-1], 0, at.log_omega.shape[-1]), dtype=np.complex128)
        return Response(one, empty, np.zeros_like(one))

    @property
    def parameters(self) -> tuple[()]:
        return ()


@dataclass(frozen=True, eq=False)
class _Trial:
    """The best spectrum at given parameters of the effects."""

    u: Real
    lines: Real
    weights: Real
    cost: float
    value: Complex
    by_weights: Complex
    by_own: Complex
    model: Model

    @property
    def theta(self) -> Real:
        """Weights and the effects' parameters as the model takes them; filled in by the search."""
        return self.weights


class _Search:
    """Variable projection for one model and one set of data."""

    def __init__(self, model: Model, measurement: Measurement, weights: Complex) -> None:
        self.model, self.measurement, self.weights = model, measurement, weights
        self.points = measurement.points
        self.own = tuple(model.parameters[i] for i in own_parameters(model))
        scale = float(np.exp(np.mean(np.log(measurement.magnitude))))
        amplitude = self.points.amplitude
        typical = 1.0 if amplitude is None else float(np.mean(amplitude))
        self.coordinates = Coordinates.of(self.own, float(np.mean(self.points.log_omega)), np.array([scale]), typical)
        self.size = self.coordinates.size[0]
        self.scale = scale
        self.evaluations = 0

    def theta_of(self, u: Real) -> Real:
        """The effects' parameters (q,) within their bounds."""
        theta = self.coordinates.theta(u.copy(), self.size)
        return np.clip(theta, [p.lower for p in self.own], [p.upper for p in self.own])

    def u_of(self, own: Real) -> Real:
        return self.coordinates.u(np.asarray(own, dtype=float).copy(), self.size)

    @cached_property
    def _bounds(self) -> tuple[Real, Real]:
        low, high = self.coordinates.bounds()
        return low[0], high[0]

    def with_lines(self, log_rates: Real) -> Model:
        return replace(self.model, material=Continuum(tuple(np.exp(log_rates).tolist())))

    def lattice(self, own: Real) -> Real:
        """Logarithms of the rates of the first lattice: those that the reduced frequencies can show."""
        probe = _Probe([])
        with np.errstate(all="ignore"):
            replace(self.model, material=probe).network.respond(own, self.points)
        low = min(seen[0] for seen in probe.seen) - BEYOND * np.log(10.0)
        high = max(seen[1] for seen in probe.seen) + BEYOND * np.log(10.0)
        # On multiples of the step, so that spectra of neighbouring settings have their lines in common.
        return STEP * np.arange(np.floor(low / STEP), np.ceil(high / STEP) + 1.0)

    def solve(self, u: Real, lines: Real | None = None, start: Real | None = None) -> _Trial:
        """The best spectrum for the effects' parameters `u`."""
        own = self.theta_of(u)
        lines = self.lattice(own) if lines is None else lines
        model = self.with_lines(lines)
        count = 2 + len(lines)
        weights = np.full(count, self.scale / count) if start is None else start
        data = self.measurement.stiffness
        foretold, trial = -1.0, None
        for _ in range(INNER):
            with np.errstate(all="ignore"):
                response = model.network.respond(np.concatenate([weights, own]), self.points, GRADIENT)
            self.evaluations += 1
            value, by_theta = response.value, response.by_theta
            if not (np.all(np.isfinite(value)) and np.all(np.isfinite(by_theta))):
                break
            residual = weighted(data - value, self.weights)
            cost = float(residual @ residual)
            if trial is None or cost < trial.cost or foretold < 0.0:
                trial = _Trial(u, lines, weights, cost, value, by_theta[:count], by_theta[count:], model)
            if foretold >= 0.0 and abs(cost - foretold) <= LINEAR * max(foretold, 1e-300) + 1e-12:
                break
            columns = weighted(by_theta[:count], self.weights)
            weights, foretold = non_negative(columns.T, residual + weights @ columns)
        if trial is None:
            nothing = np.zeros((0, len(self.points.log_omega)), dtype=np.complex128)
            return _Trial(u, lines, weights, np.inf, data, nothing, nothing, model)
        return trial

    def descend(self, u: Real) -> tuple[_Trial, bool]:
        """Levenberg-Marquardt on the effects' parameters."""
        trial, damping = self.solve(u), 1e-3
        low, high = self._bounds
        for _ in range(ITERATIONS):
            if not np.isfinite(trial.cost) or not len(u):
                return trial, True
            step = self._step(trial, damping)
            moved = np.clip(trial.u + step, low, high)
            other = self.solve(moved)
            drop = trial.cost - other.cost
            if drop > 0.0:
                trial, damping = other, max(0.1 * damping, 1e-9)
                if drop <= STILL * trial.cost:
                    return trial, True
            else:
                if float(np.max(np.abs(moved - trial.u), initial=0.0)) < 1e-7 or damping > 1e8:
                    return trial, True
                damping *= 10.0
        return trial, False

    def _step(self, trial: _Trial, damping: float) -> Real:
        """A step (q,) along which the lines that carry weight follow."""
        residual = weighted(self.measurement.stiffness - trial.value, self.weights)
        own = self.theta_of(trial.u)
        slopes = weighted(self.coordinates.carry(trial.by_own.copy(), own, self.size), self.weights).T
        carrying = weighted(trial.by_weights[trial.weights > 0.0], self.weights).T
        basis, _ = np.linalg.qr(carrying / np.maximum(np.linalg.norm(carrying, axis=0), 1e-300))
        slopes = slopes - basis @ (basis.T @ slopes)
        size = np.linalg.norm(slopes, axis=0)
        size = np.maximum(size, 1e-9 * max(float(size.max()), 1e-300))
        low, high = self._bounds
        downhill = slopes.T @ residual
        free = ~(((trial.u <= low) & (downhill < 0.0)) | ((trial.u >= high) & (downhill > 0.0)))
        inner = slopes[:, free] / size[free]
        matrix = inner.T @ inner + damping * np.eye(inner.shape[1])
        step = np.zeros(len(trial.u))
        step[free] = np.linalg.lstsq(matrix, inner.T @ residual, rcond=None)[0] / size[free]
        return np.clip(step, -REACH, REACH)

    def refined(self, trial: _Trial) -> _Trial:
        """The same with lines between those that carry weight, ever closer, as long as that explains more."""
        spacing = STEP
        for _ in range(REFINEMENTS):
            carrying = trial.lines[trial.weights[2:] > 0.0]
            if len(carrying) == 0:
                break
            spacing *= 0.25
            near = carrying[:, None] + spacing * np.arange(-4, 5)
            lines = np.unique(np.round(near.ravel() / spacing)) * spacing
            finer = self.solve(trial.u, lines)
            if not finer.cost < trial.cost:
                break
            trial = finer
        return trial

    def result(self, trial: _Trial, converged: bool) -> Spectral:
        kept = trial.weights[2:] > 0.0
        model = self.with_lines(trial.lines[kept])
        theta = np.concatenate([trial.weights[:2], trial.weights[2:][kept], self.theta_of(trial.u)])
        return Spectral(model, theta, trial.cost, self.evaluations, converged)


def non_negative(columns: Real, target: Real) -> tuple[Real, float]:
    """Weights >= 0 of columns (m, q) that come nearest to a target (m,), and the sum of squares that is left.

    Raises
    ------
    RuntimeError
        If the active set does not settle.
    """
    size = np.linalg.norm(columns, axis=0)
    size = np.where(size > 0.0, size, 1.0)
    scaled = columns / size
    if scaled.shape[0] > 2 * scaled.shape[1]:
        # The same problem in as many rows as columns: the active set then moves among small matrices.
        basis, scaled_down = np.linalg.qr(scaled)
        inside = basis.T @ target
        outside = max(float(target @ target - inside @ inside), 0.0)
        weights, rest = nnls(scaled_down, inside, maxiter=20 * scaled.shape[1])
        return weights / size, float(rest) ** 2 + outside
    weights, rest = nnls(scaled, target, maxiter=20 * scaled.shape[1])
    return weights / size, float(rest) ** 2


def fit_spectrum(
    model: Model, measurement: Measurement, objective: Objective, seeds_theta: Sequence[Real] = (), starts: int = 8
) -> Spectral:
    """Fit a material, and the effects around it, to a measurement.

    Parameters
    ----------
    model : Model
        Its material is a `Continuum`.
    measurement : Measurement
        The data.
    objective : Objective
        How the misfit is measured; a logarithmic one by its weights relative to |K|.
    seeds_theta : sequence of ndarray
        Starts, of which the last numbers are the effects' parameters.
    starts : int
        0 where the seeds are to be the only starts.
    """
    weights = objective.weights(measurement)
    if objective.logarithmic:
        weights = weights / measurement.magnitude
    search = _Search(model, measurement, np.asarray(weights, dtype=np.complex128))
    count = len(search.own)
    seeds = [search.u_of(np.asarray(seed, dtype=float)[len(seed) - count :]) for seed in seeds_theta]
    if count and (starts or not seeds):
        seeds += _scanned(search)
    ends = [search.descend(u) for u in (seeds if count else [np.zeros(0)])]
    best, converged = min(ends, key=lambda end: end[0].cost)
    return search.result(search.refined(best), converged)


def _scanned(search: _Search) -> list[Real]:
    """The most promising of many settings of the effects' parameters."""
    number = min(SETTINGS * len(search.own), MOST_SETTINGS)
    grid = settings(search.own, Window.of(search.measurement), number)
    trials = [search.solve(search.u_of(own)) for own in grid]
    trials.sort(key=lambda trial: trial.cost)
    return [trial.u for trial in trials[:KEPT]]
