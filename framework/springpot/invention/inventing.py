"""The invention from end to end: noise and outliers, search, evidence, and what is told of it."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from springpot.diagnosis.examination import prepared
from springpot.diagnosis.experiment import next_experiment
from springpot.diagnosis.grown import Grown, Search
from springpot.diagnosis.result import NextExperiment, Progress, silent
from springpot.errors import OptionError
from springpot.identification.held_material import parameters_of
from springpot.identification.material import is_material
from springpot.identification.space import require_conditions
from springpot.identification.value import Value
from springpot.measurement.independence import (
    HELD_ALIKE,
    SMOOTH_DEGREE,
    at_one_frequency,
    held_frequency_numbers,
    moved_along,
    telling,
)
from springpot.measurement.measurement import CONDITIONS, Measurement, numbers_of_levels
from springpot.misfit.error import percent, times
from springpot.misfit.material import error_of, material_floor
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.rheology.written import FACTORS, Written, causal, passive, told
from springpot.thresholds import INVENTION, VERDICT
from springpot.writing import NAMED, counted

from .result import (
    FoundLaw,
    Invention,
    Verdict,
    Weighed,
    candidates,
    formula_of,
    known_alike,
    rivals_of,
    text_of,
    verdict_of,
    weighed,
)
from .search import search_laws

_COLUMN = re.compile(r"[A-Za-z][A-Za-z0-9]*(?:_[A-Za-z0-9]+)*")


def conditions_of(measurement: Measurement) -> list[str]:
    """Columns that were varied by themselves and whose name may stand in a formula.

    Examples
    --------
    >>> import springpot
    >>> from springpot.invention.inventing import conditions_of
    >>> data = springpot.read("nist-srm2491")
    >>> sorted(data.conditions), conditions_of(data)
    (['nist_loss', 'nist_storage', 'temperature'], ['temperature'])
    """
    told = telling(measurement)
    return [
        name
        for name in varied(measurement)
        if name in told and (name in CONDITIONS or not repeats(measurement, name))
    ]


def varied(measurement: Measurement) -> list[str]:
    """Columns that were varied at all and whose name may stand in a formula."""
    columns = measurement.conditions
    return [name for name in sorted(columns) if _COLUMN.fullmatch(name) and np.ptp(columns[name])]


def repeats(measurement: Measurement, name: str) -> bool:
    """Whether a column tells again what others do: a force, a velocity, a nominal frequency.

    What follows from frequency and amplitude does. What follows from the stiffness as well may be
    its cause, if it was held at several frequencies; else it was measured with it.

    Parameters
    ----------
    measurement : Measurement
        The data.
    name : str
        A column beside amplitude and temperature.
    """
    column = _lengths(measurement.conditions[name])
    known = [*_of_frequency(measurement)]
    known += [
        _lengths(measurement.conditions[n]) for n in CONDITIONS if n in measurement.conditions
    ]
    if _follows(column, known):
        return True
    k = measurement.stiffness
    measured = [_lengths(part) for part in (k.real, k.imag, np.abs(k))]
    measured += [*_of_runs(measurement)]
    return not _was_held(measurement, column) and _follows(column, [*known, *measured])


def _lengths(values: Real) -> Real:
    """Logarithms, in which products are sums; of what has no one sign, shares of the largest."""
    if np.all(values > 0.0) or np.all(values < 0.0):
        return np.asarray(np.log(np.abs(values)))
    return values / (np.max(np.abs(values)) or 1.0)


def _of_frequency(measurement: Measurement) -> Real:
    """Whatever goes with the frequency (m, n): a step at each, or of many a smooth course."""
    number = held_frequency_numbers(measurement.omega)
    if 3 * (int(number.max()) + 1) <= len(number):
        return np.asarray(number == np.unique(number)[:, None], dtype=np.float64)
    log_omega = np.log(measurement.omega)
    scaled = 2.0 * (log_omega - log_omega.min()) / (float(np.ptp(log_omega)) or 1.0) - 1.0
    return np.asarray(np.polynomial.legendre.legvander(scaled, SMOOTH_DEGREE).T, dtype=np.float64)


def _of_runs(measurement: Measurement) -> Real:
    """A step (m, n) at each run or specimen: each has a geometry of its own."""
    shapes = [np.zeros((0, len(measurement)))]
    for label in measurement.labels.values():
        names = np.unique(label)
        if 3 * len(names) <= len(label):
            shapes.append(np.asarray(label == names[1:, None], dtype=np.float64))
    return np.concatenate(shapes)


def _follows(column: Real, known: list[Real]) -> bool:
    """Whether nearly all of its spread is a sum of others; of too few rows anything would be."""
    basis = np.stack(known, axis=1)
    free = len(column) - basis.shape[1]
    if free < basis.shape[1]:
        return False
    left = column - basis @ np.linalg.lstsq(basis, column, rcond=None)[0]
    spread = np.sqrt(np.sum(left**2) / free)
    return bool(spread < INVENTION.repeated * np.std(column))


def _was_held(measurement: Measurement, column: Real) -> bool:
    """Whether most rows have their value in common with one at another frequency."""
    level = numbers_of_levels(column, HELD_ALIKE)
    frequency = held_frequency_numbers(measurement.omega)
    met = [len(np.unique(frequency[level == number])) for number in range(int(level.max()) + 1)]
    return bool(np.mean(np.array(met)[level] > 1) > 0.5)


def invent(
    measurement: Measurement,
    model: Model,
    library: Sequence[Effect],
    rng: np.random.Generator,
    along: Sequence[str] | None = None,
    progress: Progress = silent,
) -> Invention:
    """Find the law that is missing from a model of measured data.

    Parameters
    ----------
    measurement : Measurement
        The data.
    model : Model
        The model that the law is sought beside.
    library : sequence of Effect
        Effects with a name, of which a law may be a special case.
    rng : numpy.random.Generator
        For simulated noise.
    along : sequence of str, optional
        Columns that a law may go with; by default all that were varied by themselves.
    progress : callable
        Told in a few words what is being done.

    Raises
    ------
    DataError
        If there are too few data to judge anything.
    ModelError
        If the data lack a column that the model needs.
    OptionError
        If a law cannot go with a column that was asked for.
    """
    require_conditions(model, measurement)
    data = prepared(measurement, model)
    conditions = _conditions(data, along)
    laws = candidates(data, conditions)
    if at_one_frequency(data):
        # There a law of the clock is no law: through the spectrum it can be any curve.
        laws = [each for each in laws if each.plane != "shift"]
    progress(f"trying {len(laws)} laws beside {model.name}")
    search = search_laws(data, model, laws, rng)
    progress("weighing what was found")
    found = weighed(search)
    verdict = verdict_of(search, found)
    error = error_of(search.base, material_floor(search.base, rng))
    rivals = rivals_of(found)
    # Where none is the answer the nearest is told alone; the others stand in its class.
    shown = rivals[:1] if verdict == "none" else rivals[: INVENTION.told]
    rows = [_told(search, each, rivals, library, verdict) for each in shown]
    return Invention(
        data=measurement.name,
        model=model,
        verdict=verdict,
        says=_says(search, verdict, rows),
        error=error,
        laws=tuple(rows),
        next_experiment=_next(verdict, rivals),
        notes=tuple(_notes(data, model, conditions)),
        tried=len(laws),
        searched=search,
        ranked=tuple(rivals),
    )


def _conditions(measurement: Measurement, along: Sequence[str] | None) -> list[str]:
    """The columns that a law may go with."""
    if along is None:
        return conditions_of(measurement)
    known = varied(measurement)
    for name in along:
        if name not in known:
            words = f"there are {', '.join(known)}" if known else "there is none"
            raise OptionError(
                f"no law can go with '{name}' of {measurement.name}: a law goes with a column that"
                f" varies and whose name may stand in a formula; {words}"
            )
    return [name for name in known if name in along]


def _told(
    search: Search,
    each: Weighed,
    rivals: Sequence[Weighed],
    library: Sequence[Effect],
    verdict: Verdict,
) -> FoundLaw:
    """What is told of a law; named effects are held against the likeliest alone.

    What is only the nearest is no answer, and its intervals are those by the slopes.
    """
    element = each.effect.element
    assert isinstance(element, Written)
    alike: list[Grown] = []
    if each is rivals[0] and verdict != "none":
        alike = known_alike(search, each, library)
    by_profile = verdict != "none" and each.probability > VERDICT.profiled
    causes = "amplitude" in element.needs or causal(element)
    return FoundLaw(
        text=text_of(each.effect),
        plane=text_of(each.effect).partition(":")[0],
        probability=each.probability,
        alike=tuple(text_of(law.effect) for law in rivals),
        parameters=_parameters(each.grown, by_profile),
        error_after=each.grown.refit.error,
        causal=causes,
        passive=None if element.plane in FACTORS else passive(element),
        like=tuple(grown.names[0] for grown in alike),
        says="; ".join([told(element), *map(_as_known, alike)]),
    )


def _parameters(grown: Grown, by_profile: bool) -> dict[str, Value]:
    mine = f"{grown.effects[0].name}."
    values = parameters_of(grown.refit.known, by_profile)
    # An order stands in the unit of what goes with it, by the name of the law and not of its try.
    return {
        name.removeprefix(mine): replace(value, unit=value.unit.replace(mine, ""))
        for name, value in values.items()
        if name.startswith(mine)
    }


def _as_known(grown: Grown) -> str:
    """A named effect in a law's place, with those of its parameters that the data tell."""
    values = _parameters(grown, False).items()
    own = ", ".join(f"{name} = {value}" for name, value in values if value.determined)
    return f"{grown.names[0]} has the same curve here" + f", with {own}" * bool(own)


def _says(search: Search, verdict: Verdict, rows: Sequence[FoundLaw]) -> str:
    before = f"the error is {percent(search.base.error)}"
    before += f", {times(search.base.error / search.base.floor)} the noise floor"
    if search.alarm >= INVENTION.alarm:
        return f"{before}: noise alone goes as far, and these data show no law that is missing"
    if verdict == "none":
        nearest = ""
        if rows:
            nearest = f"; nearest is {rows[0].text}, which leaves {percent(rows[0].error_after)}"
        return f"{before}: something is missing, and no law of the grammar follows it{nearest}"
    after = f"{percent(rows[0].error_after)} with {rows[0].text}"
    if verdict == "law":
        return f"{before}, and {after}: no other law of the grammar does as well"
    others = counted(len(rows[0].alike) - 1, "other law")
    return f"{before}, and {after}, which these data cannot tell from {others}"


def _next(verdict: Verdict, laws: Sequence[Weighed]) -> NextExperiment | None:
    """What would tell the likeliest law from the next one that it can be told from."""
    if verdict != "class":
        return None
    asked: dict[str, Weighed] = {}
    for each in laws[: 1 + NAMED]:
        # Told by their formulas: of one in two planes the likelier.
        asked.setdefault(formula_of(each.effect), each)
    fits = {formula: each.grown.refit for formula, each in asked.items()}
    chances = {formula: each.probability for formula, each in asked.items()}
    first, *others = asked
    # A limit of the first, such as a saturation far outside, nothing tells from it.
    return next_experiment(fits[first], [(first, other) for other in others], fits, chances)


def _notes(measurement: Measurement, model: Model, conditions: Sequence[str]) -> Iterator[str]:
    """What no search could tell of these data."""
    for name in sorted(moved_along(measurement)):
        if name in conditions:
            yield f"the {name} moved with the rest: what goes with it here may go with that as well"
        else:
            yield f"the {name} was not varied by itself: --along {name} tries laws of it even so"
    if not conditions:
        if is_material(model):
            yield (
                "neither amplitude, temperature nor another column was varied: a law of the"
                " frequency can be told only where it does what no linear passive material does"
            )
        else:
            yield (
                "neither amplitude, temperature nor another column was varied: a law of the"
                f" frequency is found as what is missing from {model.name}, and another model of"
                " the material would leave another one"
            )
