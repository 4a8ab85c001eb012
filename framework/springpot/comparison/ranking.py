"""Installed models in order, where none is named.

The simplest that does what any material can comes first.

What is no part of the material is found first, by a discovery that begins with any material; with
the effects that it accepts each model is fitted in units of the same noise. The material floor then
says which models are as near as any material: those beside which a free spectrum gains no more than
it gains from noise. Adequate are those of them that leave no more than noise, by the rule of
`diagnose`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from springpot.diagnosis.discovery import discover
from springpot.diagnosis.ladder import Ladder
from springpot.diagnosis.result import Progress, silent
from springpot.errors import DataError
from springpot.identification.leastsquares import Effort
from springpot.identification.searching import STARTS
from springpot.measurement.independence import at_one_frequency
from springpot.measurement.measurement import Measurement
from springpot.misfit.floor import fitted_to_floor
from springpot.misfit.material import MaterialFloor, any_material, effects_of, material_floor
from springpot.misfit.refit import Refit, in_noise, refit
from springpot.misfit.residual_causes import column_behind, one_test_of
from springpot.numerics import NEGLIGIBLE
from springpot.rheology.effect import Effect
from springpot.rheology.model import Family, Model

from .comparing import floors_beside, harmonics_of, judgements
from .ordering import TOO_FREE, Order, fits_of, in_order, spends_most
from .result import LOOKED_AT, Judgement, Ranking, Skipped

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
