"""Fitting any linear passive material.

Its spectrum by non-negative least squares, what surrounds it by iteration.

For given parameters of the effects around it the weights of a `Continuum` are a convex problem with
one solution: no start, no local minimum. The effects' own parameters are found by variable
projection (Golub and Pereyra 2003, doi:10.1088/0266-5611/19/2/201) with the exact derivative on the
lines that carry weight.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from springpot.measurement.measurement import Measurement
from springpot.numerics import (
    BEYOND,
    DECADE,
    FEWEST,
    MOST_STEPS,
    NEGLIGIBLE,
    PER_DECADE,
    PRINTED,
    ROUNDING,
    SMALLEST,
    non_negative,
    projected_out,
    vertex,
)
from springpot.rheology.effect import Layer
from springpot.rheology.elements import (
    Continuum,
    Probe,
    Tabulated,
    asked_as_measured,
    linear_in_material,
)
from springpot.rheology.nodes import GRADIENT, Node, Response
from springpot.rheology.parameters import Coordinates, box_of
from springpot.rheology.points import Complex, Real

from .leastsquares import Solving, Trial, Way
from .problem import BLOCK, Objective, numbers_of, weighted

if TYPE_CHECKING:
    from springpot.rheology.model import Model

REFINEMENTS = 3
"""Times that the lattice is halved about the lines that carry weight.

A single Maxwell element lies between lines.
"""
QUICK = 10
"""Steps after which it is asked whether a descent is hopeless."""
STILL = PRINTED * PRINTED
"""Relative drop of the objective below which a step changes nothing that is printed."""
WIDEST = 60.0 * DECADE
"""Range of reduced frequencies that no material has."""
INNER = 6
"""Solutions for the weights where K is not linear in them, as behind a spring in series."""
CLOSER = 0.25
"""Each refined lattice has lines this much closer than the one before."""
STEP = DECADE / PER_DECADE
"""Between lines of the first lattice, in ln r."""
FINE = STEP / 8
"""Between the places at which it is asked whether a further line would explain more."""
FINEST = STEP / 2048
"""Between the closest lines: what lies between them differs by 1e-8 of K."""
NEIGHBOURS = (-1 / 4, -1 / 16, -1 / 64, 0.0, 1 / 64, 1 / 16, 1 / 4)
"""Places about a line to which it may move, in steps of the first lattice: far, or a little."""


def is_material(model: Model) -> bool:
    """Whether the model's material is any linear passive one, whose spectrum the data choose.

    Examples
    --------
    >>> import springpot
    >>> from springpot.identification.material import is_material
    >>> is_material(springpot.parse_model("material")), is_material(springpot.parse_model("kelvin"))
    (True, False)
    """
    return isinstance(model.material, Continuum)


def own_parameters(model: Model) -> list[int]:
    """Numbers of the parameters of the effects around a material, in the order of theta."""
    return list(range(len(model.material.parameters), len(model.parameters)))


def prior_residual_of(expected: Real, own: Real) -> Real:
    """Departures (r,) of effects' parameters (q,) from what is expected (r, q) of some."""
    # A parameter of which nothing is expected may be zero, or have no logarithm.
    known = np.any(expected != 0.0, axis=0)
    return np.asarray(expected[:, known] @ np.log(own[known]), dtype=np.float64)


def prior_slopes(expected: Real, own: Real, by_u: Real) -> Real:
    """Slopes (r, p) of these departures, from those (q, p) of the parameters."""
    known = np.any(expected != 0.0, axis=0)
    return np.asarray(expected[:, known] @ (by_u[known] / own[known, None]), dtype=np.float64)


class SpectrumSearch:
    """Variable projection for one model and one set of data."""

    def __init__(
        self,
        model: Model,
        measurement: Measurement,
        weights: Complex,
        expected: Real | None = None,
        turn: Complex | None = None,
    ) -> None:
        self.model, self.data, self.weights = model, measurement.stiffness, weights
        self.turn = turn
        self.points = measurement.points
        self.own = tuple(model.parameters[i] for i in own_parameters(model))
        if expected is None:
            expected = np.zeros((0, len(self.own)))
        self.expected = expected
        self.scale = float(np.exp(np.mean(np.log(measurement.magnitude))))
        # Without amplitudes any size will do: no effect that has one can be fitted.
        typical = 1.0
        if self.points.amplitude is not None:
            typical = float(np.mean(self.points.amplitude))
        log_omega = float(np.mean(self.points.log_omega))
        self.coordinates = Coordinates.of(self.own, log_omega, np.array([self.scale]), typical)
        self.size = self.coordinates.size[0]
        self.low, self.high = (bound[0] for bound in self.coordinates.bounds)
        self._lower, self._upper = box_of(self.own)
        # Then one solution is exact; behind a spring in series K bends with the weights, and it
        # takes a few.
        self.linear = linear_in_material(model.network)
        # Then the lines are what they are at all settings, and their curves are worked out once.
        self.as_measured = asked_as_measured(model.network)
        self.evaluations = 0
        self._with_lines: dict[bytes, Node] = {}
        self._probe = Probe([])
        self._probed = replace(model, material=self._probe).network

    @classmethod
    def of(
        cls,
        model: Model,
        measurement: Measurement,
        objective: Objective,
        expected: Real | None = None,
    ) -> SpectrumSearch:
        """The search in units of an objective, a logarithmic one by its weights relative to |K|."""
        weights = objective.weighing(measurement)
        if objective.logarithmic:
            weights = weights / measurement.magnitude
        weights = np.asarray(weights, dtype=np.complex128)
        return cls(model, measurement, weights, expected, objective.turn)

    def weigh(self, values: Complex) -> Real:
        """Differences of K, or their derivatives, (..., n) as residuals (..., 2n)."""
        return weighted(values, self.weights, self.turn)

    def held(self, best: Trial, place: int, coordinate: float) -> Trial:
        """The best spectrum with one of the effects' coordinates held, the others refitted."""
        u = best.u.copy()
        u[place] = coordinate
        trial = self.solve(u)
        if len(self.own) == 1:
            return trial
        # Bounds that meet hold a coordinate in its place.
        low, high = self.low, self.high
        self.low, self.high = (
            np.where(np.arange(len(u)) == place, coordinate, bound) for bound in (low, high)
        )
        trial, _ = self.descend(trial, QUICK)
        self.low, self.high = low, high
        return trial

    def theta_of(self, u: Real) -> Real:
        """The effects' parameters (..., q) within their bounds."""
        theta = self.coordinates.theta(u, self.size)
        return np.minimum(np.maximum(theta, self._lower), self._upper)

    def u_of(self, own: Real) -> Real:
        """Search coordinates (q,) of the effects' parameters."""
        return self.coordinates.u(np.asarray(own, dtype=float).copy(), self.size)

    def prior_residual(self, u: Real) -> Real:
        """How far the effects' parameters at `u` lie from what is expected, weighted (r,)."""
        # Where nothing is expected, a parameter may be zero and have no logarithm.
        if not len(self.expected):
            return np.zeros(0)
        return prior_residual_of(self.expected, self.theta_of(u))

    def with_lines(self, log_rates: Real) -> Model:
        """The model with a spectrum of these lines."""
        material = self.model.material
        assert isinstance(material, Continuum)
        lines = replace(material, rates=tuple(np.exp(log_rates).tolist()))
        return replace(self.model, material=lines)

    def _network(self, log_rates: Real) -> Node:
        """Its network at the measured points.

        Neighbouring settings mostly have the same lines.
        """
        key = log_rates.tobytes()
        if key not in self._with_lines:
            model = self.with_lines(log_rates)
            if self.as_measured:
                material = model.material
                assert isinstance(material, Continuum)
                basis, _ = material.basis(self.points.log_omega, False)
                model = replace(model, material=Tabulated(basis, material))
            self._with_lines[key] = model.network
        return self._with_lines[key]

    def lattice(self, own: Real) -> Real:
        """Logarithms of the rates of the first lattice.

        Those that the reduced frequencies can show.
        """
        if self.as_measured:
            return self._first_lattice
        return self._lattice(own)

    @cached_property
    def _first_lattice(self) -> Real:
        return self._lattice(self.theta_of(np.clip(np.zeros(len(self.own)), self.low, self.high)))

    def _lattice(self, own: Real) -> Real:
        probe = self._probe
        probe.seen.clear()
        with np.errstate(all="ignore"):
            self._probed.respond(own, self.points)
        ends = list(chain.from_iterable(probe.seen))
        if not np.all(np.isfinite(ends)) or max(ends) - min(ends) > WIDEST:
            return np.zeros(
                0
            )  # a setting under which nothing can be measured: the solution says so
        low = min(seen[0] for seen in probe.seen) - np.log(BEYOND)
        high = max(seen[1] for seen in probe.seen) + np.log(BEYOND)
        # On multiples of the step, so that spectra of neighbouring settings have their lines in
        # common.
        return STEP * np.arange(np.floor(low / STEP), np.ceil(high / STEP) + 1.0)

    def respond(self, trial: Trial) -> Response:
        """K of a trial and its derivative."""
        [response] = self.respond_each([trial])
        return response

    def respond_each(self, trials: Sequence[Trial]) -> list[Response]:
        """The same of several, those of the same lines at once."""
        responses: dict[int, Response] = {}
        for rows, values, by_thetas in self._respond_alike(trials):
            for i, value, by_theta in zip(rows, values, by_thetas, strict=True):
                responses[i] = Response(value, by_theta)
        return [responses[i] for i in range(len(trials))]

    def _respond_alike(
        self, trials: Sequence[Trial]
    ) -> Iterator[tuple[list[int], Complex, Complex]]:
        """Numbers of trials (k,) of the same lines, with their K (k, n) and dK/dtheta (k, p, n)."""
        self.evaluations += len(trials)
        alike: dict[bytes, list[int]] = {}
        for i, trial in enumerate(trials):
            alike.setdefault(trial.log_rates.tobytes(), []).append(i)
        for rows in alike.values():
            one = trials[rows[0]]
            most = max(1, BLOCK // (len(one.weights) * len(self.data)))
            for some in (rows[k : k + most] for k in range(0, len(rows), most)):
                yield some, *self._at_once([trials[i] for i in some])

    def _at_once(self, trials: Sequence[Trial]) -> tuple[Complex, Complex]:
        """K (k, n) and dK/dtheta (k, p, n) of trials of the same lines."""
        network = self._network(trials[0].log_rates)
        own = self.theta_of(np.array([trial.u for trial in trials]))
        theta = np.concatenate([[trial.weights for trial in trials], own], axis=1)
        with np.errstate(all="ignore"):
            if len(trials) == 1:
                one = network.respond(theta[0], self.points, GRADIENT)
                return one.value[None], one.by_theta[None]
            each = network.respond(theta, self.points, GRADIENT)
        return each.value, each.by_theta

    def solve(self, u: Real, log_rates: Real | None = None) -> Trial:
        """The best spectrum for the effects' `u`; of infinite cost where K is no number."""
        [best] = self.solve_each([self.begun(u, log_rates)])
        return best

    def begun(self, u: Real, log_rates: Real | None = None, near: Trial | None = None) -> Trial:
        """What `solve_each` begins with: weights of a trial nearby, if it has the same lines."""
        if log_rates is None:
            log_rates = self.lattice(self.theta_of(u))
        count = 2 + len(log_rates)
        # Where K is linear in the weights any start will do, but from zero nothing large cancels:
        # over a wide reduced range a dashpot's share of |K| is 1e50 at the other end. Elsewhere it
        # matters: all share |K| evenly.
        start = np.zeros(count)
        if not self.linear:
            start = np.full(count, self.scale / count)
            if near is not None and np.array_equal(near.log_rates, log_rates):
                start = near.weights
        return Trial(u, log_rates, start, np.inf)

    def solve_each(self, begun: Sequence[Trial]) -> list[Trial]:
        """The best spectra for several settings, side by side."""
        all_of_them = [Solving(trial, trial) for trial in begun]
        going = all_of_them
        for _ in range(INNER):
            going = [going[i] for i in self._solved_once(going)]
            if not going:
                break
        return [each.best for each in all_of_them]

    def _solved_once(self, going: Sequence[Solving]) -> list[int]:
        """Solve for the weights with K as it is there, and tell which to do so once more."""
        again = []
        for rows, value, by_theta in self._respond_alike([each.trial for each in going]):
            count = len(going[rows[0]].trial.weights)
            sound = np.all(np.isfinite(value), axis=-1) & np.all(np.isfinite(by_theta), axis=(1, 2))
            with np.errstate(all="ignore"):
                residuals, columns = self.weigh(self.data - value), self.weigh(by_theta[:, :count])
            again += [
                i
                for row, i in enumerate(rows)
                if sound[row] and self._weights_solved(going[i], residuals[row], columns[row])
            ]
        return sorted(again)

    def _weights_solved(self, at: Solving, residual: Real, columns: Real) -> bool:
        """Take the weights of the columns (m, 2n) that leave least; whether to do so once more."""
        trial = at.trial
        prior_residual = self.prior_residual(trial.u)
        beside = float(prior_residual @ prior_residual)
        with np.errstate(over="ignore"):
            cost = float(residual @ residual) + beside
        if not np.isfinite(cost):
            # K is a number, its square is none: a wave in a specimen driven at its resonance.
            return False
        if np.isfinite(at.foretold):
            if cost < at.best.cost:
                at.best = replace(trial, cost=cost)
            if abs(cost - at.foretold) <= NEGLIGIBLE * at.foretold + ROUNDING:
                return False
        # What the last weights explain is put back: whole weights are found, and these must not be
        # negative.
        weights, left = non_negative(columns.T, residual + trial.weights @ columns)
        at.foretold = left + beside
        at.trial = replace(trial, weights=weights)
        if self.linear:
            at.best = replace(at.trial, cost=at.foretold)
        return not self.linear

    def descend(
        self, trial: Trial, iterations: int = MOST_STEPS, lines: Real | None = None
    ) -> tuple[Trial, bool]:
        """`descend_each` from one trial."""
        [end] = self.descend_each([trial], iterations, lines=lines)
        return end

    def descend_each(
        self,
        trials: Sequence[Trial],
        iterations: int = MOST_STEPS,
        still: float = STILL,
        hopeless: float = np.inf,
        lines: Real | None = None,
    ) -> list[tuple[Trial, bool]]:
        """Levenberg-Marquardt on the effects' parameters from several trials, side by side.

        Where each ended, and whether it came to rest; ended early where it is hopeless. The
        spectrum has the given lines, by default those of the first lattice.
        """
        ways = [Way(trial) for trial in trials]
        going = [way for way in ways if len(way.trial.u) and np.isfinite(way.trial.cost)]
        self._turn(going)
        for step in range(MOST_STEPS):
            if step == QUICK:
                going = [way for way in going if self._may_reach(hopeless, way.trial)]
            # A try that is refused is none of the steps: the next one is only shorter.
            going = [
                way for way in going if way.taken < iterations and way.moves(self.low, self.high)
            ]
            if not going:
                break
            begun = [self.begun(way.ahead, lines, way.trial) for way in going]
            for way, other in zip(going, self.solve_each(begun), strict=True):
                way.take(other, still)
            going = [way for way in going if not way.at_rest]
            self._turn([way for way in going if way.better])
        return [(way.trial, way.at_rest) for way in ways]

    def _may_reach(self, cost: float, trial: Trial) -> bool:
        """Whether a trial is as good as that, or is on closer lines.

        What the first lattice leaves of a sharp relaxation is no misfit of the effects.
        """
        return trial.cost <= cost or self.refined(trial).cost <= cost

    def _turn(self, ways: Sequence[Way]) -> None:
        """The slopes where each of them has come to."""
        responses = self.respond_each([way.trial for way in ways])
        for way, response in zip(ways, responses, strict=True):
            way.slopes = self._slopes(way.trial, response)

    def _slopes(self, trial: Trial, response: Response) -> tuple[Real, Real]:
        """Residual (m,) and its fall (m, q) with u where the lines that carry weight follow.

        0 at a bound.
        """
        own = self.theta_of(trial.u)
        count = len(trial.weights)
        residual = self.weigh(self.data - response.value)
        by_u = self.coordinates.carry(response.by_theta[count:].copy(), own, self.size)
        slopes = self.weigh(by_u).T
        carrying = self.weigh(response.by_theta[:count][trial.weights > 0.0]).T
        # What the weights of the spectrum would take up of a change is no gain of the effects
        # (Golub and Pereyra).
        basis, _ = np.linalg.qr(carrying / np.maximum(np.linalg.norm(carrying, axis=0), SMALLEST))
        slopes = projected_out(slopes, basis)
        if len(self.expected):
            residual = np.concatenate([residual, -self.prior_residual(trial.u)])
            turn = self.coordinates.slopes(own, self.size)
            slopes = np.concatenate([slopes, prior_slopes(self.expected, own, turn)])
        downhill = slopes.T @ residual
        # What rests on its bound and would go beyond is left where it is.
        resting = ((trial.u <= self.low) & (downhill < 0.0)) | (
            (trial.u >= self.high) & (downhill > 0.0)
        )
        return residual, np.where(resting, 0.0, slopes)

    def refined(self, trial: Trial) -> Trial:
        """The same with closer lines about those of weight, and wherever one more explains more."""
        # A setting under which nothing can be measured has no lines.
        if not np.isfinite(trial.cost):
            return trial
        spacing = STEP
        for _ in range(REFINEMENTS):
            carrying = trial.log_rates[trial.weights[2:] > 0.0]
            spacing *= CLOSER
            # From neighbour to neighbour on either side: a line between two is carried by both.
            near = carrying[:, None] + spacing * np.arange(-1.0 / CLOSER, 1.0 / CLOSER + 1.0)
            finer = self.solve(trial.u, np.unique(np.round(near.ravel() / spacing)) * spacing)
            if not finer.cost < trial.cost:
                break
            trial = finer
        return self.nearest(trial)

    def about(self, trial: Trial) -> Real:
        """Logarithms of rates near those that carry weight, so that these may move a little."""
        carrying = trial.log_rates[trial.weights[2:] > 0.0]
        near = carrying[:, None] + STEP * np.array(NEIGHBOURS)
        return np.asarray(FINEST * np.unique(np.round(near.ravel() / FINEST)), dtype=np.float64)

    def nearest(self, trial: Trial) -> Trial:
        """The same with a line wherever a further one would explain more, until none would.

        The problem is convex in the spectrum, so that what no single further line betters nothing
        does (the gradient function of Lindsay 1983, doi:10.1214/aos/1176346059; its peaks by
        Groeneboom, Jongbloed and Wellner 2008, doi:10.1111/j.1467-9469.2007.00588.x).
        """
        for _ in range(MOST_STEPS):
            carrying = trial.log_rates[trial.weights[2:] > 0.0]
            finer = self.solve(trial.u, np.union1d(carrying, self._promising(trial)))
            if not finer.cost < (1.0 - NEGLIGIBLE) * trial.cost:
                return min(trial, finer, key=lambda each: each.cost)
            trial = finer
        return trial

    def _promising(self, trial: Trial) -> Real:
        """Logarithms of rates, between those of a fine grid, where a line would explain most."""
        lattice = self.lattice(self.theta_of(trial.u))
        # Lines that were given may stand where settings are too far for any to be asked.
        if not len(lattice):
            return lattice
        grid = np.arange(lattice[0], lattice[-1], FINE)
        rates = np.concatenate([trial.log_rates, grid])
        weights = np.concatenate([trial.weights, np.zeros(len(grid))])
        response = self.respond(replace(trial, log_rates=rates, weights=weights))
        columns = self.weigh(response.by_theta[2 + len(trial.log_rates) : len(weights)])
        # Of columns of one size, so that the square of a slope is what a line there alone would
        # explain.
        size = np.maximum(np.linalg.norm(columns, axis=1), SMALLEST)
        slope = columns @ self.weigh(self.data - response.value) / size
        worth = slope[1:-1] > NEGLIGIBLE * np.sqrt(trial.cost)
        peaks = 1 + np.flatnonzero((slope[1:-1] >= slope[:-2]) & (slope[1:-1] >= slope[2:]) & worth)
        tops = grid[peaks] + FINE * vertex(slope[peaks - 1], slope[peaks], slope[peaks + 1])
        # On a lattice of their own, so that what rounding adds to the data moves no line.
        return np.asarray(FINEST * np.unique(np.round(tops / FINEST)), dtype=np.float64)

    def affordable(self, trial: Trial) -> Trial:
        """The same with fewer lines, where those of weight are more than the data can bear."""
        # What is expected of a parameter counts as measured beside the data, and pays for it.
        free = np.sum(~np.any(self.expected != 0.0, axis=0))
        most = max(1, numbers_of(self.weights) - FEWEST - 2 - int(free))
        if np.sum(trial.weights[2:] > 0.0) <= most:
            return trial
        # Of a refined lattice the strongest lines are often neighbours: those of the first lattice
        # may do better.
        coarse = self._strongest(self.solve(trial.u), most)
        return min(self._strongest(trial, most), coarse, key=lambda each: each.cost)

    def _strongest(self, trial: Trial, most: int) -> Trial:
        """The same with the strongest lines alone, so many at most."""
        while (count := int(np.sum(trial.weights[2:] > 0.0))) > most:
            columns = self.weigh(self.respond(trial).by_theta[2 : len(trial.weights)])
            strength = trial.weights[2:] * np.linalg.norm(columns, axis=-1)
            # A few at a time: those that stay take over what the others carried.
            strongest = np.argsort(strength)[-max(most, int(0.75 * count)) :]
            trial = self.solve(trial.u, np.sort(trial.log_rates[strongest]))
        return trial

    def result(self, trial: Trial) -> tuple[Model, Real, float]:
        """The model with the lines that carry weight, its parameters (p,) and the objective."""
        trial = self.affordable(trial)
        # Lines without weight are no parameters: they would have intervals, and cost degrees of
        # freedom.
        kept = trial.weights[2:] > 0.0
        model = self.with_lines(trial.log_rates[kept])
        theta = np.concatenate([trial.weights[:2], trial.weights[2:][kept], self.theta_of(trial.u)])
        prior_residual = self.prior_residual(trial.u)
        # What was expected guides the search; the objective that is told is that of the data.
        cost = trial.cost - float(prior_residual @ prior_residual)
        return model, theta, cost


def shifted_by(model: Model) -> str:
    """The condition by which a model of any material is shifted; empty of any other model.

    Where the rig or the signals are in the model too, no material follows a level by itself.
    """
    columns = sorted(
        {name for each in model.effects if each.plane == "shift" for name in each.needs}
    )
    of_levels = all(each.layer == Layer.TEMPERATURE for each in model.effects)
    if is_material(model) and of_levels and len(columns) == 1:
        return columns[0]
    return ""
