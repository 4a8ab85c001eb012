"""The diagnosis from end to end."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from springpot.identification import is_material, require_conditions
from springpot.measurement import Measurement, steadied
from springpot.rheology import Effect, Model, Real

from .candidates import candidates_of
from .confounded import confounded_in_words
from .experiment import next_experiment
from .material import MaterialFloor, material_floor, split_in_words
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
from .refit import Refit
from .result import Diagnosis, Error, NextExperiment, Verdict, Where
from .search import Search, search
from .settle import DECISIVE, settled
from .thinning import thinned
from .verdict import STRUCTURE_ALARM, sentence, verdict_of
from .where import periodic, where

BESIDE_MATERIAL = {
    "effect-missing": ", and beside it a part of the material that no single effect supplies",
    "unexplained": "; any linear material comes nearer than the model with any effect",
    "inconclusive": "; any linear material comes nearer than the model with any effect",
}
"""What is added where effects are named beside a free spectrum."""
HARMONICS = "; the force holds harmonics that this model does not make"
RIVAL = 1e-3
"""Chance, beside that of the leading effect, from which another is worth a measurement."""


@dataclass(frozen=True, eq=False)
class Case:
    """All that a diagnosis found, for those who go on from it.

    Attributes
    ----------
    found : Search
        Fits and scans of the model.
    named : Search
        Those by which effects are named: of the model, or of any material where the model does not follow it.
    floor : MaterialFloor
        The least error that any material reaches.
    probabilities : Posterior
        Of every effect.
    diagnosis : Diagnosis
        The answer.
    """

    found: Search
    named: Search
    floor: MaterialFloor
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
    if "amplitude" not in model.needs:
        measurement = steadied(measurement)
    found, outliers = settled(measurement, model, library, rng, seeds)
    floor = material_floor(found.base, rng)
    named = _named_by(found, floor, library, rng)
    probabilities = posterior(named)
    verdict = verdict_of(named, probabilities, outliers)
    if verdict == "adequate" and named is not found:
        verdict = "unexplained"  # by effects: a material follows the data, but no single element mends the model
    if verdict == "effect-missing":
        probabilities = probabilities.without_unknown()
    elif verdict == "unexplained":
        probabilities = probabilities.doubted(named.left.p_value)
    groups = [] if verdict == "adequate" else classes(named, probabilities)
    second = seconds(named, probabilities) if verdict == "effect-missing" else []
    says = sentence(found, verdict, groups[0] if groups else (), second, probabilities.imitators, outliers)
    if named is not found:
        says = f"{says}{BESIDE_MATERIAL[verdict]}"
    diagnosis = Diagnosis(
        data=measurement.name,
        model=model,
        error=error_of(found.base, floor),
        verdict=verdict,
        says=says + (HARMONICS if unexplained_harmonics(named, verdict) else ""),
        split="" if verdict == "adequate" else split_in_words(found.base, floor, STRUCTURE_ALARM),
        where=tuple(_places(found, outliers, verdict)),
        candidates=tuple(candidates_of(named, probabilities, groups, verdict)),
        classes=tuple(tuple(group) for group in groups),
        next_experiment=_next_experiment(named, probabilities) if groups else None,
        notes=(
            *notes(named, probabilities, verdict, outliers, measured),
            *(confounded_in_words(named, library) if verdict != "adequate" else ()),
        ),
        evidence={
            "p_library": found.scan.p_value,
            "p_structure": found.structure.p_value,
            "p_left": named.left.p_value,
            "p_repeats": found.repeats.p_value,
            "nothing": probabilities.nothing,
            "unknown": probabilities.unknown + probabilities.narrow,
        },
    )
    return Case(found, named, floor, probabilities, diagnosis)


def error_of(base: Refit, floor: MaterialFloor) -> Error:
    """The three lines: a model's error, the noise floor, the material floor."""
    noise = base.noise
    return Error(base.relative_rms, base.floor, noise.source, noise.doubt, floor.relative_rms, floor.chance)


def _named_by(found: Search, floor: MaterialFloor, library: Sequence[Effect], rng: np.random.Generator) -> Search:
    """The search by which effects are named: that on any material, where the model and its effects leave structure.

    A model that cannot follow the material hides every other effect under its own misfit, and bends them to mend it.
    """
    if is_material(found.base.model) or found.left.p_value >= STRUCTURE_ALARM:
        return found
    free = search(floor.refit, library, rng)
    gain = 2.0 * (free.best.log_evidence_of_all - found.best.log_evidence_of_all)
    return free if gain > DECISIVE else found


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
