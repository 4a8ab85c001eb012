"""Intervals of effects around any material.

The spectrum is solved anew wherever the effect is held.

The weights of a spectrum may not fall below zero, and lines that carry nothing at the best fit may
carry something beside another size of the effect. Neither shows in the slopes at the best fit.
"""

from __future__ import annotations

from collections.abc import Callable

from springpot.measurement.independence import at_one_frequency
from springpot.rheology.points import Real

from .allowed_shifts import refused_laws
from .known_factors import ends_of_factors
from .lack_of_fit import widened
from .material import SpectrumSearch, is_material, own_parameters
from .native import Fit
from .uncertainty import Uncertainty, allowed_cost

MOST_PROFILED = 6
"""Parameters around a free spectrum of which profiles are taken.

Factors of many levels would take seconds.
"""
FIRST_STEP = 0.01
"""First step from the best fit, in coordinates, most of them logarithms: a per cent."""
GROWTH = 1.6
"""Factor from step to step: thirty of them go from a per cent to ten decades."""
MOST_STEPS = 40
"""Steps after which an interval has no end."""
PRECISE = 1e-4
"""Error of an end, in coordinates: below the four digits that are printed."""


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
    if not is_material(fit.model) or fit.dof <= 0:
        return low, high
    own = own_parameters(fit.model)
    if len(own) > MOST_PROFILED:
        return low, high
    rise = allowed_cost(known) - fit.cost
    for i in own:
        narrow = high[i] - low[i] < abs(fit.theta[i])
        if known.at_bound[i] == 0 and (len(own) == 1 or not narrow):
            low[i], high[i] = profile_beside_material(fit, i, rise)
    return low, high


def profile_beside_material(fit: Fit, number: int, rise: float) -> tuple[float, float]:
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

    ends = []
    for sign, limit in ((-1.0, search.low[place]), (1.0, search.high[place])):
        end = _crossing(above, float(best.u[place]), sign, float(limit))
        parameter = fit.model.parameters[number]
        if end is None:
            ends.append(parameter.lower if sign < 0.0 else parameter.upper)
            continue
        u: Real = best.u.copy()
        u[place] = end
        ends.append(float(search.theta_of(u)[place]))
    return ends[0], ends[1]


def _crossing(
    above: Callable[[float], float], start: float, sign: float, limit: float
) -> float | None:
    """Coordinate on one side at which a function that is negative at the start becomes zero.

    None if it does not.
    """
    from scipy.optimize import brentq  # loading the plugins must not take its time

    inner, step = start, FIRST_STEP
    for _ in range(MOST_STEPS):
        outer = start + sign * min(step, abs(limit - start))
        if above(outer) > 0.0:
            return float(brentq(above, inner, outer, xtol=PRECISE))
        if outer == limit:
            return None
        inner, step = outer, GROWTH * step
    return None
