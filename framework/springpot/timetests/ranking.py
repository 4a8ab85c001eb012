"""Installed models of tests in time in order, where none is named.

As of sweeps; see `springpot.comparison.ranking`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from springpot.comparison.ordering import TOO_FREE, Order, fits_of, in_order, spends_most
from springpot.comparison.result import LOOKED_AT, Ranking, Skipped
from springpot.diagnosis.result import Progress, silent
from springpot.errors import DataError, SpringpotError
from springpot.measurement.opening import together
from springpot.misfit.material import any_material, effects_of, material_floors
from springpot.misfit.residuals_of_tests import Test
from springpot.plain_data import alive
from springpot.rheology.effect import Effect
from springpot.rheology.model import Family, Model
from springpot.thresholds import VERDICT

from .comparing import RankedInTime, judgement_of, judgements
from .discovery import discover
from .fitting import identify
from .floor import TimeFloor, material_floor
from .hypotheses import FitResiduals
from .verdict import TimeCase


@dataclass(frozen=True, eq=False)
class _BesideMaterial:
    """Tests, and any material that follows them with the effects that it needs.

    Attributes
    ----------
    case : TimeCase
        The examination of the material.
    material : RankedInTime
        Its fit, in the noise in which all models are told.
    skipped : list of Skipped
        Models that cannot be fitted.
    """

    case: TimeCase
    material: RankedInTime
    skipped: list[Skipped] = field(default_factory=list)

    def fitted(self, model: Model, effects: tuple[Effect, ...]) -> Iterator[RankedInTime]:
        """The fit of a model with effects, unless the tests cannot judge it."""
        asked, grown = self.case.asked, model
        for effect in effects:
            grown = grown + effect
        samples = sum(len(part.measured) for part in self.material.parts)
        # As many parameters as numbers follow anything.
        if len(grown.parameters) >= samples:
            why = f"{len(grown.parameters)} parameters for {samples} samples"
            self.skipped.append(Skipped(grown.name, why))
            return
        try:
            fit = identify(asked.tests, grown, noise=asked.known)
        except SpringpotError as error:
            self.skipped.append(Skipped(grown.name, str(error)))
            return
        left = FitResiduals.of(fit, self.material.parts)
        yield replace(self.material, fit=fit, left=left)

    def order(self, fits: Sequence[RankedInTime]) -> Order:
        """The fits judged and sorted out."""
        fits = [replace(found, noise=self.material.noise) for found in fits]
        floors = self._floors(fits)
        judged = judgements(fits, floors)
        own = judgement_of(self.material, 0.0, floors[effects_of(self.material.model)])
        return in_order(judged, own)

    def _floors(self, fits: Sequence[RankedInTime]) -> Mapping[tuple[str, ...], TimeFloor]:
        """The material floor for each set of effects: with the material's own it is known."""
        base = self.case.base
        lowest = TimeFloor(tuple(part.relative_rms for part in base.parts))
        own = [found.fit for found in fits]
        return material_floors(own, material_floor, {effects_of(base.model): lowest})

    def in_noise_of(self, one: RankedInTime) -> _BesideMaterial:
        """The same in the noise about a model."""
        return replace(self, material=replace(self.material, noise=one.left.noise))


def rank(
    tests: Sequence[Test],
    installed: Sequence[Model | Family],
    library: Sequence[Effect],
    progress: Progress = silent,
) -> Ranking:
    """Rank models against what any material reaches.

    Parameters
    ----------
    tests : sequence of TimeTest or Measurement
        Of one specimen, at least one in time.
    installed : sequence of Model or Family
        What is ranked, with the effects that any material needs. Those that have no law in time, or
        lack a condition, are named as skipped.
    library : sequence of Effect
        Effects that may be missing from any material.
    progress : callable
        Told in a few words what is being done.

    Raises
    ------
    SpringpotError
        If none of the models can be judged.
    """
    samples = sum(len(test) for test in tests)
    if samples <= VERDICT.fewest_spare:
        raise DataError(
            f"{together(test.name for test in tests)}: {samples} samples judge no model; measure at"
            " more times"
        )
    progress("looking for what is missing from any material")
    ladder = discover(tests, any_material(), library, progress=progress)
    case = alive(ladder.steps[-1].examined, TimeCase, "the ladder")
    beside = _BesideMaterial(case, RankedInTime.of(case.base))
    fits = fits_of(installed, beside.material, beside.fitted, progress)
    if not fits:
        raise DataError(
            f"{together(test.name for test in tests)}: none of the installed models can be judged"
            " by these tests"
        )
    order, notes = beside.order(fits), list(case.diagnosis.notes)
    if order.outgrown and (quietest := _quietest_alone(order)):
        notes.insert(0, f"the noise floor is the scatter about {quietest.model.name}: {TOO_FREE}")
        order = beside.in_noise_of(quietest).order(fits)
    return order.ranking(ladder, notes, beside.skipped)


def _quietest_alone(order: Order) -> RankedInTime | None:
    """The model of least noise of those that are adequate by their own.

    A free spectrum may follow so much of the samples that what it leaves is too small to be their
    noise.
    """
    others = [alive(one.ranked, RankedInTime, "a model") for one in (*order.near, *order.others)]
    alone = [found for found in others if not spends_most(found)][:LOOKED_AT]
    found = [one for one in alone if not one.left.doubtful]
    return min(found, key=lambda one: one.own_floor, default=None)
