"""The search for the parameters of effects around any linear passive material.

Free factors of shifts begin where neighbouring sweeps lie over one another, pair by pair: a sweep
predicts its neighbour where the two overlap, and ever less surely beyond its ends; the shift that
makes the neighbour likeliest under this prediction is taken. The factors of all levels follow from
the pairs by least squares.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from springpot.measurement.measurement import Measurement
from springpot.numerics import DECADE, MOST_STEPS, level_means, vertex
from springpot.rheology.effect import Effect
from springpot.rheology.elements import Continuum
from springpot.rheology.factors import arrhenius, wlf
from springpot.rheology.levels import Levels, levels_of
from springpot.rheology.nodes import Shift
from springpot.rheology.points import Real

from .leastsquares import Effort, Trial
from .material import STILL, SpectrumSearch
from .problem import Objective
from .starts import Window, settings, thinned

if TYPE_CHECKING:
    from springpot.rheology.model import Model

NEAR = 0.02
"""Error of a prediction between measured points, in ln|K| and in radian.

A line between points a fifth of a decade
apart misses a Maxwell element's curve by about this much."""
FAR = 0.5
"""Growth of the error for each factor e beyond a sweep's end.

The slope there is known to about this.
"""
LOST = 3.0
"""The most that a prediction is wrong by; points further off say nothing."""
STEP = 0.1
"""Grid of shifts in ln omega, beside which the best is found by a parabola."""
LAWS = 4096
"""Settings of a law that are held against the factors: each costs no fit."""
NEAREST = 12
"""Of these so many go on.

The factors are first guesses, and the data tell which law is the nearest.
"""
LIFT = 0.3
"""Standard deviation of ln b that is expected between neighbours.

Densities and rubber elasticity change by less.
"""


@dataclass(frozen=True, eq=False)
class _Curve:
    """One sweep: ln|K| and the phase against ln omega, with straight ends."""

    x: Real
    y: Real
    slopes: Real

    @classmethod
    def of(cls, measurement: Measurement, rows: NDArray[np.int64]) -> _Curve:
        x, which = np.unique(np.log(measurement.omega[rows]), return_inverse=True)
        log_k = np.log(measurement.stiffness[rows])
        count = np.bincount(which.ravel())
        y = np.array(
            [np.bincount(which.ravel(), part) / count for part in (log_k.real, log_k.imag)]
        )
        # A third of the sweep, as the slope of two points would be that of their noise.
        third = max(2, len(x) // 3)
        ends = [(x[:third], y[:, :third]), (x[-third:], y[:, -third:])]
        return cls(x, y, np.array([_slope(*end) for end in ends]))

    def predict(self, x: Real) -> tuple[Real, Real]:
        """Values (2, ...) at places (...), and their error (...)."""
        values = np.array([np.interp(x, self.x, part) for part in self.y])
        below, above = np.minimum(x - self.x[0], 0.0), np.maximum(x - self.x[-1], 0.0)
        values = (
            values
            + np.multiply.outer(self.slopes[0], below)
            + np.multiply.outer(self.slopes[1], above)
        )
        return values, np.minimum(NEAR + FAR * (above - below), LOST)


def _slope(x: Real, y: Real) -> Real:
    away = x - x.mean()
    spread = float(away @ away)
    # All at one frequency: no line has a slope there.
    if not spread > 0.0:
        return np.zeros(2)
    return np.asarray(y @ away / spread, dtype=np.float64)


def _pair(one: _Curve, other: _Curve, moves: bool, lifts: bool) -> tuple[float, float]:
    """The ln a and ln b for which `other` at omega is b times `one` at a omega."""
    low, high = one.x[0] - other.x[-1] - DECADE, one.x[-1] - other.x[0] + DECADE
    grid = np.zeros(1)
    if moves:
        grid = np.arange(low, high + STEP, STEP)
    # Both ways, as each sweep predicts the other where they overlap: neither is the truth.
    forth, forth_sd = one.predict(other.x + grid[:, None])
    back, back_sd = other.predict(one.x - grid[:, None])
    error = np.concatenate([other.y[:, None, :] - forth, back - one.y[:, None, :]], axis=-1)
    sd = np.concatenate([forth_sd, back_sd], axis=-1)
    weight = sd**-2.0
    # The expectation that ln b is small counts as one more measurement of it, as wide as LIFT.
    log_b = np.sum(weight * error[0], axis=-1) / (np.sum(weight, axis=-1) + LIFT**-2.0) * lifts
    error[0] -= log_b[:, None]
    # Heavy tails: one end of a sweep may be the instrument's.
    tails = 2.0 * np.log1p(error**2 / sd**2) + 2.0 * np.log(sd)
    deviance = np.sum(tails, axis=(0, -1)) + (log_b / LIFT) ** 2
    best = int(np.argmin(deviance))
    return float(grid[best]) + STEP * _vertex(deviance, best), float(log_b[best])


def _vertex(values: Real, i: int) -> float:
    """Place of the parabola's minimum beside the least of equidistant values, in steps."""
    # At an end of the grid there is no neighbour for a parabola.
    if not 0 < i < len(values) - 1:
        return 0.0
    return float(vertex(*values[i - 1 : i + 2]))


def aligned(model: Model, measurement: Measurement) -> dict[str, float]:
    """First guesses of all free factors of a model, by the names of their parameters.

    Parameters
    ----------
    model : Model
        With the levels of the data; see `Model.bound_to`.
    measurement : Measurement
        The data.
    """
    own = [(name, element) for name, element in _level_effects(model)]
    columns = list(dict.fromkeys(element.column for _, element in own))
    number = np.column_stack(
        [levels_of(column, measurement.points.need(column)) for column in columns]
    )
    combinations, which = np.unique(number, axis=0, return_inverse=True)
    curves = [
        _Curve.of(measurement, np.flatnonzero(which.ravel() == i)) for i in range(len(combinations))
    ]
    pairs = list(_neighbours(combinations))
    size = number.max(axis=0) + 1
    starts = np.concatenate([[0], np.cumsum(size)])
    matrix, differences = np.zeros((len(pairs), starts[-1])), np.zeros((len(pairs), 2))
    for row, (i, j, k) in enumerate(pairs):
        matrix[row, starts[k] + combinations[j, k]] = 1.0
        matrix[row, starts[k] + combinations[i, k]] = -1.0
        differences[row] = _pair(
            curves[i], curves[j], _moves(model, columns[k]), _lifts(own, columns[k])
        )
    # Pairs tell differences only: of all answers the one of least size is taken, and referred to
    # one level below.
    log_factors = np.linalg.lstsq(matrix, differences, rcond=None)[0]
    guesses: dict[str, float] = {}
    for prefix, element in own:
        k = columns.index(element.column)
        # The first column is of ln a, the second of ln b.
        column = 0
        if not element.logarithmic:
            column = 1
        here = log_factors[starts[k] : starts[k + 1], column]
        here = np.exp(here - here[element.reference])
        names = (f"{prefix}.{parameter.name}" for parameter in element.parameters)
        guesses |= dict(zip(names, here[list(element.free)].tolist(), strict=True))
    return guesses


def superposed(
    model: Model, measurement: Measurement
) -> tuple[Model, Measurement, dict[str, float]]:
    """The data laid over one another, the model without free factors, first guesses of these."""
    guesses = aligned(model, measurement)
    omega, stiffness, sd = measurement.omega, measurement.stiffness, measurement.sd
    for prefix, element in _level_effects(model):
        own = np.array([guesses[f"{prefix}.{parameter.name}"] for parameter in element.parameters])
        value = element.respond(own, measurement.points).value.real
        if element.logarithmic:
            omega = omega * np.exp(value)
            continue
        stiffness = stiffness / value
        if sd is not None:
            sd = sd / value
    rest = replace(model, effects=tuple(effect for effect in model.effects if not effect.by_levels))
    return rest, replace(measurement, omega=omega, stiffness=stiffness, sd=sd), guesses


def laid_over(model: Model, measurement: Measurement, own: Real) -> list[Real]:
    """Starts for laws of shifts and of vertical factors.

    Those nearest to the factors of overlapping sweeps.

    Parameters
    ----------
    model : Model
        With its effects.
    measurement : Measurement
        The data.
    own : ndarray, shape (q,)
        Parameters of the effects, of which those that are no law's are kept.

    Returns
    -------
    list of ndarray, shape (q,)
        Starts; none where no effect is such a law.
    """
    laws = [effect for effect in model.effects if _is_law(effect)]
    columns = {column for effect in laws for column in effect.needs if effect.plane == "shift"}
    if len(columns) != 1:
        return []
    (column,) = columns
    free = tuple(
        Effect(
            effect.plane,
            effect.composition,
            Levels(column, "f", effect.plane == "shift"),
            "",
            effect.layer,
        )
        for effect in laws
        if effect.needs == columns
    )
    # One level has nothing to be shifted to.
    if len(np.unique(measurement.levels(column))) < 2:
        return []
    points, starts, place = measurement.points, np.tile(own, (NEAREST, 1)), 0
    levels = replace(model, effects=free).bound_to(points)
    guesses = aligned(levels, measurement)
    targets = {}
    for prefix, element in _level_effects(levels):
        at = np.array([guesses[f"{prefix}.{parameter.name}"] for parameter in element.parameters])
        targets[element.logarithmic] = element.respond(at, points).value.real
    for effect in model.effects:
        parameters = effect.element.parameters
        if _is_law(effect) and effect.needs == columns:
            grid = settings(parameters, Window.of(measurement), LAWS)
            with np.errstate(all="ignore"):
                value = effect.element.respond(grid, points).value.real
                target = targets[effect.plane == "shift"]
                if effect.plane != "shift":
                    value, target = np.log(value), np.log(target)
                # Each is one at a level of its own choice: that is no difference.
                apart = np.std(value - target, axis=-1)
            # What is no number is sorted to the end.
            best = grid[np.argsort(apart)[:NEAREST]]
            starts[:, place : place + len(parameters)] = best
        place += len(parameters)
    return list(starts)


def _is_law(effect: Effect) -> bool:
    """Whether it is a law of shifts, or of real factors, of one condition."""
    scales = effect.plane == "shift" or (
        effect.plane == "log-complex" and "temperature" in effect.needs
    )
    return (
        scales
        and not effect.by_levels
        and len(effect.needs) == 1
        and bool(effect.element.parameters)
    )


def _level_effects(model: Model) -> Iterator[tuple[str, Levels]]:
    for effect, prefix in model.named_effects():
        if isinstance(effect.element, Levels):
            yield prefix, effect.element


def _moves(model: Model, column: str) -> bool:
    return any(
        effect.composition.kind is Shift and column in effect.needs for effect in model.effects
    )


def _lifts(own: list[tuple[str, Levels]], column: str) -> bool:
    return any(element.column == column and not element.logarithmic for _, element in own)


def _neighbours(combinations: NDArray[np.int64]) -> Iterator[tuple[int, int, int]]:
    """Numbers of two combinations that differ in one column k only, by neighbours there; and k."""
    for k in range(combinations.shape[1]):
        others = np.delete(combinations, k, axis=1)
        _, group = np.unique(others, axis=0, return_inverse=True)
        for each in np.unique(group):
            rows = np.flatnonzero(group.ravel() == each)
            rows = rows[np.argsort(combinations[rows, k])]
            for i, j in zip(rows[:-1].tolist(), rows[1:].tolist(), strict=True):
                yield i, j, k


SETTINGS = 6
"""Settings that are tried of each parameter of an effect for each start."""
STARTS = 8
"""Starts of a native fit, for each restart; of a material, those for which settings are tried."""
MOST_SETTINGS = 192
"""Settings that are tried at most, however many effects there are: each costs a convex problem."""
KEPT = 2
"""Settings from which the search begins."""
COARSE_POINTS = 120
"""Of more points so many show the effects' parameters; the last steps are taken with all of them.
"""
LAST = 3
"""Steps with all points: each squares the error that was left."""
MENDED = 0.998
"""Share of the objective that a round leaves at least where there is nothing more to be had."""


def fit_spectrum(
    model: Model,
    measurement: Measurement,
    objective: Objective,
    seeds_theta: Sequence[Real] = (),
    starts: int = STARTS,
    effort: Effort | None = None,
    expected: Real | None = None,
) -> tuple[SpectrumSearch, Trial, bool]:
    """The best end of a search for a material and the effects around it; whether it is at rest.

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
        How many starts read off the data settings of the effects' parameters stand for; 0 where
        the seeds are to be the only ones.
    effort : Effort, optional
        How far it goes.
    expected : ndarray, shape (r, q), optional
        What is known of the effects' q parameters beforehand: the squares of these rows times their
        logarithms are added to the objective (Tikhonov's regularisation).
    """
    search = SpectrumSearch.of(model, measurement, objective, expected)
    # A material alone is a convex problem: nothing is searched but its lines.
    if not search.own:
        return search, search.refined(search.solve(np.zeros(0))), True
    count = len(search.own)
    seeds = [np.asarray(seed, dtype=float)[len(seed) - count :] for seed in seeds_theta]
    effort = effort or Effort()
    return search, *_with_effects(search, measurement, objective, seeds, starts, effort)


def _with_effects(
    search: SpectrumSearch,
    measurement: Measurement,
    objective: Objective,
    seeds: Sequence[Real],
    starts: int,
    effort: Effort,
) -> tuple[Trial, bool]:
    """The best spectrum and effects' parameters, from seeds (q,) of these; whether at rest."""
    rows, coarse = thinned(measurement.points.log_omega, COARSE_POINTS), search
    part = len(rows) / len(measurement)
    if len(rows) < len(measurement):
        # What is expected weighs against the points: of fewer points as much less.
        expected = np.sqrt(part) * search.expected
        turn = None if search.turn is None else search.turn[rows]
        coarse = SpectrumSearch(
            search.model, measurement.subset(rows), search.weights[rows], expected, turn
        )
    settings_of_each = 0
    if not seeds:
        settings_of_each = SETTINGS * STARTS
    elif starts:
        # Beside seeds too: those of a scan may all lie in one valley, and it need not be the
        # deepest.
        settings_of_each = SETTINGS * min(starts, STARTS)
    places = [seeds]
    if settings_of_each:
        tried = list(_settings(search, measurement, settings_of_each))
        places += [tried, laid_over(search.model, measurement, tried[0])]
    still = max(STILL, effort.negligible)
    best, converged = _deepest(coarse, places, still, effort.hopeless * part)
    if coarse is not search:
        start = search.solve(search.u_of(coarse.theta_of(best.u)))
        best, _ = search.descend(start, LAST)
        search.evaluations += coarse.evaluations
    best = search.refined(best)
    # To move them makes no rival of what is hopeless.
    best = _on_closer_lines(search, best) if best.cost <= effort.hopeless else best
    if settings_of_each and not len(search.expected):
        ends = _on_laws(search, measurement, objective)
        ends = [
            _on_closer_lines(search, search.refined(end)) for end in ends if end.cost < best.cost
        ]
        best = min(ends, key=lambda each: each.cost, default=best)
    return best, converged


def _deepest(
    search: SpectrumSearch, places: Sequence[Iterable[Real]], still: float, hopeless: float
) -> tuple[Trial, bool]:
    """The best end of descents from the best starts of each kind; whether it came to rest."""
    begun: list[Trial] = []
    for some in places:
        # A setting costs one convex problem; descents are begun only from the best of them.
        trials = search.solve_each([search.begun(search.u_of(own)) for own in some])
        begun += sorted(trials, key=lambda trial: trial.cost)[:KEPT]
    ends = search.descend_each(begun, MOST_STEPS, still, hopeless)
    return min(ends, key=lambda end: end[0].cost)


def _on_closer_lines(search: SpectrumSearch, finer: Trial) -> Trial:
    """A trial on closer lines, which move together with the effects' parameters.

    One after the other they creep along a valley: of single Maxwell elements between the lines of
    the first lattice the factors were such that these lines fitted best, and the error stayed at
    1.5 x that of the noise.
    """
    for _ in range(MOST_STEPS):
        again, _ = search.descend(finer, LAST, lines=search.about(finer))
        again = search.nearest(again)
        if not again.cost < MENDED * finer.cost:
            return min(again, finer, key=lambda each: each.cost)
        finer = again
    return finer


def _on_laws(search: SpectrumSearch, measurement: Measurement, objective: Objective) -> list[Trial]:
    """Ends of the laws of temperature that free factors of it contain.

    Above none of them may the search for the factors end.
    """
    model = search.model
    free = [
        effect
        for effect in model.effects
        if effect.by_levels and effect.plane == "shift" and effect.needs == {"temperature"}
    ]
    # What is held is no longer free to follow a law.
    if len(free) != 1 or model.constrained:
        return []
    ends, material = [], model.material
    assert isinstance(material, Continuum)
    for element in (arrhenius(), wlf()):
        law = replace(free[0], element=element)
        effects = tuple(law if effect is free[0] else effect for effect in model.effects)
        lawful = replace(model, material=replace(material, rates=()), effects=effects)
        if 2 * len(measurement) <= len(lawful.parameters):
            continue
        fitted, best, _ = fit_spectrum(lawful, measurement, objective)
        ended, theta, _ = fitted.result(best)
        ends.append(_as_factors(search, free[0], law, ended, theta))
    return ends


def _as_factors(
    search: SpectrumSearch, free: Effect, law: Effect, ended: Model, theta: Real
) -> Trial:
    """A fitted law as free factors, with its lines."""
    points, levels = search.points, free.element
    assert isinstance(levels, Levels)
    known = ended.named(theta)
    constants = np.array([known[f"{law.name}.{p.name}"] for p in law.element.parameters])
    number = levels_of(levels.column, points.need(levels.column))
    log_a = law.element.respond(constants, points).value.real
    log_a = level_means(number, log_a)
    at_reference = log_a[levels.reference]
    factors = np.exp(log_a - at_reference)[list(levels.free)].tolist()
    names = [f"{free.name}.{parameter.name}" for parameter in levels.parameters]
    known |= dict(zip(names, factors, strict=True))
    material = ended.material
    assert isinstance(material, Continuum)
    # The curve is that of the level at which the factor is one.
    lines = np.log(np.array(material.rates)) - at_reference
    own = np.array([known[parameter.name] for parameter in search.own])
    return search.solve(search.u_of(own), lines)


def _settings(search: SpectrumSearch, measurement: Measurement, each: int) -> Real:
    """Settings (m, q) of the effects' parameters, so many of each.

    Factors of levels are read off the data.
    """
    known: dict[str, float] = {}
    if any(effect.by_levels for effect in search.model.effects):
        # A factor for each level is too many to be tried: overlapping sweeps tell where it lies.
        known = aligned(search.model, measurement)
    scanned = np.array([parameter.name not in known for parameter in search.own])
    count = min(each * int(scanned.sum()), MOST_SETTINGS) or 1
    places = np.tile([known.get(parameter.name, 1.0) for parameter in search.own], (count, 1))
    if scanned.any():
        others = tuple(parameter for parameter in search.own if parameter.name not in known)
        places[:, scanned] = settings(others, Window.of(measurement), count)
    return places
