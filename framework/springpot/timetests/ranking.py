"""Installed models of tests in time in order, where none is named.

As of sweeps; see `springpot.comparison.ranking`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from springpot.comparison.ordering import TOO_FREE, Order, fits_of, in_order, spends_most
from springpot.comparison.result import LOOKED_AT, Judgement, Ranking, Skipped
from springpot.diagnosis.result import Progress, silent
from springpot.errors import DataError, SpringpotError
from springpot.identification.result import Identification
from springpot.measurement.opening import together
from springpot.misfit.error import Error
from springpot.misfit.frame import is_beyond_noise
from springpot.misfit.material import any_material, effects_of, material_floors
from springpot.misfit.residual_scatter import ResidualScatter
from springpot.plain_data import alive
from springpot.rheology.effect import Effect
from springpot.rheology.model import Family, Model
from springpot.rheology.points import Real
from springpot.thresholds import VERDICT

from .comparing import judgement_of
from .discovery import discover
from .fitting import identify
from .floor import TimeFloor, material_floor
from .hypotheses import FitResiduals, chi_square_gain, delta_bic, independent_samples
from .residuals_of_tests import Test, TestPart, parts_of_specimen
from .verdict import TimeCase, error_of


@dataclass(frozen=True, eq=False)
class RankedInTime:
    """A model fitted to tests in time, beside any material that was fitted to them too.

    Attributes
    ----------
    fit : Identification
        The fit.
    left : FitResiduals
        What it leaves of each test.
    beside : FitResiduals
        What the material leaves.
    noise : sequence of ResidualScatter
        Of each test, the same for all models.
    parts : sequence of TestPart
        The tests.
    """

    fit: Identification
    left: FitResiduals
    beside: FitResiduals
    noise: Sequence[ResidualScatter]
    parts: Sequence[TestPart]

    @property
    def model(self) -> Model:
        """What was fitted."""
        return self.fit.model

    @property
    def theta(self) -> Real:
        """Its parameters, shape (p,)."""
        return self.fit.theta

    @cached_property
    def rss(self) -> float:
        """Sum of squares of the residual over the noise."""
        return self.beside.squares(self.noise) - chi_square_gain(self.beside, self.left, self.noise)

    @property
    def numbers(self) -> float:
        """How many samples it was judged by, those counted once whose noise is alike."""
        return independent_samples(self.left.residuals, self.noise)

    @property
    def dof(self) -> float:
        """Those that its parameters, and the lines of a spectrum, do not follow."""
        return self.numbers - self.left.count - self.left.lines

    @property
    def noise_dof(self) -> float:
        """Degrees of freedom of the noise, which what the material leaves has told."""
        return max(self.numbers - self.beside.count - self.beside.lines, 1.0)

    @cached_property
    def error(self) -> Error:
        """Its error beside the noise."""
        return self._error(self.noise_with_imposed)

    @property
    def noise_with_imposed(self) -> list[ResidualScatter]:
        """The noise, with what it answers more to noise of imposed channels than the material."""
        return self.left.noise_with_imposed(self.noise, self.beside)

    @property
    def own_floor(self) -> float:
        """What the noise about itself leaves."""
        return self._error(self.left.noise).noise_floor

    def _error(self, noise: Sequence[ResidualScatter]) -> Error:
        return error_of(self.left.rows(self.parts, noise, self.fit.tests), noise)

    @property
    def floor(self) -> float:
        """The relative error that noise alone leaves."""
        return self.error.noise_floor

    @property
    def least_error(self) -> float:
        """Below which its relative error is not: that error itself."""
        return self.error.relative_rms

    @property
    def relative_rms(self) -> float:
        """Above which it is not."""
        return self.error.relative_rms

    @property
    def beyond(self) -> bool:
        """Whether its error is beyond the noise by more than chance, as of a sweep.

        Of few samples no test of their own sees it: they may be noise with any memory.
        """
        return is_beyond_noise(self.error.over_floor, max(self.dof, 1.0), self.noise_dof)

    @property
    def hardly_known(self) -> bool:
        """Whether so few numbers are left over that neither error nor noise says anything."""
        return min(self.dof, self.noise_dof) < VERDICT.fewest_spare

    @cached_property
    def log_evidence(self) -> float:
        """Minus half the Bayesian information criterion, beside that of the material."""
        return 0.5 * delta_bic(self.beside, self.left, self.noise)

    @cached_property
    def curve(self) -> Real:
        """What it says of each sample over the noise, less what was measured, shape (m,)."""
        return np.concatenate(self.left.whitened(self.noise))


@dataclass(frozen=True, eq=False)
class _BesideMaterial:
    """Tests, and any material that follows them with the effects that it needs.

    Attributes
    ----------
    case : TimeCase
        The examination of the material.
    parts : sequence of TestPart
        The tests.
    left : FitResiduals
        What the material leaves of them.
    noise : sequence of ResidualScatter
        Of each of them, in which all models are told.
    skipped : list of Skipped
        Models that cannot be fitted.
    """

    case: TimeCase
    parts: Sequence[TestPart]
    left: FitResiduals
    noise: Sequence[ResidualScatter]
    skipped: list[Skipped] = field(default_factory=list)

    @property
    def material(self) -> RankedInTime:
        """The material."""
        return RankedInTime(self.case.base, self.left, self.left, self.noise, self.parts)

    def fitted(self, model: Model, effects: tuple[Effect, ...]) -> Iterator[RankedInTime]:
        """The fit of a model with effects, unless the tests cannot judge it."""
        asked, grown = self.case.asked, model
        for effect in effects:
            grown = grown + effect
        samples = sum(len(part.measured) for part in self.parts)
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
        left = FitResiduals.of(fit, self.parts)
        yield RankedInTime(fit, left, self.left, self.noise, self.parts)

    def order(self, fits: Sequence[RankedInTime]) -> Order:
        """The fits judged and sorted out."""
        fits = [replace(found, noise=self.noise) for found in fits]
        best = max(found.log_evidence for found in fits)
        floors = self._floors(fits)
        judged = [self._judged(found, 2.0 * (best - found.log_evidence), floors) for found in fits]
        return in_order(judged, self._judged(self.material, 0.0, floors))

    def _floors(self, fits: Sequence[RankedInTime]) -> Mapping[tuple[str, ...], TimeFloor]:
        """The material floor for each set of effects: with the material's own it is known."""
        base = self.case.base
        lowest = TimeFloor(tuple(part.relative_rms for part in base.parts))
        own = [found.fit for found in fits]
        return material_floors(own, material_floor, {effects_of(base.model): lowest})

    def _judged(
        self, found: RankedInTime, delta: float, floors: Mapping[tuple[str, ...], TimeFloor]
    ) -> Judgement:
        judged = judgement_of(
            found.fit,
            delta,
            floors[effects_of(found.model)],
            found.noise_with_imposed,
            left=found.left,
        )
        known = not (found.beyond or found.hardly_known)
        vars(judged).update(
            ranked=found,
            beyond=judged.beyond or found.beyond,
            at_noise=judged.at_noise and known,
        )
        return judged

    def in_noise_of(self, one: RankedInTime) -> _BesideMaterial:
        """The same in the noise about a model."""
        return replace(self, noise=one.left.noise)


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
    parts, base = parts_of_specimen(case.base.data), case.base
    left = FitResiduals.of(base, parts)
    beside = _BesideMaterial(case, parts, left, left.noise)
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
