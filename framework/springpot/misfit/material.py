"""The third line: the least error of any linear passive material beside the same effects.

Below it lies what a spring, dashpot, springpot or mode may mend; above it what no material does at
one temperature and amplitude: a mass, the instrument, temperature, amplitude, history. A free
spectrum at each temperature alone shows which of them are none of a material, and one with free
factors at each whether any shift could join the others. A material for each amplitude beside one
for all tells, without a model, whether the amplitude matters and how.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import f_sf
from springpot.identification.convex import least_error
from springpot.identification.material import is_material
from springpot.identification.native import FittedModel
from springpot.measurement.measurement import Measurement
from springpot.measurement.mixed_up import temperatures_differ
from springpot.rheology.effect import Effect
from springpot.rheology.elements import Continuum
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.thresholds import EVIDENCE, VERDICT
from springpot.writing import NAMED, number

from ..numerics import BEYOND, COARSE, FEWEST, SMALLEST, rms, rows_of_levels
from .error import Error, percent, times, with_unit
from .refit import Refit, refit
from .residual_tests import Battery, battery
from .where import where

POINTS_OF_EACH = 6
"""Points of a level from which a free spectrum can fail at it."""
FOLLOWED = 0.1
"""Share of an error to which a spectrum follows a model that is a linear passive material itself.
"""
NAME = "material"
F = TypeVar("F", bound=FittedModel)
L = TypeVar("L", bound="Floor")


class Floor(Protocol):
    """The least error of any material, of sweeps or of tests in time."""

    def beside(self, fits: Sequence[Any]) -> Self:
        """The same, lowered by fits with the same effects that any material comes near to."""


@dataclass(frozen=True, eq=False)
class MaterialFloor:
    """Any linear passive material with the effects of a model.

    Attributes
    ----------
    refit : Refit
        Its fit, in units of the same noise.
    rest : Battery
        The test on its residual.
    relative_rms : float
        The least error, relative to |K|: not that of the fit, which weighs the points by their
        noise.
    judged : bool
        Whether it is the judged model itself.
    """

    refit: Refit
    rest: Battery
    relative_rms: float
    judged: bool = False

    def beside(self, fits: Iterable[Refit]) -> MaterialFloor:
        """The same, lowered by fits with the same effects that any material comes near to."""
        lowest = self.relative_rms
        for found in fits:
            if found.least_error < lowest and found.error < lowest:
                best = found.identified
                lowest = min(
                    lowest, lowest_error(best.model, found.data.raw, best.theta, found.error)
                )
        return replace(self, relative_rms=lowest)

    @property
    def chance(self) -> float:
        """That noise alone leaves a residual like this."""
        return self.rest.p_value


def any_material() -> Model:
    """The model of any linear passive material, which is judged where no model is named."""
    return Model(NAME, Continuum(), "any linear passive material")


def material_floor(base: Refit, rng: np.random.Generator) -> MaterialFloor:
    """The least error of any material in the place of the model's own, its effects fitted anew.

    Parameters
    ----------
    base : Refit
        A fitted model.
    rng : numpy.random.Generator
        For simulated noise.
    """
    found = base
    if not is_material(base.model):
        free = replace(any_material(), effects=base.model.effects)
        # Its effects only: a spectrum is found for given effects by a convex problem, which needs
        # no start.
        found = refit(free, base.data, base.noise, [_own(base.model, base.theta)])
    lowest = lowest_error(found.model, base.data.raw, found.theta, found.relative_rms)
    if base.model.own:
        lowest = min(lowest, lowest_error(base.model, base.data.raw, base.theta, base.relative_rms))
    floor = MaterialFloor(found, battery(found.frame(), rng), lowest, is_material(base.model))
    return floor.beside([base])


def effects_of(model: Model) -> tuple[str, ...]:
    """Names of the effects of a model."""
    return tuple(effect.name for effect in model.effects)


def material_floors(
    fits: Iterable[F],
    floor_of: Callable[[Sequence[F]], L],
    known: Mapping[tuple[str, ...], L] | None = None,
) -> dict[tuple[str, ...], L]:
    """The material floor for each set of effects.

    Parameters
    ----------
    fits : iterable of FittedModel
        Models with any effects.
    floor_of : callable
        Gives that of models with the same effects.
    known : mapping, optional
        Those that need not be sought.
    """
    alike: dict[tuple[str, ...], list[F]] = {}
    for found in fits:
        alike.setdefault(effects_of(found.model), []).append(found)
    floors = dict(known or {})
    for effects, group in alike.items():
        floors[effects] = (floors.get(effects) or floor_of(group)).beside(group)
    return floors


def lowest_error(model: Model, measurement: Measurement, theta: Real, error: float) -> float:
    """The least error of any material with the effects of a model, sought from a fit of it.

    Parameters
    ----------
    model : Model
        Any, with its effects.
    measurement : Measurement
        The rows over which its error was taken.
    theta : ndarray, shape (p,)
        Its parameters.
    error : float
        What it leaves of |K|.
    """
    if model.own:
        return _of_levels(model, measurement, theta, error)
    free = replace(any_material(), effects=model.effects)
    lowest = least_error(free, measurement, [_own(model, theta)])
    # Lines stand apart, and a search beside effects may stop short; a model that is a material
    # itself is a bound.
    rate = float(measurement.omega.min()), float(measurement.omega.max())
    if lowest > error and is_of_material(model, theta, rate, error):
        return error
    return lowest


def _of_levels(model: Model, measurement: Measurement, theta: Real, error: float) -> float:
    """The least error where each level may have a material of its own."""
    one, places, square = model.of_any_level, model.places, 0.0
    levels = rows_of_levels(model.levels(measurement.points), len(places))
    for own, rows in zip(theta[places], levels, strict=True):
        if not len(rows):
            continue
        part = measurement.subset(rows)
        missed = one.stiffness(own, part.points) / part.stiffness - 1.0
        alone = rms(np.abs(missed))
        square += len(part) * lowest_error(one, part, own, alone) ** 2
    return min(float(np.sqrt(square / len(measurement))), error)


def is_of_material(model: Model, theta: Real, rate: tuple[float, float], error: float) -> bool:
    """Whether the material of a model is a linear passive one, as closely as an error needs it.

    Parameters
    ----------
    model : Model
        The model.
    theta : ndarray, shape (p,)
        Its parameters.
    rate : tuple of float
        Lowest and highest angular frequency that was measured.
    error : float
        Relative error of the model.
    """
    if model.material.needs:
        return False
    omega = np.geomspace(rate[0] / BEYOND, rate[1] * BEYOND, COARSE)
    alone = replace(model, effects=())
    stiffness = alone.stiffness(theta[: len(alone.parameters)], omega)
    # Beside an effect that takes all of the data nothing is left of the material.
    if not np.any(stiffness):
        return True
    computed = Measurement(omega, stiffness)
    return (
        least_error(any_material(), computed, [np.zeros(0)]) < FOLLOWED * error + VERDICT.arithmetic
    )


def _own(model: Model, theta: Real) -> Real:
    """Parameters of the effects of a model."""
    return theta[len(model.material.parameters) :]


def error_of(base: Refit, floor: MaterialFloor) -> Error:
    """The three lines: a model's error, the noise floor, the material floor."""
    noise = base.noise
    return Error(
        base.error,
        base.floor,
        noise.source,
        noise.doubt,
        floor.relative_rms,
        floor.chance,
        noise_memory=noise.memory or None,
    )


def split_in_words(base: Refit, floor: MaterialFloor) -> str:
    """What the third line says of a model that fails; nothing where it is the material itself.

    Parameters
    ----------
    base : Refit
        The model.
    floor : MaterialFloor
        What any material reaches.
    """
    # Of parameters that levels have for themselves one material for all is no measure.
    if is_material(base.model) or base.model.own:
        return ""
    spare = base.fit.dof
    misfit, left = max(base.rss - spare, 0.0), max(floor.refit.rss - floor.refit.fit.dof, 0.0)
    could = f"a material could be at {percent(floor.relative_rms)}"
    beside = f" ({times(floor.relative_rms / floor.refit.floor)} the noise floor)"
    something_left = floor.chance < VERDICT.structure_alarm
    # Where the noise was estimated from this very fit, both are zero, and no material comes nearer.
    if left > VERDICT.mostly * misfit or (misfit == 0.0 and something_left):
        would = f"would be {percent(floor.relative_rms)} off: what is missing is no part of"
        if temperatures_differ(base.fit.measurement):
            law = "that goes with temperature as the model does"
            return f"any linear material {law} {would} such a one"
        return f"any linear material {would} the material"
    if not something_left:
        return (
            f"{could}: a spring, dashpot, springpot or mode is missing,"
            " or an effect that looks like one"
        )
    # A material bends to what is none: how much it follows does not say how much of it is missing.
    return f"{could}{beside}: what is missing is, at least in part, no part of the material"


def beyond_any_material(floor: MaterialFloor) -> Iterator[str]:
    """A sentence on where no material behaves as the data do.

    None where one does, or where it is what is judged.

    Parameters
    ----------
    floor : MaterialFloor
        What any material reaches.
    """
    # Where a material itself is judged, the places at which it fails are told already.
    if floor.judged or floor.chance >= VERDICT.structure_alarm:
        return
    places = where(floor.refit.frame())
    if places:
        yield f"no linear material follows: {places[0].says}"


@dataclass(frozen=True, eq=False)
class ConditionLevel:
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
    rows: NDArray[np.int64]
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
    """Sentences on levels that are no linear material, and on shifts that cannot join the others.

    Parameters
    ----------
    base : Refit
        A fit that leaves structure; its data and their noise are used, its model is not.
    library : sequence of Effect
        Those with a factor for each level are what any law of shifts could do at best.
    """
    measurement = base.fit.measurement
    # Conditions that some effect has free factors for: of the others no shift could be expected
    # anyway.
    free = [effect for effect in library if effect.by_levels]
    for name in sorted(
        {name for effect in free for name in effect.needs} & set(measurement.conditions)
    ):
        levels = each_alone(base, name)
        if len(levels) < EVIDENCE.fewest_levels:
            continue
        strange = levels_of_no_material(levels)
        if strange:
            yield strange_in_words(measurement, name, levels, strange)
        # A level that is no material by itself could be joined to nothing: the question is asked of
        # the others.
        sound = [level for level in levels if level not in strange]
        joining = [effect for effect in free if effect.needs == {name}]
        if len(sound) >= EVIDENCE.fewest_levels:
            yield from _joined(base, name, sound, joining)


def each_alone(base: Refit, name: str) -> list[ConditionLevel]:
    """Every level of a condition that has enough points, with its own material."""
    measurement = base.fit.measurement
    number = measurement.levels(name)
    found = []
    for each in range(int(number.max()) + 1):
        inside = number == each
        # A spectrum follows a few points whatever they are.
        if np.sum(inside) < POINTS_OF_EACH:
            continue
        # In the noise of the whole: from so few points no noise could be told from what a spectrum
        # follows.
        fitted = refit(any_material(), base.data.without(~inside), base.noise.of(inside))
        value = float(np.mean(measurement.conditions[name][inside]))
        found.append(ConditionLevel(value, np.flatnonzero(inside), fitted))
    return found


def fitted_together(
    base: Refit, levels: Sequence[ConditionLevel], effects: Sequence[Effect] = ()
) -> Refit:
    """One material, with these effects, fitted to all levels' rows in the noise of the whole."""
    inside = np.zeros(len(base.fit.measurement), dtype=bool)
    inside[np.concatenate([level.rows for level in levels])] = True
    model = replace(any_material(), effects=tuple(effects))
    return refit(model, base.data.without(~inside), base.noise.of(inside))


def needs_each(together: Refit, levels: Sequence[ConditionLevel]) -> bool:
    """Whether a material for each level explains more than chance by its freedom (Fisher's test).

    Parameters
    ----------
    together : Refit
        One material for all levels.
    levels : sequence of ConditionLevel
        Each with its own.
    """
    gain, spent, spare = _gain_of_each(together, levels)
    # Against the scatter about each level's own material, not the noise: that may have been
    # misjudged.
    apart = sum(level.fitted.rss for level in levels)
    ratio = gain / spent / max(apart / spare, SMALLEST)
    return ratio > 1.0 and float(f_sf(ratio, spent, spare)) < VERDICT.sentence_alarm


def _gain_of_each(together: Refit, levels: Sequence[ConditionLevel]) -> tuple[float, float, float]:
    """Squares that a material for each level explains, its further numbers, and those left."""
    apart = sum(level.fitted.rss for level in levels)
    spare = max(sum(level.fitted.fit.dof for level in levels), 1)
    return together.rss - apart, max(together.fit.dof - spare, 1), spare


def _follow_alike(base: Refit, together: Refit, levels: Sequence[ConditionLevel]) -> bool:
    """Whether a material for each level explains no more than noise lets it.

    Where none follows its level either, what all of them miss hides much that they differ by.
    """
    gain, spent, _ = _gain_of_each(together, levels)
    ratio = gain / spent
    return ratio <= 1.0 or float(f_sf(ratio, spent, base.noise.dof)) >= VERDICT.sentence_alarm


def levels_of_no_material(levels: Sequence[ConditionLevel]) -> list[ConditionLevel]:
    """Levels at which a free spectrum fails far more than at the others.

    Beyond what scatter makes of such few.
    """
    # The median, which one or two levels that fail do not raise.
    middle = float(np.median([level.error for level in levels]))
    strange = []
    for level in levels:
        # Without the level itself: one that fails badly must not raise what it is held against.
        others = [other for other in levels if other is not level]
        variance = float(np.median([other.variance for other in others]))
        dof = sum(other.fitted.fit.dof for other in others)
        ratio = level.variance / max(variance, SMALLEST)
        chance = float(f_sf(ratio, max(level.fitted.fit.dof, 1), dof))
        # Of any level it might have been said: the alarm is shared among them.
        if level.error > VERDICT.stands_out * middle and chance < VERDICT.sentence_alarm / len(
            levels
        ):
            strange.append(level)
    return strange


def _joined(
    base: Refit, name: str, levels: Sequence[ConditionLevel], free: Sequence[Effect]
) -> Iterator[str]:
    """A sentence where each level is a material, and no factors of time and modulus join them."""
    together = fitted_together(base, levels, free)
    if not needs_each(together, levels):
        return
    # With many points the slightest difference is sure; it must be large enough to matter too, as
    # `mastercurve` asks.
    if together.relative_rms <= VERDICT.agrees * error_of_each(levels):
        return
    yield (
        f"no shift of times and moduli lays the {name}s over one another: each by itself is a"
        f" linear material to {percent(error_of_each(levels))}, all together with factors of their"
        f" own to {percent(together.relative_rms)}; the material is not thermorheologically simple,"
        f" or something else changed between the {name}s"
    )


def error_of_each(levels: Sequence[ConditionLevel]) -> float:
    """Relative error of all levels, each followed by its own material."""
    # Weighted by points, so that it stands beside the error of one fit to all of them.
    squares: Real = np.array([level.error**2 for level in levels])
    return float(np.sqrt(np.average(squares, weights=[len(level.rows) for level in levels])))


def strange_in_words(
    measurement: Measurement,
    name: str,
    levels: Sequence[ConditionLevel],
    strange: Sequence[ConditionLevel],
) -> str:
    """A sentence on levels that are no material by themselves.

    With what they are off and what the others are.

    Parameters
    ----------
    measurement : Measurement
        The data.
    name : str
        Of the condition.
    levels, strange : sequence of ConditionLevel
        All, and those that stand out.
    """
    places = " and ".join(with_unit(measurement, name, level.value) for level in strange[:NAMED])
    if len(strange) > NAMED:
        places = f"{places} and {len(strange) - NAMED} more"
    errors = " and ".join(percent(level.error) for level in strange[:NAMED])
    usual = percent(float(np.median([level.error for level in levels])))
    causes = "the instrument, the amplitude or a change of the specimen, not a shift"
    if name == "amplitude":
        causes = "the instrument, a force that is no sinusoid there, or a change of the specimen"
    return (
        f"no linear passive material behaves as at {places}: a free spectrum at that {name} alone"
        f" is {errors} off, elsewhere {usual}; {causes}"
    )


STAYS = 0.05
"""Share of a loss factor by which it may differ over amplitudes and be one in two digits."""
TURNS = 0.1
"""Share of its range by which a course goes beyond both of its ends to be told as one that turns.
"""


def notes_on_amplitudes(base: Refit) -> Iterator[str]:
    """Sentences on what the amplitude does.

    None where it was not varied, or where temperatures differ as well.

    Parameters
    ----------
    base : Refit
        A fit that leaves structure; its data and their noise are used, its model is not.
    """
    measurement = base.fit.measurement
    # At several temperatures one material could not follow them at one amplitude either.
    if "amplitude" not in measurement.conditions or temperatures_differ(measurement):
        return
    levels = each_alone(base, "amplitude")
    if len(levels) < 2:
        return
    one, each = fitted_together(base, levels), error_of_each(levels)
    told_of, every = len(levels), int(measurement.levels("amplitude").max()) + 1
    which = f"all {every}" if told_of == every else f"{told_of} of {every}"
    beside = f"one material for {which} amplitudes is {percent(one.relative_rms)} off"
    if not needs_each(one, levels):
        # Of a displacement that falls along a sweep few values come again: what these do alike says
        # nothing of all the others.
        if told_of < every:
            return
        told = "no material follows each by itself either"
        if _follow_alike(base, one, levels):
            told = "the amplitude does not matter"
        yield f"{beside}, one for each {percent(each)}: {told}"
        return
    yield f"{beside}, one for each {percent(each)}: {_course(measurement, levels)}"
    strange = levels_of_no_material(levels)
    if len(levels) > 2 and strange:
        yield strange_in_words(measurement, "amplitude", levels, strange)


def _course(measurement: Measurement, levels: Sequence[ConditionLevel]) -> str:
    """How modulus and loss factor go with the amplitude, at frequencies that all levels share."""
    low = max(float(measurement.omega[level.rows].min()) for level in levels)
    high = min(float(measurement.omega[level.rows].max()) for level in levels)
    own = measurement.omega[levels[0].rows]
    omega = np.unique(own[(own >= low) & (own <= high)])
    if len(omega) < FEWEST:
        return "the amplitude matters"
    curves = [level.fitted.model.stiffness(level.fitted.theta, omega) for level in levels]
    places = [with_unit(measurement, "amplitude", level.value) for level in levels]
    # In logarithms: a modulus is compared by ratios, over frequencies at which it differs by
    # decades.
    sizes = np.array(
        [float(np.exp(np.mean(np.log(np.abs(curve / curves[0]))))) for curve in curves]
    )
    tangents = np.array([float(np.tan(np.mean(np.angle(curve)))) for curve in curves])
    change = "rises"
    if sizes[-1] < 1.0:
        change = "falls"
    size = (
        f"{measurement.units.magnitude} {change} by"
        f" {percent(abs(sizes[-1] - 1.0))}{_turn(sizes, places)}"
    )
    loss = (
        f"the loss factor goes from {number(tangents[0], 2)} to"
        f" {number(tangents[-1], 2)}{_turn(tangents, places)}"
    )
    if float(np.ptp(tangents)) < STAYS * float(np.max(tangents)):
        loss = f"the loss factor stays at {number(float(np.mean(tangents)), 2)}"
    return f"from {places[0]} to {places[-1]} {size}, and {loss}"


def _turn(values: Real, places: Sequence[str]) -> str:
    """Where between its ends a course lies beyond both of them; empty where it goes one way."""
    inner = values[1:-1]
    ends = min(values[0], values[-1]), max(values[0], values[-1])
    beyond = np.maximum(inner - ends[1], ends[0] - inner)
    if not len(inner) or float(np.max(beyond)) < TURNS * float(np.ptp(values)):
        return ""
    at = int(np.argmax(beyond))
    extreme = "least"
    if inner[at] > ends[1]:
        extreme = "most"
    return f" ({extreme} at {places[1 + at]})"
