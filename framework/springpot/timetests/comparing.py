"""Models against the same tests, and how a fit stands beside the noise and any material.

Each model is fitted to all tests in time: which follows them best. The error of a fit is told
against the noise and against what any material reaches. Where no model is named the installed ones
are put in order.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from springpot.comparison.comparing import (
    TOO_FREE,
    Order,
    compare as compare_sweeps,
    fits_of,
    in_order,
    spends_most,
)
from springpot.comparison.result import (
    LOOKED_AT,
    ONLY_NOISE,
    UNCLEAR,
    Comparison,
    Judgement,
    Ranking,
    Skipped,
)
from springpot.diagnosis.in_practice import Accuracy
from springpot.diagnosis.result import Progress, silent
from springpot.errors import DataError, SpringpotError
from springpot.identification.population import Specimens
from springpot.identification.problem import default_objective
from springpot.identification.result import Identification, Standing
from springpot.measurement.opening import together
from springpot.misfit.error import Error, times
from springpot.misfit.frame import is_beyond_noise
from springpot.misfit.material import any_material, effects_of, lowest_error, material_floors
from springpot.misfit.residual_scatter import ROUGHER, ResidualScatter
from springpot.misfit.residuals_of_tests import Test, TestPart, parts_of_specimen
from springpot.misfit.where import Where
from springpot.plain_data import alive
from springpot.registry import parse_model
from springpot.rheology.effect import Effect
from springpot.rheology.model import Family, Model
from springpot.rheology.points import Real
from springpot.thresholds import VERDICT

from .discovery import discover
from .fitting import identify
from .hypotheses import FitResiduals, bic_of, chi_square_gain, delta_bic, independent_samples
from .material import TimeFloor, material_floor
from .verdict import TimeCase, error_of, misfit_of, where_missed

DOUBT = "what is left may be noise, or more: these tests cannot tell"
"""What is said of a model that noise would hardly miss as much, or noise that the signal lacks."""
MORE = "what is left is more than noise"
"""What is said of a model that is missed nowhere in particular."""


@dataclass(frozen=True, eq=False)
class RankedInTime:
    """A model fitted to tests in time, beside the best of all or any material.

    Attributes
    ----------
    fit : Identification
        The fit.
    left : FitResiduals
        What it leaves of each test.
    beside : FitResiduals
        What the other leaves.
    noise : sequence of ResidualScatter
        Of each test, the same for all models.
    parts : sequence of TestPart
        The tests.
    wider : float
        By how much the variance that evidence is told in exceeds that noise's.
    """

    fit: Identification
    left: FitResiduals
    beside: FitResiduals
    noise: Sequence[ResidualScatter]
    parts: Sequence[TestPart]
    wider: float = 1.0

    @classmethod
    def of(cls, fit: Identification) -> RankedInTime:
        """A fit by itself, in the noise about it."""
        parts = parts_of_specimen(fit.data)
        left = FitResiduals.of(fit, parts)
        return cls(fit, left, left, left.noise, parts)

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
        """Degrees of freedom of the noise, which what the other leaves has told."""
        return max(self.numbers - self.beside.count - self.beside.lines, 1.0)

    @cached_property
    def error(self) -> Error:
        """Its error beside the noise."""
        return self._error(self.noise_with_imposed)

    @property
    def noise_with_imposed(self) -> list[ResidualScatter]:
        """The noise, with what it answers more to noise of imposed channels than the other."""
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
        """Minus half the Bayesian information criterion, beside that of the other."""
        by = float(np.sqrt(self.wider))
        unit = [replace(each, size=each.size * by) for each in self.noise]
        return 0.5 * delta_bic(self.beside, self.left, unit)

    @cached_property
    def curve(self) -> Real:
        """What it says of each sample over the noise, less what was measured, shape (m,)."""
        return np.concatenate(self.left.whitened(self.noise))


def compare(
    tests: Sequence[Test],
    models: Sequence[Model | str],
    progress: Callable[[str], None] | None = None,
) -> Comparison:
    """Judge models of tests in time, each fitted to all of them together.

    Parameters
    ----------
    tests : sequence of TimeTest or Measurement
        Of one specimen, at least one in time.
    models : sequence of Model or str
        Those that have no law in time, or lack a condition, are named as left out.
    progress : callable, optional
        Told in a few words what is being done.

    Returns
    -------
    Comparison
        Best first.

    Raises
    ------
    SpringpotError
        If none of the models can be fitted.

    Notes
    -----
    Misses count in units of the noise, or of what the best model leaves where that is more: between
    models that are both far off, precision that none of them can use is no evidence.
    """
    fits: list[Identification] = []
    left_out: dict[str, str] = {}
    # All expressions first: one that is mistyped is told before minutes are spent on the others.
    parsed = [parse_model(each) if isinstance(each, str) else each for each in models]
    for model in parsed:
        if progress is not None:
            progress(f"fitting {model.name}")
        try:
            fits.append(identify(tests, model))
        except SpringpotError as error:
            # One model that cannot be followed must not keep the others from being compared.
            left_out[model.name] = str(error)
    if not fits:
        raise DataError(next(iter(left_out.values()), "there is no model to compare"))
    found = [RankedInTime.of(fit) for fit in fits]
    best = min((one.left for one in found), key=bic_of)
    # One noise for all, that about the best model; by what it leaves, where that is more.
    noise = best.scatters
    wider = max(1.0, best.squares(noise) / independent_samples(best.residuals, noise))
    found = [replace(one, beside=best, noise=noise, wider=wider) for one in found]
    judged = judgements(found, material_floors(fits, material_floor))
    judged.sort(key=lambda one: one.delta_bic)
    names = together(test.name for test in fits[0].tests)
    return Comparison(names, tuple(judged), (), (), "", left_out=left_out)


def judgements(
    fits: Sequence[RankedInTime], floors: Mapping[tuple[str, ...], TimeFloor]
) -> list[Judgement]:
    """Fits in units of one noise, each beside the material floor with the same effects."""
    best = max(found.log_evidence for found in fits)
    return [
        judgement_of(found, 2.0 * (best - found.log_evidence), floors[effects_of(found.model)])
        for found in fits
    ]


def judgement_of(found: RankedInTime, delta: float, floor: TimeFloor) -> Judgement:
    """One model against the tests that it was fitted to.

    Parameters
    ----------
    found : RankedInTime
        The model.
    delta : float
        Its information criterion above that of the best model.
    floor : TimeFloor
        What any material reaches with the same effects.
    """
    fit, noise = found.fit, found.noise_with_imposed
    tests, left = found.left.rows(found.parts, noise, fit.tests), found.left.beside(noise)
    error = error_of(tests, noise, floor)
    where: tuple[Where, ...] = ()
    says, spare = ONLY_NOISE, sum(test.points for test in fit.tests) - len(fit.theta)
    # Of so few numbers no test sees a pattern.
    few = spare < VERDICT.fewest_spare
    unclear = few and not left.misfit and error.over_floor > VERDICT.misfit
    if unclear:
        says = UNCLEAR
    elif left.doubtful or any(map(_is_hidden, noise)):
        says = DOUBT
    if left.misfit:
        where, says = where_missed(found.parts, left, noise), MORE
    if where:
        says = where[0].says
    known = {
        "ranked": found,
        "model": fit.model,
        "chi_square": fit.cost,
        "degrees_of_freedom": spare,
        "free_parameters": len(fit.theta),
        "fails": left.misfit,
        "unclear": unclear,
        "at_noise": not (left.doubtful or found.beyond or found.hardly_known),
        "beyond": left.misfit or found.beyond,
        "computed": error.relative_rms < VERDICT.arithmetic,
        "says": f"error {times(error.over_floor)} the noise; {says}",
        "parameters": fit.parameters,
        "where": where,
        "by_test": tests,
        "findings": (),
        "notes": fit.notes,
    }
    return Judgement.told(fit, error, delta, known)


def _is_hidden(noise: ResidualScatter) -> bool:
    """Whether noise of this size would show in the differences of neighbours, and does not.

    They have the share (1 - memory) / (1 + memory) of its power, at the highest frequency; in units
    of the residual what the signal tells of itself is one.
    """
    return noise.size**2 * (1.0 - noise.memory) > ROUGHER**2 * (1.0 + noise.memory)


def standing_of(identified: Identification, promised: Accuracy | None = None) -> Standing | None:
    """How the error of a fit stands against noise and any material.

    None where the data are too few to tell.

    Parameters
    ----------
    identified : Identification
        The fit. The floors are those of `compare`, which fits the same model to the same data.
    promised : Accuracy, optional
        What the instrument promises: what lies within it is good enough, as for `diagnose`.
    """
    alone = identified.uncertainty is not None
    standing = _of_sweep(identified) if alone else _of_tests(identified)
    if promised is None or standing is None or standing.good_enough:
        return standing
    parts = parts_of_specimen(identified.data)
    if not promised.holds([misfit_of(part, identified) for part in parts]):
        return standing
    says = promised.says(identified.relative_rms, standing.says)
    return replace(standing, good_enough=True, says=says)


def _of_sweep(identified: Identification) -> Standing | None:
    """The same of sweeps alone."""
    if identified.fit.dof < VERDICT.fewest_spare:
        return None
    try:
        # With the seed of the fit: asked twice, its standing is the same.
        rng = np.random.default_rng(identified.seed)
        [judged] = compare_sweeps(identified.measurement, [identified.model], rng).judgements
    except DataError:
        # Rows that repeat a point are one point to a comparison: where too few are left, it refuses
        # what was fitted.
        return None
    error, says = judged.error, judged.says
    good = not (judged.fails or judged.unclear)
    # Another objective weighs the points otherwise: its error may be larger though its search ended
    # at its best.
    alike = identified.fit.objective.name == default_objective(identified.measurement).name
    best = max(error.relative_rms, error.noise_floor)
    # Searches that ended at the best agree to several digits. Where the model itself fails, a
    # longer one mends nothing.
    if good and alike and identified.relative_rms > VERDICT.agrees * best:
        good = False
        says = (
            f"the search stopped short, this model reaches {100 * error.relative_rms:.2g} % on"
            " these data: give it a larger budget, or leave the optimiser out"
        )
    specimens = Specimens.of(identified.measurement)
    if specimens is not None and (scatter := specimens.scatter(identified.fit)):
        # To a comparison the rows of all files are repeats: their differences pass for noise there.
        says = says.replace(
            ONLY_NOISE, f"what is left is that specimens differ by {100.0 * scatter:.2g} %"
        )
    # Of all rows, as the error that is printed beside it: a comparison looks at some of many.
    lowest = lowest_error(
        identified.model, identified.measurement, identified.theta, identified.relative_rms
    )
    return Standing(error.noise_floor, error.noise_source, lowest, good, says)


def _of_tests(identified: Identification) -> Standing:
    """The same of tests of which one at least is in time."""
    judged = judgement_of(RankedInTime.of(identified), 0.0, material_floor([identified]))
    error, good = judged.error, not judged.fails
    return Standing(error.noise_floor, error.noise_source, error.material_floor, good, judged.says)


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
