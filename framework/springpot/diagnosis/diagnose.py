"""The diagnosis from end to end."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from springpot.identification import require_conditions
from springpot.measurement import Measurement
from springpot.rheology import Effect, Model, Real

from .candidates import candidates_of
from .experiment import next_experiment
from .notes import notes, unexplained_harmonics
from .outliers import Outlier
from .posterior import (
    Posterior,
    classes,
    explanations,
    grown_beside,
    leading,
    partners,
    posterior,
    rivals_of,
    seconds,
)
from .result import Diagnosis, Error, NextExperiment, Verdict, Where
from .search import Search
from .settle import settled
from .thinning import thinned
from .verdict import STRUCTURE_ALARM, sentence, verdict_of
from .where import periodic, where

HARMONICS = "; the force holds harmonics that this model does not make"
RIVAL = 1e-3
"""Chance, beside that of the leading effect, from which another is worth a measurement."""


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
    verdict = verdict_of(found, probabilities, outliers)
    if verdict == "effect-missing":
        probabilities = probabilities.without_unknown()
    elif verdict == "unexplained":
        probabilities = probabilities.doubted(found.left.p_value)
    groups = [] if verdict == "adequate" else classes(found, probabilities)
    second = seconds(found, probabilities) if verdict == "effect-missing" else []
    ranked = candidates_of(found, probabilities, groups, verdict)
    diagnosis = Diagnosis(
        data=measurement.name,
        model=model,
        error=Error(base.relative_rms, base.floor, base.noise.source, base.noise.doubt),
        verdict=verdict,
        says=sentence(found, verdict, groups[0] if groups else (), second, probabilities.imitators, outliers)
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


def _places(found: Search, outliers: Sequence[Outlier], verdict: Verdict) -> Iterator[Where]:
    """Single points first, then bands, then what only a period shows."""
    yield from (outlier.place for outlier in outliers)
    bands = where(found.frame)
    yield from bands
    if not bands and verdict == "unexplained" and found.structure.parts["ripple"] < STRUCTURE_ALARM:
        yield periodic(found.frame)


def _next_experiment(found: Search, probabilities: Posterior) -> NextExperiment | None:
    """What would settle the more open of two questions: which effect leads, and which one stands beside it."""
    if not probabilities.together:
        return None
    leader = leading(found, probabilities)
    chances, fits = rivals_of(probabilities, leader), explanations(found, probabilities)
    beside = partners(found, probabilities)
    if _openness(beside) > _openness(chances):
        chances, fits = beside, {name: one.refit for name, one in grown_beside(found, leader, beside).items()}
    if _openness(chances) < RIVAL:
        return None
    first, second = sorted(chances, key=lambda name: -chances[name])[:2]
    return next_experiment(fits[first], fits[second], (first, second), (chances[first], chances[second]))


def _openness(chances: Mapping[str, float]) -> float:
    """Odds of the second likeliest answer against the likeliest."""
    most = sorted(chances.values())[-2:]
    return most[0] / most[1] if len(most) == 2 and most[1] > 0.0 else 0.0
