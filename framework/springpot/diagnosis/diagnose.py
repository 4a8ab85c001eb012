"""The diagnosis from end to end."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from springpot.identification import require_conditions
from springpot.measurement import Measurement
from springpot.rheology import Effect, Model, Real

from .candidates import CLEAR_EVIDENCE, candidates_of
from .experiment import next_experiment
from .notes import notes, unexplained_harmonics
from .outliers import Outlier
from .posterior import Posterior, classes, explanations, leading, posterior, rivals_of, seconds
from .result import Diagnosis, Error, NextExperiment, Verdict, Where
from .search import Search
from .settle import settled
from .where import periodic, where
from .words import times

LIBRARY_ALARM = 0.006
"""Chance of a false alarm granted to the scan of the library."""
STRUCTURE_ALARM = 0.005
"""Chance of a false alarm granted to the test for structure of any kind."""
REPEATS_ALARM = 0.002
"""Chance of a false alarm granted to the test of the repeats' scatter."""
BEYOND_DOUBT = 0.002
"""Chance of a false alarm below which something is missing even if the evidence names it weakly."""
REMAINDER = 0.005
"""Share of the misfit that named effects may leave and still be the verdict."""
MOST_POINTS = 1500
"""Points that are diagnosed at most; of more, evenly many of every sweep are taken."""
NOISY = 1.2
"""Error over noise floor below which only the pattern of a misfit tells it from noise."""
RIVAL = 1e-3
"""Chance, beside that of the leading effect, from which another is worth a measurement."""
NOTHING_LEFT = 10.0
"""Chi-square beyond the degrees of freedom that is no misfit worth a verdict."""
HARMONICS = "; the force holds harmonics that no model here makes"
FEWEST_SPARE = 4
"""Degrees of freedom below which data cannot be judged."""


@dataclass(frozen=True, eq=False)
class Case:
    """All that a diagnosis found, for those who go on from it.

    Attributes
    ----------
    found : Search
        Fits and scans.
    probabilities : Posterior
        Of every effect.
    diagnosis : Diagnosis
        The answer.
    """

    found: Search
    probabilities: Posterior
    diagnosis: Diagnosis


def diagnose(
    measurement: Measurement, model: Model, library: Sequence[Effect], rng: np.random.Generator
) -> Diagnosis:
    """Find what is missing from a model of measured data.

    Parameters
    ----------
    measurement : Measurement
        The data.
    model : Model
        The model to be judged.
    library : sequence of Effect
        Effects that may be missing.
    rng : numpy.random.Generator
        For simulated noise.

    Raises
    ------
    DataError
        If there are too few data to judge anything.
    ModelError
        If the data lack a column that the model needs.
    """
    return examine(measurement, model, library, rng).diagnosis


def examine(
    measurement: Measurement,
    model: Model,
    library: Sequence[Effect],
    rng: np.random.Generator,
    seeds: Sequence[Real] = (),
) -> Case:
    """As `diagnose`, with the fits and scans behind the answer, and with starts (p,) known from a smaller model."""
    require_conditions(model, measurement)
    measured, measurement = len(measurement), thinned(measurement)
    found, outliers = settled(measurement, model, library, rng, seeds)
    base = found.base
    probabilities = posterior(found)
    verdict = _verdict(found, probabilities)
    if outliers and verdict in ("adequate", "inconclusive"):
        verdict = "unexplained"
    if verdict == "effect-missing":
        probabilities = probabilities.without_unknown()
    groups = [] if verdict == "adequate" else classes(found, probabilities)
    second = seconds(found, probabilities) if verdict == "effect-missing" else []
    ranked = candidates_of(found, probabilities, groups, verdict)
    diagnosis = Diagnosis(
        data=measurement.name,
        model=model,
        error=Error(base.relative_rms, base.floor, base.noise.source, base.noise.doubt),
        verdict=verdict,
        says=_sentence(verdict, base.relative_rms / base.floor, groups, second, probabilities.imitators)
        + (HARMONICS if unexplained_harmonics(found, verdict) else ""),
        where=tuple(_places(found, outliers, verdict)),
        candidates=tuple(ranked),
        classes=tuple(tuple(group) for group in groups),
        next_experiment=_next_experiment(found, probabilities) if groups else None,
        notes=tuple(notes(found, probabilities, verdict, outliers, measured)),
        evidence={
            "p_library": found.scan.p_value,
            "p_structure": found.structure.p_value,
            "p_left": found.left.p_value,
            "p_repeats": found.repeats.p_value,
            "nothing": probabilities.nothing,
            "unknown": probabilities.unknown + probabilities.narrow,
        },
    )
    return Case(found, probabilities, diagnosis)


def thinned(measurement: Measurement) -> Measurement:
    """At most `MOST_POINTS` rows, evenly from the whole measurement in the order in which it was made."""
    if len(measurement) <= MOST_POINTS:
        return measurement
    return measurement.subset(np.linspace(0, len(measurement) - 1, MOST_POINTS).round().astype(np.int64))


def _places(found: Search, outliers: Sequence[Outlier], verdict: Verdict) -> Iterator[Where]:
    """Single points first, then bands, then what only a period shows."""
    yield from (outlier.place for outlier in outliers)
    bands = where(found.frame)
    yield from bands
    if not bands and verdict == "unexplained" and found.structure.parts["ripple"] < STRUCTURE_ALARM:
        yield periodic(found.frame)


def _next_experiment(found: Search, probabilities: Posterior) -> NextExperiment | None:
    """What would separate the leading effect from its likeliest rival."""
    if not probabilities.together:
        return None
    chances = rivals_of(found, probabilities, leading(found, probabilities))
    first, *others = sorted(chances, key=lambda name: -chances[name])
    if not others or chances[others[0]] < RIVAL * chances[first]:
        return None
    fits, second = explanations(found, probabilities), others[0]
    return next_experiment(fits[first], fits[second], (first, second), (chances[first], chances[second]))


def _verdict(found: Search, probabilities: Posterior) -> Verdict:
    by_library = found.scan.p_value < LIBRARY_ALARM
    by_structure = found.structure.p_value < STRUCTURE_ALARM
    if found.repeats.p_value < REPEATS_ALARM:
        return "unexplained"
    gain = _gain(found)
    if not (by_library or by_structure):
        likely = gain >= CLEAR_EVIDENCE and probabilities.nothing < 0.5
        return "inconclusive" if likely or found.base.fit.dof < FEWEST_SPARE else "adequate"
    left = found.left.p_value < STRUCTURE_ALARM or probabilities.unknown > 0.5
    if (left or (gain < CLEAR_EVIDENCE and by_structure)) and not _all_but_explained(found):
        return "unexplained"
    certain = min(found.scan.p_value, found.structure.p_value) < BEYOND_DOUBT
    if certain and gain > 0.0:
        return "effect-missing"
    return "effect-missing" if gain >= CLEAR_EVIDENCE and probabilities.nothing < 0.5 else "inconclusive"


def _gain(found: Search) -> float:
    """Drop of the information criterion that the best grown model brings."""
    return 2.0 * (found.best.log_evidence - found.base.log_evidence)


def _all_but_explained(found: Search) -> bool:
    """Whether named effects explain nearly all of a misfit, and what they leave is small beside the noise.

    Real measurements always keep some structure at the level of their noise; it is noted, not made the verdict.
    """
    spare = found.base.fit.dof
    excess = [refit.rss - spare for refit in (found.base, found.best)]
    small = found.best.relative_rms < 2.0 * found.best.floor
    return excess[0] > spare and excess[1] < max(REMAINDER * excess[0], NOTHING_LEFT) and small


def _sentence(
    verdict: Verdict,
    ratio: float,
    groups: Sequence[Sequence[str]],
    second: Sequence[str],
    imitators: frozenset[str],
) -> str:
    error = f"the error is {times(ratio)} the noise floor"
    if verdict == "adequate":
        return f"nothing is missing down to the noise floor: {error}"
    if verdict == "effect-missing":
        beside = f", and beside it {' or '.join(second)}" if second else ""
        other = " or another narrow feature" if imitators & {*groups[0], *second} else ""
        return f"{error}; missing is {' or '.join(groups[0])}{beside}{other}"
    if verdict == "unexplained":
        pattern = ", but no pattern of noise" if ratio < NOISY else ""
        return f"{error}{pattern}; something is missing that no effect of the library explains"
    return f"{error}; these data cannot tell whether something is missing"
