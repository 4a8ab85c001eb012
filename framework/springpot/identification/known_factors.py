"""Which factors the data determine, where each may lie, and how far levels may be shifted.

Neighbouring levels are shifted no further than their sweeps can overlap; laws that do so are
named.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import student
from springpot.measurement.independence import meeting, ranges, reached_from
from springpot.measurement.measurement import Measurement
from springpot.rheology.effect import Effect, Layer
from springpot.rheology.elements import Relaxation
from springpot.rheology.levels import Levels, level_text, levels_of
from springpot.rheology.model import Model
from springpot.rheology.points import LARGEST_SHIFT, Real
from springpot.thresholds import INTERVAL, SUPERPOSITION

from ..numerics import ALIKE, DECADE, DEVIATIONS, FEWEST, level_means
from .free_factors import FactorRows, Factors, columns_of_factors, factors_of
from .levels_alone import FEW, Alone, each_alone
from .material import is_material
from .problem import relative_objective
from .space import spread_between
from .uncertainty import Uncertainty

if TYPE_CHECKING:
    from .native import Fit


@dataclass(frozen=True, eq=False)
class Allowed:
    """Bounds of a shift that follow from what the sweeps have in common.

    Sweeps with moduli in common have reduced frequencies in common, as |K| rises with the
    frequency. So two neighbours of which that is true are at most so far apart that the end of the
    one meets the end of the other.

    Attributes
    ----------
    column : str
        The condition.
    levels : ndarray, shape (m,)
        Its levels.
    first, last : ndarray, shape (m,)
        Logarithms of the least and the largest frequency measured at each.
    overlaps : ndarray of bool, shape (m, m)
        Which surely have moduli in common, their vertical factors applied.
    """

    column: str
    levels: Real
    first: Real
    last: Real
    overlaps: NDArray[np.bool_]

    def broken_by(self, log_a: Real) -> str:
        """What shifts (m,) do that no material could; empty where they may be those of one."""
        if not np.all(np.isfinite(log_a)):
            return "is endless at a level that was measured"
        i = np.arange(len(self.levels) - 1)
        # Their reduced frequencies would leave a gap, the one way or the other.
        up = self.first[i] + log_a[i] - self.last[i + 1] - log_a[i + 1]
        down = self.first[i + 1] + log_a[i + 1] - self.last[i] - log_a[i]
        gap = np.where(self.overlaps[i, i + 1], np.maximum(up, down), 0.0)
        at = int(np.argmax(gap))
        if gap[at] <= 0.0:
            return ""
        apart = abs(log_a[at] - log_a[at + 1]) / DECADE
        cold, hot = (level_text(self.column, float(self.levels[k])) for k in (at, at + 1))
        wide = max(self.last[at] - self.first[at], self.last[at + 1] - self.first[at + 1]) / DECADE
        return (
            f"shifts {cold} and {hot} apart by {apart:.2g} decades, though their sweeps of"
            f" {wide:.2g} decades have moduli in common"
        )


def allowed_shifts(data: Measurement, bound: Levels, log_b: Real, own: Alone) -> Allowed:
    """How far neighbouring levels can be shifted.

    Parameters
    ----------
    data : Measurement
        All sweeps.
    bound : Levels
        The levels.
    log_b : ndarray, shape (n,)
        Logarithm of the vertical factor at each point, by which moduli are divided.
    own : Alone
        Each level by itself.
    """
    number = levels_of(bound.column, data.points.need(bound.column))
    low, high = ranges(number, np.log(data.magnitude) - log_b)
    # Of a plateau the extremes are those of its scatter, and sweeps far apart on it share none.
    fitted, factor = np.isfinite(own.low), level_means(number, log_b)
    low, high = np.where(fitted, own.low - factor, low), np.where(fitted, own.high - factor, high)
    # Beyond their scatter: where two ends only just meet, nobody knows that they do.
    surely = meeting(low, high, -DEVIATIONS * np.sqrt(scatter_between(own)))
    first, last = ranges(number, data.points.log_omega)
    return Allowed(bound.column, np.array(bound.shown), first, last, surely)


def laws_of_shift(model: Model) -> Iterator[Effect]:
    """Effects that shift the frequency by a law of one condition, such as the temperature."""
    for effect in model.effects:
        by_law = not effect.by_levels and effect.element.parameters
        if effect.plane == "shift" and by_law and len(effect.needs) == 1:
            yield effect


def refused_laws(fit: Fit) -> Iterator[tuple[Effect, str]]:
    """Laws of a shift that are none of a material, with what they do to these data.

    Beyond its pole a law is without end; and none shifts neighbours apart that have moduli in
    common. Where the rig or the signals are in the model too the moduli are not those of the
    material, and only the pole is looked at.
    """
    data, model = fit.measurement, fit.model
    for effect in laws_of_shift(model):
        own = [i for i, name in enumerate(model.names) if name.startswith(f"{effect.name}.")]
        # One that was held is nobody's estimate.
        if len(own) != len(effect.element.parameters):
            continue
        log_a = effect.element.respond(fit.theta[own], data.points).value.real
        does = _beyond_its_pole(fit, effect, log_a)
        alone = all(each.layer == Layer.TEMPERATURE for each in model.effects)
        if not does and alone and not isinstance(model.material, Relaxation):
            does = _apart(fit, effect, log_a)
        if does:
            yield effect, does


def refused_in_words(fit: Fit) -> Iterator[str]:
    """A sentence for each law that is none of a material."""
    for effect, does in refused_laws(fit):
        yield f"{effect.name} is refused: it {does}; its constants are none of a material"


def _beyond_its_pole(fit: Fit, effect: Effect, log_a: Real) -> str:
    there = np.abs(log_a) >= (1.0 - ALIKE) * LARGEST_SHIFT
    if not np.any(there):
        return ""
    (column,) = effect.needs
    values = fit.measurement.conditions[column][there]
    unit = ""
    if column == "temperature":
        unit = " degC"
    return (
        f"is beyond its pole at {column} {values.min():.3g} to {values.max():.3g}{unit}, or shifts"
        f" by more than {LARGEST_SHIFT / DECADE:.2g} decades"
    )


def _apart(fit: Fit, effect: Effect, log_a: Real) -> str:
    data, (column,) = fit.measurement, effect.needs
    bound = Levels(column).bound_to(data.points)
    number = levels_of(column, data.points.need(column))
    shifts = level_means(number, log_a)
    log_b = np.zeros(len(number))
    for each in fit.model.effects:
        own = [i for i, name in enumerate(fit.model.names) if name.startswith(f"{each.name}.")]
        if each.plane == "log-complex" and len(own) == len(each.element.parameters):
            log_b += np.log(each.element.respond(fit.theta[own], data.points).value.real)
    # Without a fit of each level first: nearly all laws pass, whatever the scatter.
    if not allowed_shifts(data, bound, log_b, Alone.exact(len(shifts))).broken_by(shifts):
        return ""
    # Relative, whatever the fit was weighed by: its weights may be those of all points at once.
    own_errors = each_alone(data, number, relative_objective())
    return allowed_shifts(data, bound, log_b, own_errors).broken_by(shifts)


def scatter_between(own: Alone) -> Real:
    """Variance (m, m) of the difference of ln|K| of two levels by their scatter."""
    usual = 0.0
    if np.any(own.judged):
        usual = float(np.median(own.error[own.judged]))
    scatter = np.where(own.judged, own.error, usual)
    return np.asarray(np.add.outer(scatter**2, scatter**2), dtype=np.float64)


FURTHEST = LARGEST_SHIFT
"""Logarithm beyond which no factor lies: as far as any law shifts, and as far as is searched."""


@dataclass(frozen=True, eq=False)
class KnownFactors:
    """What is known of the factors of frequency.

    Attributes
    ----------
    reason : tuple of str, length m
        Why a factor is not determined; empty where it is.
    low, high : ndarray, shape (m,)
        Ends of the 95 % intervals of ln a; those of the search where the data give none.
    joined : ndarray of bool, shape (m,)
        Levels whose moduli overlap with those of the reference, directly or through others.
    """

    reason: tuple[str, ...]
    low: Real
    high: Real
    joined: NDArray[np.bool_]

    @property
    def determined(self) -> NDArray[np.bool_]:
        """Levels (m,) whose factor the data tell."""
        return ~np.array([bool(reason) for reason in self.reason])

    @property
    def placed(self) -> NDArray[np.bool_]:
        """Levels (m,) that the data place beside the others, however widely.

        Their intervals weigh them.
        """
        return np.array([reason in {"", "wide", "too few points"} for reason in self.reason])


def ends_of_factors(known: Uncertainty) -> Iterator[tuple[list[int], tuple[Real, Real]]]:
    """Numbers of the free factors in theta, and the ends of their intervals.

    Those of a master curve, whatever command asks.
    """
    fit = known.fit
    # What specimens differ by, their own scatter says.
    if fit.dof <= 0 or known.specimens is not None:
        return
    for column in columns_of_factors(fit.model):
        rows = FactorRows.of(fit, column)
        factors = replace(factors_of(rows), quantile=student(known.level, fit.dof))
        of_a = interval_of(factors.log_a, factors.reach_a)
        of_b = interval_of(factors.log_b, factors.reach_b)
        if len(rows.elements) == len(fit.model.effects) and is_material(fit.model):
            # Relative, whatever the fit was weighed by: its weights may be those of all points.
            own = each_alone(fit.measurement, rows.number, relative_objective())
            found = known_factors(rows, factors, factors, own)
            of_a = found.low, found.high
        start = 0
        for element in rows.elements:
            places = list(rows.own[start : start + len(element.free)])
            low, high = of_b
            if element.logarithmic:
                low, high = of_a
            yield places, (np.exp(low[list(element.free)]), np.exp(high[list(element.free)]))
            start += len(element.free)


def known_factors(rows: FactorRows, fitted: Factors, factors: Factors, own: Alone) -> KnownFactors:
    """Which factors are determined.

    Parameters
    ----------
    rows : FactorRows
        The fitted material with its factors.
    fitted, factors : Factors
        As they were searched, and referred to the level that was asked for.
    own : Alone
        Each level by itself.
    """
    at = factors.reference
    others = np.arange(len(factors)) != at
    joined = reached_from(at, overlaps(rows, own))
    # Both: flat sweeps are laid over the others wherever the search ended.
    connected = joined & reached_from(at, meeting(*ranges(rows.number, rows.reduced[1])))
    # The spectrum follows the noise of a flat sweep, by which its place would seem to be known.
    # What overlaps with nothing could be shifted, flat or not, if there were anything to be laid
    # upon.
    flat = flat_levels(rows) & joined & others
    # A factor at the end of the search is where this ended, whatever its interval.
    ended = np.abs(fitted.log_a) >= (1.0 - ALIKE) * FURTHEST
    wide = factors.reach_a >= DECADE
    few = wide & (_frequencies(rows) < FEW)
    reasons = np.full(len(factors), "", dtype=object)
    # The gravest last, as it stands above the others.
    whys = (wide, few, ended, ~connected, flat)
    for which, why in zip(
        whys,
        ("wide", "too few points", "at the end of the search", "no overlap", "flat"),
        strict=True,
    ):
        reasons[which & others] = why
    low, high = _ends(rows, factors, connected, flat | (ended & connected))
    return KnownFactors(tuple(reasons.tolist()), low, high, joined)


def overlaps(rows: FactorRows, own: Alone) -> NDArray[np.bool_]:
    """Which levels (m, m) share moduli, within scatter and what is expected of vertical factors.

    |K| of a passive material rises with the frequency (K is a complete Bernstein function, whose
    logarithm has a real part that rises along the imaginary axis; Schilling, Song and Vondracek
    2012, theorem 6.17). So sweeps share reduced frequencies only where they share moduli, wherever
    they are shifted.
    """
    low, high = ranges(rows.number, np.log(rows.fit.measurement.magnitude))
    variance = scatter_between(own)
    if len(rows.elements) > 1:
        variance = variance + spread_between(rows.elements[-1]) ** 2
    return meeting(low, high, DEVIATIONS * np.sqrt(variance))


def _frequencies(rows: FactorRows) -> NDArray[np.int64]:
    """Distinct frequencies (m,) of each level."""
    omega = rows.fit.measurement.omega
    return np.array([len(np.unique(omega[rows.number == i])) for i in range(rows.number.max() + 1)])


def _ends(
    rows: FactorRows, factors: Factors, connected: NDArray[np.bool_], open_: NDArray[np.bool_]
) -> tuple[Real, Real]:
    """Ends (m,) of the intervals of ln a.

    Of a sweep that does not overlap it is known on which side it lies, and that it is no nearer
    than it would overlap: so far its interval goes, and on the other side there is no end.
    """
    log_a, reach = factors.log_a, np.minimum(factors.reach_a, 2.0 * FURTHEST)
    low, high = interval_of(log_a, reach)
    first, last = ranges(rows.number, rows.reduced[1])
    top = int(np.argmax(np.where(connected, last, -np.inf)))
    bottom = int(np.argmin(np.where(connected, first, np.inf)))
    for i in np.flatnonzero(~connected).tolist():
        low[i], high[i] = -FURTHEST, FURTHEST
        if first[i] > last[top]:
            low[i] = max(log_a[i] - _gaps(first, last, last[top], first[i]) - reach[top], -FURTHEST)
        elif last[i] < first[bottom]:
            high[i] = min(
                log_a[i] + _gaps(first, last, last[i], first[bottom]) + reach[bottom], FURTHEST
            )
    others = np.arange(len(factors)) != factors.reference
    low[open_ & others], high[open_ & others] = -FURTHEST, FURTHEST
    return low, high


def interval_of(log_factor: Real, reach: Real) -> tuple[Real, Real]:
    """Ends of the interval of a logarithm."""
    # What the data leave open ends where no factor is searched: beyond, it would be no number.
    low = np.maximum(log_factor - reach, np.minimum(log_factor, -FURTHEST))
    high = np.minimum(log_factor + reach, np.maximum(log_factor, FURTHEST))
    return low, high


def _gaps(first: Real, last: Real, start: float, stop: float) -> float:
    """How much of the way from `start` to `stop` no sweep covers."""
    bare, reached = 0.0, start
    for i in np.argsort(first).tolist():
        begin = min(float(first[i]), stop)
        bare += max(begin - reached, 0.0)
        reached = max(reached, min(float(last[i]), stop))
    return bare


def flat_levels(rows: FactorRows) -> NDArray[np.bool_]:
    """Levels (m,) whose storage and loss neither rise nor fall with frequency beyond scatter."""
    data = rows.fit.measurement
    flat = np.zeros(len(rows.elements[0].values), dtype=np.bool_)
    for level in range(len(flat)):
        here = rows.number == level
        x = np.log(data.omega[here])
        if len(x) <= FEWEST or np.ptp(x) == 0.0:
            continue
        shares = data.stiffness[here] / np.median(data.magnitude[here])
        flat[level] = all(_is_level(x, part) for part in (shares.real, shares.imag))
    return flat


def _is_level(x: Real, values: Real) -> bool:
    """Whether values (n,) do not follow x (n,) beyond their scatter, and cannot do so by much."""
    away = x - x.mean()
    slope = abs(float(away @ values / (away @ away)))
    left = values - values.mean() - away * (away @ values / (away @ away))
    freedom = len(x) - 2
    sd = float(np.sqrt(left @ left / freedom / (away @ away)))
    # Few points or a short sweep show no slope either, and leave room for a large one.
    room = slope + student(INTERVAL, freedom) * sd
    return (
        slope <= student(SUPERPOSITION.seen, freedom) * sd + ALIKE
        and DECADE * room < SUPERPOSITION.flat
    )
