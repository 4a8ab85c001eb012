"""Each temperature by itself: whether it is a linear passive material at all, and whether a shift makes them one.

Neither question needs a model: a free spectrum at each level shows which levels are none of a material, and one
spectrum with free factors at each level shows whether any law of shifts could join the others.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import f_sf
from springpot.measurement import Measurement
from springpot.rheology import Effect, Real

from .material import any_material
from .policy import LEVELS
from .refit import Refit, refit
from .where import with_unit
from .words import percent

Rows: TypeAlias = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Level:
    """One level of a condition, followed by a free spectrum of its own.

    Attributes
    ----------
    value : float
        Of the condition, in the unit of its column.
    rows : ndarray of int
        Its rows.
    fitted : Refit
        Any linear passive material at these rows alone.
    """

    value: float
    rows: Rows
    fitted: Refit

    @property
    def error(self) -> float:
        """Its error, relative to |K|."""
        return self.fitted.relative_rms

    @property
    def variance(self) -> float:
        """Whitened square of its error for each degree of freedom."""
        return self.fitted.rss / max(self.fitted.fit.dof, 1)


def notes_on_levels(base: Refit, library: Sequence[Effect]) -> Iterator[str]:
    """Sentences on levels that are no linear material by themselves, and on shifts that cannot join the others.

    Parameters
    ----------
    base : Refit
        A fit that leaves structure; its data and their noise are used, its model is not.
    library : sequence of Effect
        Those with a factor for each level are what any law of shifts could do at best.
    """
    measurement = base.fit.measurement
    free = [effect for effect in library if effect.by_levels]
    for name in sorted({name for effect in free for name in effect.needs} & set(measurement.conditions)):
        levels = _each_alone(base, name)
        if len(levels) < LEVELS.fewest:
            continue
        strange = _no_material(levels)
        if strange:
            yield _strange_in_words(measurement, name, levels, strange)
        sound = [level for level in levels if level not in strange]
        joining = [effect for effect in free if effect.needs == {name}]
        if len(sound) >= LEVELS.fewest:
            yield from _joined(base, name, sound, joining)


def _each_alone(base: Refit, name: str) -> list[Level]:
    """Every level of a condition that has enough points, with its own material."""
    measurement = base.fit.measurement
    number = measurement.levels(name)
    found = []
    for each in range(int(number.max()) + 1):
        inside = number == each
        if np.sum(inside) < LEVELS.points:
            continue
        fitted = refit(any_material(), base.data.without(~inside), base.noise.of(inside))
        value = float(np.mean(measurement.conditions[name][inside]))
        found.append(Level(value, np.flatnonzero(inside), fitted))
    return found


def _no_material(levels: Sequence[Level]) -> list[Level]:
    """Levels at which a free spectrum fails far more than at the others, beyond what scatter makes of such few."""
    middle = float(np.median([level.error for level in levels]))
    strange = []
    for level in levels:
        others = [other for other in levels if other is not level]
        variance = float(np.median([other.variance for other in others]))
        dof = sum(other.fitted.fit.dof for other in others)
        chance = float(f_sf(level.variance / max(variance, 1e-300), max(level.fitted.fit.dof, 1), dof))
        if level.error > LEVELS.stands_out * middle and chance < LEVELS.alarm / len(levels):
            strange.append(level)
    return strange


def _joined(base: Refit, name: str, levels: Sequence[Level], free: Sequence[Effect]) -> Iterator[str]:
    """A sentence where each level is a material, and no factors of time and modulus make them one."""
    inside = np.zeros(len(base.fit.measurement), dtype=bool)
    inside[np.concatenate([level.rows for level in levels])] = True
    model = replace(any_material(), effects=tuple(free))
    together = refit(model, base.data.without(~inside), base.noise.of(inside))
    apart = sum(level.fitted.rss for level in levels)
    spare = sum(level.fitted.fit.dof for level in levels)
    spent = max(together.fit.dof - spare, 1)
    ratio = (together.rss - apart) / spent / (apart / max(spare, 1))
    if ratio <= 1.0 or float(f_sf(ratio, spent, max(spare, 1))) > LEVELS.alarm:
        return
    if together.relative_rms < LEVELS.worse * _rms(levels):
        return
    yield (
        f"no shift of times and moduli lays the {name}s over one another: each by itself is a linear material to "
        f"{percent(_rms(levels))}, all together with factors of their own to {percent(together.relative_rms)}; the "
        f"material is not thermorheologically simple, or something else changed between the {name}s"
    )


def _rms(levels: Sequence[Level]) -> float:
    """Relative error of all levels, each followed by its own material."""
    squares: Real = np.array([level.error**2 for level in levels])
    return float(np.sqrt(np.average(squares, weights=[len(level.rows) for level in levels])))


def _strange_in_words(measurement: Measurement, name: str, levels: Sequence[Level], strange: Sequence[Level]) -> str:
    places = " and ".join(with_unit(measurement, name, level.value) for level in strange[: LEVELS.told])
    if len(strange) > LEVELS.told:
        places = f"{places} and {len(strange) - LEVELS.told} more"
    errors = " and ".join(percent(level.error) for level in strange[: LEVELS.told])
    usual = percent(float(np.median([level.error for level in levels])))
    return (
        f"no linear passive material behaves as at {places}: a free spectrum at that {name} alone is {errors} off, "
        f"elsewhere {usual}; the instrument, the amplitude or a change of the specimen, not a shift"
    )
