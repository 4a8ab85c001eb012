"""Models against one set of data and one noise floor: which fails, where, and how sure that is."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TypeAlias

import numpy as np

from springpot.diagnosis.notes import judged, overtones
from springpot.diagnosis.result import Progress, silent
from springpot.errors import DataError, OptionError
from springpot.identification.space import require_conditions
from springpot.measurement.measurement import Measurement
from springpot.measurement.replicates import thinned
from springpot.misfit.floor import fitted_to_floor, likelihood_of_all
from springpot.misfit.material import MaterialFloor, effects_of, material_floor, material_floors
from springpot.misfit.refit import Refit, in_noise
from springpot.misfit.residual_causes import column_behind, one_test_of
from springpot.misfit.residual_tests import Finding
from springpot.rheology.model import Model

from .result import Comparison, Judgement, best_of

Effects: TypeAlias = tuple[str, ...]


def compare(
    measurement: Measurement,
    models: Sequence[Model],
    rng: np.random.Generator,
    progress: Progress = silent,
) -> Comparison:
    """Fit models and judge each against the noise floor that they share.

    The floor is that of the likeliest of them: a model that fails takes part of its failure for
    noise, or what goes on from point to point in the noise for its failure.

    Parameters
    ----------
    measurement : Measurement
        The data.
    models : sequence of Model
        At least one.
    rng : numpy.random.Generator
        For the simulated noise against which the residual of any material is held.
    progress : callable
        Told in a few words what is being done.

    Raises
    ------
    OptionError
        If there is no model.
    ModelError
        If the data lack a column that a model needs.
    DataError
        If there are too few data to judge a model.
    """
    if not models:
        raise OptionError("nothing to compare: give at least one model")
    measured, measurement = len(measurement), thinned(measurement)
    # Levels of which no point is left have no parameters either.
    models = [model.at_levels(np.unique(model.levels(measurement.points))) for model in models]
    fits = _fits(measurement, models, progress)
    noise, notes = fits[0].noise, []
    if noise.doubt:
        notes.append(noise.doubt)
    if measured > len(measurement):
        notes.append(f"compared on {len(measurement)} of the {measured} points")
    progress("looking how near any material comes")
    each = tuple(judgements(fits, floors_beside(fits, rng), rng))
    best, one_test = best_of(each), ""
    # Rows of several tests that one model follows to the noise need no parting.
    if best.fails or best.unclear:
        one_test, why = one_test_of(best.refit.data.raw, column_behind(best.refit.frame()))
        notes += filter(None, [why])
    return Comparison(measurement.name, each, harmonics_of(fits[0]), tuple(notes), one_test)


def harmonics_of(found: Refit) -> tuple[Finding, ...]:
    """What the force harmonics of the data say, whatever the model."""
    return tuple(judged(overtones(found.data.mean, found.noise.sd)))


def judgements(
    fits: Sequence[Refit], floors: Mapping[Effects, MaterialFloor], rng: np.random.Generator
) -> Iterator[Judgement]:
    """Fits in units of one noise, each beside the material floor with the same effects."""
    least = min(-2.0 * found.log_evidence for found in fits)
    # A generator for each: its tests may be asked for in any order, or not at all, and hang on no
    # other's draws.
    for found, own_rng in zip(fits, rng.spawn(len(fits)), strict=True):
        floor = floors[effects_of(found.model)]
        yield Judgement(found, floor, -2.0 * found.log_evidence - least, own_rng)


def floors_beside(
    fits: Iterable[Refit],
    rng: np.random.Generator,
    known: Mapping[Effects, MaterialFloor] | None = None,
) -> dict[Effects, MaterialFloor]:
    """The material floors of fits, unless they are `known`, each sought from the best of them.

    They do not depend on the model, but the values of its effects begin where that fit ended.
    """
    return material_floors(
        fits, lambda group: material_floor(min(group, key=lambda one: one.rss), rng), known
    )


def _fits(measurement: Measurement, models: Sequence[Model], progress: Progress) -> list[Refit]:
    """Fits of all models in units of one noise."""
    # All of them before the first fit: what cannot be compared is told at once.
    for model in models:
        require_conditions(model, measurement)
    first = []
    for model in models:
        progress(f"fitting {model.name}")
        first.append(fitted_to_floor(model, measurement))
    # After averaging: repeats are no further points, however many rows the file has.
    for fitted in first:
        if fitted.fit.dof < 1:
            raise DataError(
                f"{measurement.name}: {len(fitted.fit.measurement)} points cannot judge"
                f" {fitted.model.name}, which has {len(fitted.theta)} parameters; measure at more"
                " frequencies"
            )
    # One noise for all, that of the likeliest fit: errors are then compared, not noises.
    leader = max(first, key=likelihood_of_all)
    return [in_noise(fitted, leader.noise) for fitted in first]
