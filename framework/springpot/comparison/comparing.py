"""Models against one set of data and one noise floor: which fails, where, and how sure that is.

Where none is named the installed ones are put in order: the simplest that does what any material
can comes first. What is no part of the material is found first, by a discovery that begins with any
material; with the effects that it accepts each model is fitted in units of the same noise. The
material floor then says which models are as near as any material: those beside which a free
spectrum gains no more than it gains from noise. Adequate are those of them that leave no more than
noise, by the rule of `diagnose`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import TypeAlias

import numpy as np

from springpot.diagnosis.discovery import discover
from springpot.diagnosis.ladder import Ladder
from springpot.diagnosis.notes import judged, overtones
from springpot.diagnosis.result import Progress, silent
from springpot.errors import DataError, OptionError
from springpot.identification.leastsquares import Effort
from springpot.identification.searching import STARTS
from springpot.identification.space import require_conditions
from springpot.measurement.independence import at_one_frequency
from springpot.measurement.measurement import Measurement
from springpot.measurement.replicates import thinned
from springpot.misfit.floor import fitted_to_floor, likelihood_of_all
from springpot.misfit.material import (
    MaterialFloor,
    any_material,
    effects_of,
    material_floor,
    material_floors,
)
from springpot.misfit.refit import Refit, in_noise, refit
from springpot.misfit.residual_causes import column_behind, one_test_of
from springpot.misfit.residual_tests import Finding
from springpot.numerics import NEGLIGIBLE
from springpot.rheology.effect import Effect
from springpot.rheology.model import Family, Model

from .ordering import TOO_FREE, Order, fits_of, in_order, spends_most
from .result import LOOKED_AT, Comparison, Judgement, Ranking, Skipped, best_of

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


MOST_AT_ONE_FREQUENCY = 2
"""Parameters of a linear model that can be told there: a storage and a loss are all that it has."""
ONE_FREQUENCY = "at one frequency any two parameters do the same"
"""Why a model of more is not fitted there."""


def rank(
    measurement: Measurement,
    installed: Sequence[Model | Family],
    library: Sequence[Effect],
    rng: np.random.Generator,
    progress: Progress = silent,
) -> Ranking:
    """Rank models against the material floor.

    Parameters
    ----------
    measurement : Measurement
        The data.
    installed : sequence of Model or Family
        What is ranked, with the effects that any material needs; of a family, members
        until one is adequate or one more term brings no evidence. Those that need a column which
        the data lack are left out.
    library : sequence of Effect
        Effects that may be missing from any material.
    rng : numpy.random.Generator
        For simulated noise.
    progress : callable
        Told in a few words what is being done.

    Raises
    ------
    DataError
        If there are too few data to judge anything.
    """
    progress("looking for what is missing from any material")
    ladder = discover(measurement, any_material(), library, rng, progress=progress)
    case = ladder.steps[-1].case
    # Any material with the accepted effects tells the noise for all: no model leaves less.
    floor = case.search.base
    skipped: list[Skipped] = []
    fits = fits_of(installed, floor, partial(_one, floor=floor, skipped=skipped), progress)
    if not fits:
        raise DataError(
            f"{measurement.name}: none of the installed models can be judged by {len(measurement)}"
            " points"
        )
    order, notes = _beside(fits, floor, case.floor, rng), []
    if order.outgrown:
        progress("looking for a simpler model that is adequate by its own noise")
        quietest = _quietest_alone([*order.near, *order.others], case.floor, rng)
        if quietest is not None:
            notes.append(f"the noise floor is the scatter about {quietest.model.name}: {TOO_FREE}")
            floor = in_noise(floor, quietest.noise, STARTS)
            fits = fits_of(installed, floor, partial(_one, floor=floor, skipped=[]), progress)
            order = _beside(fits, floor, material_floor(floor, rng), rng)
    notes += [_of_one_test(ladder), *floor.noise.doubt.splitlines(), *ladder.diagnosis.notes]
    return order.ranking(ladder, notes, skipped, harmonics_of(floor), ladder.diagnosis.one_test)


def _of_one_test(ladder: Ladder) -> str:
    """What is told where one test of several is behind all that is left."""
    case = ladder.steps[-1].case
    # What goes with the time is told of in the notes of the ladder already.
    if not ladder.diagnosis.one_test or case.course is not None:
        return ""
    found = case.naming.best
    return one_test_of(found.data.raw, column_behind(found.frame()))[1]


def _beside(
    fits: Sequence[Refit], floor: Refit, lowest: MaterialFloor, rng: np.random.Generator
) -> Order:
    """The fits judged and sorted out, beside any material with the accepted effects."""
    # A model of a plugin may bring effects of its own.
    floors = floors_beside(fits, rng, {effects_of(floor.model): lowest})
    return in_order(judgements(fits, floors, rng), Judgement(floor, lowest, 0.0, rng))


def _quietest_alone(
    others: Sequence[Judgement], lowest: MaterialFloor, rng: np.random.Generator
) -> Refit | None:
    """The model of least noise of those that `diagnose` calls adequate by their own fit's noise.

    A free spectrum may follow so much of the points that what it leaves is too small to be their
    noise.
    """
    found: list[Refit] = []
    for one in [one for one in others if not spends_most(one.refit)][:LOOKED_AT]:
        own = fitted_to_floor(one.model, one.refit.data.raw, [one.refit.theta])
        alone = Judgement(own, lowest, 0.0, rng)
        if alone.adequate:
            found.append(own)
    # One that is wrong takes part of its misfit for noise.
    return min(found, key=lambda own: own.floor, default=None)


def _one(
    model: Model, effects: tuple[Effect, ...], floor: Refit, skipped: list[Skipped]
) -> Iterator[Refit]:
    """The fit of one model, unless these data cannot judge it."""
    grown, data = model, floor.data
    for effect in effects:
        grown = grown + effect
    missing = sorted(grown.needs - set(data.mean.conditions))
    if missing:
        skipped.append(Skipped(grown.name, f"needs the column {', '.join(missing)}"))
    # As many parameters as numbers follow anything: such a model would come first for no reason.
    elif len(grown.parameters) >= 2 * len(data.mean):
        skipped.append(
            Skipped(grown.name, f"{len(grown.parameters)} parameters for {len(data.mean)} points")
        )
    # Every further one is the same curve, and its fit only costs time.
    elif len(model.parameters) > MOST_AT_ONE_FREQUENCY and _is_read_at_one_frequency(
        model, effects, data.mean
    ):
        skipped.append(Skipped(grown.name, ONE_FREQUENCY))
    else:
        yield refit(grown, data, floor.noise, starts=STARTS, effort=Effort(NEGLIGIBLE))


def _is_read_at_one_frequency(model: Model, effects: Sequence[Effect], data: Measurement) -> bool:
    """Whether all that the data hold of a linear model is one storage and one loss."""
    # A shift of times reads the same curve at another place for each temperature, as in a ramp at 1
    # Hz.
    shifted = any(effect.plane == "shift" for effect in (*model.effects, *effects))
    return at_one_frequency(data) and not model.needs and not shifted
