"""Models against one set of data and one noise floor: which fails, where, and how sure that is.

Where none is named the installed ones are put in order: the simplest that does what any material
can comes first. What is no part of the material is found first, by a discovery that begins with any
material; with the effects that it accepts each model is fitted in units of the same noise. The
material floor then says which models are as near as any material: those beside which a free
spectrum gains no more than it gains from noise. Adequate are those of them that leave no more than
noise, by the rule of `diagnose`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import NamedTuple, TypeAlias, TypeVar

import numpy as np

from springpot.diagnosis.discovery import discover
from springpot.diagnosis.ladder import Ladder
from springpot.diagnosis.notes import judged, overtones
from springpot.diagnosis.result import Progress, silent
from springpot.errors import DataError, OptionError
from springpot.identification.convex import is_relaxing
from springpot.identification.leastsquares import Effort
from springpot.identification.material import is_material
from springpot.identification.searching import STARTS
from springpot.identification.space import require_conditions
from springpot.measurement.independence import at_one_frequency
from springpot.measurement.measurement import Measurement
from springpot.measurement.replicates import thinned
from springpot.misfit.floor import fitted_to_floor, likelihood_of_all
from springpot.misfit.frame import chance_of_squares
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
from springpot.thresholds import COMPARISON, SEARCH, VERDICT

from .result import LOOKED_AT, Comparison, Judgement, RankedFit, Ranking, Skipped, best_of

TOO_FREE = (
    "what a free spectrum leaves is less,"
    " but by it none or only models of many parameters would be adequate"
)
"""Why the floor of any material is not taken."""
FIRST_MEMBER, LAST_MEMBER = 2, 6
"""Members of a family of sums that are tried; the first of each has a name of its own."""


class Order(NamedTuple):
    """Models sorted out, each list with its best first.

    Attributes
    ----------
    adequate, near, others : list of Judgement
        As in a ranking.
    outgrown : bool
        Whether the floor of any material may be too low: none is adequate though that material is,
        or the first adequate one spends most of the numbers, or simpler ones as near as any
        material are beyond the floor.
    """

    adequate: list[Judgement]
    near: list[Judgement]
    others: list[Judgement]
    outgrown: bool

    def ranking(
        self,
        ladder: Ladder,
        notes: Iterable[str],
        skipped: Iterable[Skipped],
        harmonics: tuple[Finding, ...] = (),
        one_test: str = "",
    ) -> Ranking:
        """All models in this order.

        Parameters
        ----------
        ladder : Ladder
            The discovery that told what any material needs.
        notes : iterable of str
            What a user should know; empty ones are none.
        skipped : iterable of Skipped
            Models that cannot be judged.
        harmonics, one_test
            As in a `Comparison`, of sweeps alone.
        """
        judged = (*self.adequate, *self.near, *self.others)
        told = tuple(dict.fromkeys(filter(None, notes)))
        adequate, near, out = tuple(self.adequate), tuple(self.near), tuple(dict.fromkeys(skipped))
        return Ranking(ladder.data, judged, harmonics, told, one_test, ladder, adequate, near, out)


def in_order(judged: Iterable[Judgement], material: Judgement) -> Order:
    """Sort models out.

    Parameters
    ----------
    judged : iterable of Judgement
        All of them.
    material : Judgement
        Any material with the effects that it needs, in units of the same noise.
    """
    # Those that are not adequate stand by evidence: how few parameters a model has is no merit
    # while it fails.
    # Those that differ by nothing that is printed stay in the order in which they were given.
    ordered, floor = sorted(judged, key=lambda one: round(one.delta_bic, 2)), material.ranked
    near_enough = [one for one in ordered if chance_beside(one.ranked, floor) >= COMPARISON.chance]
    as_near = [one for one in near_enough if not _outdone(one, ordered)]
    # The fewest parameters first. Sorting keeps the order of equals: of as many parameters the
    # likelier comes first.
    as_near.sort(key=lambda one: len(one.ranked.theta))
    adequate = _no_worse_than_rejected([one for one in as_near if one.adequate], ordered)
    near: list[Judgement] = []
    # Where a material is adequate, a model that is not lacks what the material has: only chance
    # made it as near.
    if not material.adequate:
        near = [one for one in as_near if one not in adequate]
    others = [one for one in ordered if one not in adequate and one not in near]
    # Where any material is far beyond the floor, no smaller noise is to blame.
    outgrown = not near and material.error.relative_rms < VERDICT.small_rest * floor.floor
    if adequate:
        outgrown = adequate[0] is not as_near[0] or spends_most(adequate[0].ranked)
    return Order(adequate, near, others, outgrown)


def _no_worse_than_rejected(
    adequate: Sequence[Judgement], ordered: Sequence[Judgement]
) -> list[Judgement]:
    """The adequate models that are nearer than every inadequate one of no more parameters.

    The fewer numbers a model leaves to judge it by, the larger an error passes for noise: without
    this a richer model could be adequate at an error at which a simpler one is not.
    """
    rejected = [one for one in ordered if one not in adequate]
    return [
        one for one in adequate if not any(_is_simpler_and_nearer(other, one) for other in rejected)
    ]


def _is_simpler_and_nearer(other: Judgement, one: Judgement) -> bool:
    if len(other.ranked.theta) > len(one.ranked.theta):
        return False
    # Crosswise, as a floor may be zero.
    floor, others = one.ranked.floor, other.ranked.floor
    # Of most models the fits by the noise tell, and neither error need be searched for.
    if other.ranked.least_error * floor > one.ranked.relative_rms * others:
        return False
    return other.error.relative_rms * floor <= one.error.relative_rms * others


def chance_beside(found: RankedFit, floor: RankedFit) -> float:
    """Chance that a free spectrum gains so much on a model from noise alone.

    The gain is that in chi-square, with as many degrees of freedom as the spectrum has lines more
    than the model has parameters. Where any material leaves more than noise, that remainder is not
    the model's fault and sets the scale.

    Parameters
    ----------
    found : RankedFit
        The model.
    floor : RankedFit
        Any material, in units of the same noise.
    """
    spare = max(found.dof - floor.dof, 1)
    # Never below one: a spectrum that follows some of the noise must not make the noise seem
    # smaller than it is.
    scale = max(floor.rss / max(floor.dof, 1), 1.0)
    return chance_of_squares(max(found.rss - floor.rss, 0.0) / scale, spare, found.noise_dof)


def _outdone(one: Judgement, others: Sequence[Judgement]) -> bool:
    """Whether a richer model is decisively better; that a simpler one does as well is no fault."""
    # Of computed data only rounding is left, and it is no merit to follow that.
    if one.computed:
        return False
    # A free spectrum may fail to gain beyond chance where a model of a few more parameters does.
    limit, size = one.delta_bic - SEARCH.decisive, len(one.ranked.theta)
    better = [
        other for other in others if other.delta_bic < limit and len(other.ranked.theta) > size
    ]
    # What one that spends most of the numbers gains on a model at the noise is noise that it
    # follows.
    if one.at_noise:
        better = [other for other in better if not spends_most(other.ranked)]
    return bool(better)


def spends_most(found: RankedFit) -> bool:
    """Whether a model has more parameters than it leaves numbers to judge them by."""
    return len(found.theta) > COMPARISON.most_spent * found.numbers


F = TypeVar("F", bound=RankedFit)
Fits: TypeAlias = Callable[[Model, tuple[Effect, ...]], Iterable[F]]


def fits_of(
    installed: Sequence[Model | Family],
    floor: RankedFit,
    one: Fits[F],
    progress: Progress,
) -> list[F]:
    """All models with the effects that any material needs, or without them.

    Without them only what may make by itself what a spectrum cannot: the others are no nearer than
    any material alone, which needs the effects.

    Parameters
    ----------
    installed : sequence of Model or Family
        Of a family, members up to the first that lacks nothing or gains nothing.
    floor : RankedFit
        Any material with the effects.
    one : callable
        Gives the fit of a model with some effects, or none where the data cannot judge it.
    progress : callable
        Told in a few words what is being done.
    """
    fits: list[F] = []
    effects = floor.model.effects
    for number, item in enumerate(installed, 1):
        progress(f"fitting model {number} of {len(installed)}{_with(effects)}: {item.name}")
        fits += _members(item, effects, floor, one)
        if effects and isinstance(item, Model) and not is_relaxing(item):
            fits += one(item, ())
    return fits


def _members(
    item: Model | Family, effects: tuple[Effect, ...], floor: RankedFit, one: Fits[F]
) -> Iterator[F]:
    """Fits of a model; of a family, members up to the first that lacks nothing or gains nothing."""
    if isinstance(item, Model):
        # The material itself is what all are judged by.
        if not is_material(item):
            yield from one(item, effects)
        return
    evidence = -np.inf
    for number in range(FIRST_MEMBER, min(LAST_MEMBER, item.largest) + 1):
        for found in one(item.build(number), effects):
            yield found
            # One more term after that can only follow noise, and each costs a fit of more
            # parameters.
            if found.log_evidence <= evidence or chance_beside(found, floor) >= COMPARISON.chance:
                return
            evidence = found.log_evidence


def _with(effects: tuple[Effect, ...]) -> str:
    if not effects:
        return ""
    return f" with {' and '.join(effect.name for effect in effects)}"


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
