"""Intervals of effects around any material: the spectrum is solved anew where an effect is held.

The weights of a spectrum may not fall below zero, and lines that carry nothing at the best fit may
carry something beside another size of the effect. Neither shows in the slopes at the best fit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from springpot.distributions import Links, autocorrelation_time, f_sf, student
from springpot.measurement.independence import at_one_frequency
from springpot.numerics import (
    BEYOND,
    DECADE,
    MOST_STEPS,
    PRINTED,
    ROUNDING,
    Tangent,
    non_negative,
    orthonormal,
)
from springpot.rheology.elements import Continuum, asked_as_measured
from springpot.rheology.levels import levels_of
from springpot.rheology.points import Real
from springpot.thresholds import VERDICT

from .convex import FASTER, SLOWER
from .intervals import Path, allowed_cost, bent, beside_endless, profiled
from .known_factors import ends_of_factors, laws_of_shift, refused_laws
from .leastsquares import Trial
from .material import SpectrumSearch, is_material, own_parameters, shifted_by
from .native import Fit
from .normal import RANK
from .problem import weighted
from .uncertainty import Uncertainty
from .value import Value, printed


def lack_of_fit(known: Uncertainty, column: str) -> tuple[float, float] | None:
    """Root mean square by which sweeps ask for shifts of their own, and its degrees of freedom.

    None if by chance.

    The test of lack of fit: what a free factor at each level would gain, in a step of least
    squares, over the scatter that is then left (Fisher; N. R. Draper and H. Smith, Applied
    Regression Analysis, 1998, section 2.1).

    Parameters
    ----------
    known : Uncertainty
        Of a fit with a law of shifts.
    column : str
        The condition whose levels the law joins.
    """
    fit = known.fit
    points = fit.measurement.points
    number = levels_of(column, points.need(column))
    slope = fit.model.slope(fit.theta, points)
    weights = fit.task.weights[0]
    if fit.task.logarithmic:
        slope = slope / fit.model.stiffness(fit.theta, points)
    columns = [
        weighted(np.where(number == i, slope, 0.0), weights, fit.objective.turn)
        for i in range(int(number.max()) + 1)
    ]
    freed, residual = np.nan_to_num(np.array(columns).T), fit.residual
    if fit.expected is not None:
        # What was expected knows of no shift.
        beside = len(fit.expected.rows)
        freed = np.concatenate([freed, np.zeros((beside, freed.shape[1]))])
        residual = np.concatenate([residual, known.prior_residual])
    least = np.sqrt(RANK)
    beyond = Tangent.of(known.slopes[:, known.at_bound == 0], least).left(freed)
    seen = np.linalg.norm(beyond, axis=0) > least * np.linalg.norm(freed, axis=0)
    gained = orthonormal(beyond[:, seen], least)
    spare = gained.shape[1]
    left = fit.dof - spare
    if not spare or left <= 0:
        return None
    gain = float(np.sum((gained.T @ residual) ** 2))
    whole = float(residual @ residual)
    rest = max((whole - gain) / left, ROUNDING**2 * whole / left)
    mean = gain / spare
    if not mean > rest or float(f_sf(mean / rest, spare, left)) >= VERDICT.structure_alarm:
        return None
    return float(np.sqrt(mean)), float(spare)


def widened(known: Uncertainty) -> Uncertainty:
    """What is known of the laws of a model.

    By the scatter of the levels about them where that is the larger.
    """
    if known.fit.dof <= 0:
        return known
    for effect in laws_of_shift(known.fit.model):
        (column,) = effect.needs
        spreads = [(known.scale, float(known.fit.dof))]
        # Neighbours that are alike count for fewer, whether or not a factor at each level would
        # mend them; what was given as the noise may hold what they share already.
        if not known.absolute:
            spreads = [(known.scale * float(np.sqrt(_alike(known, column))), float(known.fit.dof))]
        lack = lack_of_fit(known, column)
        if lack is not None:
            spreads.append(lack)
        spread = max(spreads, key=lambda one: one[0] * student(known.level, one[1]))
        if spread[0] > known.scale:
            return replace(known, spread=spread, memory=0.0)
    return known


def _alike(known: Uncertainty, column: str) -> float:
    data = known.fit.measurement
    number = levels_of(column, data.points.need(column))
    return autocorrelation_time(known.fit.residual, Links.of_levels(data.omega, number))


MOST_PROFILED = 6
"""Parameters around a free spectrum of which profiles are taken.

Factors of many levels would take seconds.
"""
FIRST_STEP = 0.01, 1.0
"""Least and most of the first step from the best fit, in coordinates, most of them logarithms.

A quarter of what the slopes give."""
GROWTH = 1.6
"""Factor from step to step: thirty of them go from a per cent to ten decades."""


def intervals_beside_material(known: Uncertainty) -> tuple[Real, Real]:
    """Ends (p,) of the intervals of all parameters.

    Those of effects around a free spectrum by profile.

    Of several effects' parameters only those that the slopes leave wide, as each takes many fits of
    the others.

    Parameters
    ----------
    known : Uncertainty
        Of a fit; of a model with a name its own intervals are given.
    """
    low, high = _ends_by_slopes_or_profile(known)
    if is_material(known.fit.model) and asked_as_measured(known.fit.model.network):
        # Neither end goes below the other, nor the upper one below the fit.
        ends = max_of_parts(known)
        high[: len(ends)] = np.minimum(high[: len(ends)], ends)
    for places, (least, most) in ends_of_factors(known):
        low[places], high[places] = least, most
    for i in shared_at_one_frequency(known.fit):
        parameter = known.fit.model.parameters[i]
        low[i], high[i] = parameter.lower, parameter.upper
    for effect, _ in refused_laws(known.fit):
        # What is no law has no constants, however sharply the objective tells them.
        for i, parameter in enumerate(known.fit.model.parameters):
            if parameter.name.startswith(f"{effect.name}."):
                low[i], high[i] = parameter.lower, parameter.upper
    return low, high


def parameters_of(known: Uncertainty, by_profile: bool = True) -> dict[str, Value]:
    """Parameters with these intervals in printed units.

    Parameters
    ----------
    known : Uncertainty
        Of a fit.
    by_profile : bool
        Whether wide intervals beside a free spectrum are taken by profile, which takes some 50 ms
        each.
    """
    fit = known.fit
    # The constants of superposition are those of a master curve, whatever command asks.
    if by_profile or shifted_by(fit.model):
        low, high = intervals_beside_material(known)
    else:
        low, high = known.interval()
    return printed(fit.model.parameters, fit.theta, low, high, fit.measurement.units)


def max_of_parts(known: Uncertainty) -> Real:
    """What K_e and c (2,) of a material are at most: its storage, and its loss over omega.

    No part of a passive material takes anything from another, however well lines that are slower
    or faster than what was measured stand in for it.
    """
    fit, points = known.fit, known.fit.measurement.points
    own = fit.theta[: len(fit.model.material.parameters)]
    found, weights = fit.model.material.respond(own, points).value, fit.task.weights[0]
    # A single point scatters no more for what it shares with the one before.
    known = replace(known, memory=0.0)
    with np.errstate(all="ignore"):
        scatter = known.quantile * known.scale / np.array([weights.real, weights.imag])
    if fit.task.logarithmic:
        scatter = scatter * np.abs(fit.model.stiffness(fit.theta, points))
    storage, loss = np.array([found.real, found.imag]) + scatter
    return np.array([np.min(storage), np.min(loss / np.exp(points.log_omega))])


def shared_at_one_frequency(fit: Fit) -> list[int]:
    """Numbers of the spring and the dashpot of a material whose data have one storage and loss.

    Its lines can take the part of both there, whatever the slopes beside the chosen lines say.
    """
    shifted = any(effect.plane == "shift" for effect in fit.model.effects)
    if not is_material(fit.model) or shifted or not at_one_frequency(fit.measurement):
        return []
    return [i for i, each in enumerate(fit.model.material.parameters) if not each.detail]


def _ends_by_slopes_or_profile(known: Uncertainty) -> tuple[Real, Real]:
    fit = known.fit
    low, high = known.interval()
    # The parameters of the material itself are known by each sweep.
    known = widened(known)
    if known.spread is not None:
        ends = known.interval()
        for i in own_parameters(fit.model):
            low[i], high[i] = ends[0][i], ends[1][i]
        # A profile is that of the scatter of points: what the levels allow has no objective to be
        # followed.
        return low, high
    if fit.dof <= 0:
        return low, high
    rise = allowed_cost(known) - fit.cost
    if not is_material(fit.model):
        for i in bent(known):
            low[i], high[i], _ = profiled(known, i)
        return beside_endless((Path.of(fit, i) for i in range(len(low))), rise, low, high)
    for i, (left, right) in enumerate(_ends_beside_lines(known)):
        # Other lines may serve better by the last digits of numbers without noise.
        low[i], high[i] = min(left, fit.theta[i]), max(right, fit.theta[i])
    own = own_parameters(fit.model)
    if len(own) > MOST_PROFILED:
        return low, high
    for i in own:
        narrow = high[i] - low[i] < abs(fit.theta[i])
        if known.at_bound[i] == 0 and (len(own) == 1 or not narrow):
            wider = rise * known.widening(i)
            low[i], high[i] = profile_beside_material(fit, i, wider, (low[i], high[i]))
    return low, high


def _ends_beside_lines(known: Uncertainty) -> list[tuple[float, float]]:
    """Intervals of K_e and c of a material, as wide as other lines leave them.

    None where K is not linear in them, or what was expected of effects would have to be held too.
    """
    fit = known.fit
    search = SpectrumSearch.of(fit.model, fit.measurement, fit.objective)
    if not search.linear or fit.expected is not None:
        return []
    own, material = own_parameters(fit.model), fit.model.material
    assert isinstance(material, Continuum), "no other material is any"
    lines = np.log(material.rates)
    others = search.lattice(fit.theta[own])
    # What relaxes more slowly than that is a spring, and what does so sooner a dashpot.
    slower, faster = np.log(BEYOND) - DECADE * np.array([SLOWER, FASTER])
    others = others[(others > others[0] + slower) & (others < others[-1] - faster)]
    lines = np.concatenate([lines, [each for each in others if not np.any(lines == each)]])
    weights = np.zeros(2 + len(lines))
    weights[: 2 + len(material.rates)] = np.delete(fit.theta, own)
    answer = search.respond(Trial(search.u_of(fit.theta[own]), lines, weights, fit.cost))
    columns, by_own = np.split(search.weigh(answer.by_theta).T, [len(weights)], axis=1)
    target = columns @ weights + search.weigh(fit.measurement.stiffness - answer.value)
    around = Tangent.of(by_own, RANK)
    columns, target = around.left(columns), around.left(target)
    rise = allowed_cost(known) - fit.cost
    return ends_of_amounts(columns, target, [known.widening(i) * rise for i in (0, 1)])


def profile_beside_material(
    fit: Fit, number: int, rise: float, by_slopes: tuple[float, float]
) -> tuple[float, float]:
    """Interval of an effect's parameter.

    Where the best objective has risen by so much, all else refitted.

    Parameters
    ----------
    fit : Fit
        Of a model whose material is any linear passive one.
    number : int
        Number of the parameter in theta.
    rise : float
        Of the objective, at the ends of the interval.
    by_slopes : tuple of float
        Where the ends should lie, by the slopes at the fit.

    Returns
    -------
    low, high : float
        The ends; a bound of the parameter where the objective never rises so far.

    Notes
    -----
    D. J. Venzon and S. H. Moolgavkar, 1988, doi:10.2307/2347496.
    """
    own = own_parameters(fit.model)
    place = own.index(number)
    expected = None
    if fit.expected is not None:
        expected = fit.expected.weighted
    search = SpectrumSearch.of(fit.model, fit.measurement, fit.objective, expected)
    # On the lattice of the search, not on the fitted lines: only there may others come in.
    best, _ = search.descend(search.solve(search.u_of(fit.theta[own])))

    def above(coordinate: float) -> float:
        return search.held(best, place, coordinate).cost - best.cost - rise

    ends, start = [], float(best.u[place])
    parameter = fit.model.parameters[number]
    sides = (search.low, parameter.lower), (search.high, parameter.upper)
    for end_by_slopes, (limits, bound) in zip(by_slopes, sides, strict=True):
        there = fit.theta[own]
        there[place] = end_by_slopes
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = float(np.nan_to_num(search.u_of(there)[place] - start))
        first = float(np.clip(0.25 * abs(reach), *FIRST_STEP))
        end = _crossing(above, start, float(limits[place]), first)
        if end is None:
            ends.append(bound)
            continue
        u: Real = best.u.copy()
        u[place] = end
        ends.append(float(search.theta_of(u)[place]))
    return ends[0], ends[1]


def ends_of_amounts(
    columns: Real, target: Real, rises: Sequence[float]
) -> list[tuple[float, float]]:
    """Intervals of the weights of the first columns, all others solved anew, none below zero.

    The least sum of squares is convex in what is held.

    Parameters
    ----------
    columns : ndarray, shape (m, q)
        What spring, dashpot and lines make of one unit each, in standard deviations.
    target : ndarray, shape (m,)
        What they should make together.
    rises : sequence of float
        Of the sum of squares, at the ends of each interval.

    Returns
    -------
    list of tuple of float
        Zero, or infinity, where it never rises so far.
    """
    whole: Real = np.array(np.linalg.qr(np.column_stack([columns, target]), mode="r"))
    columns, target = whole[:, :-1], whole[:, -1]
    weights, _ = non_negative(columns, target)
    return [
        _ends_of_amount(columns, target, i, float(weights[i]), rise) for i, rise in enumerate(rises)
    ]


def _ends_of_amount(
    columns: Real, target: Real, i: int, best: float, rise: float
) -> tuple[float, float]:
    """That of weight i: where the sum of squares has risen by so much from its best."""
    from scipy.optimize import brentq  # loading the plugins must not take its time

    others, size = np.delete(columns, i, axis=1), float(np.linalg.norm(columns[:, i]))
    if not size > 0.0:
        return 0.0, float("inf")
    reach = float(np.sqrt(rise))

    def left(amount: float) -> float:
        return float(non_negative(others, target - columns[:, i] * amount)[1])

    # Solved as all others are: of numbers without noise the digits of another way would be a rise.
    least = left(best)

    def above(amount: float) -> float:
        """Deviations beyond the end, nearly a straight line along the way."""
        return float(np.sqrt(max(left(amount) - least, 0.0))) - reach

    def end(outer: float) -> float:
        # Of an end two digits of its distance are printed.
        return float(brentq(above, best, outer, xtol=np.sqrt(PRINTED) * abs(outer - best)))

    low = end(0.0) if best > 0.0 and above(0.0) > 0.0 else 0.0
    outer = best + reach / size
    for _ in range(MOST_STEPS):
        if above(outer) > 0.0:
            return low, end(outer)
        outer += outer
    return low, float("inf")


def _crossing(
    above: Callable[[float], float], start: float, limit: float, step: float
) -> float | None:
    """Coordinate on the way to a limit at which a function that is negative at the start is zero.

    None if it does not become so.
    """
    from scipy.optimize import brentq  # loading the plugins must not take its time

    inner, sign = start, np.sign(limit - start)
    for _ in range(MOST_STEPS):
        outer = start + sign * min(step, abs(limit - start))
        if above(outer) > 0.0:
            return float(brentq(above, inner, outer, xtol=PRINTED))
        if outer == limit:
            return None
        inner, step = outer, GROWTH * step
    return None
