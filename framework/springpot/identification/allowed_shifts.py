"""How far the data allow neighbouring levels to be shifted, and the laws that shift them further.

No further than their sweeps can overlap.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from springpot.measurement.measurement import Measurement
from springpot.rheology.effect import Effect, Layer
from springpot.rheology.elements import Relaxation
from springpot.rheology.levels import Levels, level_text, levels_of
from springpot.rheology.model import Model
from springpot.rheology.points import LARGEST_SHIFT, Real

from ..numerics import ALIKE, DECADE
from .levels_alone import Alone, each_alone, meeting, ranges
from .native import Fit
from .problem import relative_objective

ROOM = 2.0
"""Standard deviations within which moduli meet."""


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
    # Beyond their scatter: where two ends only just meet, nobody knows that they do.
    surely = meeting(low, high, -ROOM * np.sqrt(scatter_between(own)))
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
    shifts = np.bincount(number, log_a) / np.bincount(number)
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
