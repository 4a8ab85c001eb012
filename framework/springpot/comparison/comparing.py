"""Models against one set of data and one noise floor: which fails, where, and how sure that is."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TypeAlias

import numpy as np

from springpot.diagnosis.examination import Progress, silent
from springpot.diagnosis.notes import judged, overtones
from springpot.drawing import draw, html_of, text_of
from springpot.errors import DataError, OptionError
from springpot.format_numbers import NAMED
from springpot.identification.material import is_material
from springpot.identification.space import require_conditions
from springpot.identification.value import PartResult, Value, parts_of, values_of
from springpot.measurement.measurement import Measurement
from springpot.measurement.replicates import thinned
from springpot.misfit.error import Error
from springpot.misfit.floor import beyond_floor, fitted_to_floor, is_arithmetic, is_hardly_known
from springpot.misfit.material import MaterialFloor, error_of, material_floor
from springpot.misfit.refit import Refit, refit
from springpot.misfit.residual_battery import Battery, Finding, battery
from springpot.misfit.residual_causes import column_behind, one_test_of
from springpot.misfit.values import printed
from springpot.misfit.where import Where, where
from springpot.misfit.words import over_floor, percent, times
from springpot.plain_data import alive, jsonable, number, some
from springpot.registry import parse_model
from springpot.rheology.model import Model

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Effects: TypeAlias = tuple[str, ...]


SCHEMA = "springpot.comparison/2"
TOLD = (
    "model",
    "error",
    "chi_square",
    "degrees_of_freedom",
    "free_parameters",
    "delta_bic",
    "fails",
    "unclear",
    "says",
    "parameters",
    "where",
    "by_test",
    "notes",
)
"""Of a judgement, in the order of its schema."""
STARTS = 4
"""Starts of each of a few models that a user compares, from the fit that found its own noise."""

ONLY_NOISE = "nothing is left but noise"
"""What is said of a model beside which no pattern is left."""


@dataclass(frozen=True, eq=False)
class Judgement:
    """One model against the data.

    Attributes
    ----------
    fitted : Refit, Identification or None
        Its fit, in units of the noise, of tests in time with all that it found; a file does not
        hold it.
    error : Error
        Its error, the noise floor and the material floor, relative to |K|.
    delta_bic : float
        Bayesian information criterion above that of the best model compared.
    rng : numpy.random.Generator, optional
        For the simulated noise of its tests, which are made when they are asked for.
    """

    fitted: object | None
    error: Error
    delta_bic: float
    rng: np.random.Generator | None = None

    @property
    def refit(self) -> Refit:
        """Its fit, in units of the noise."""
        return alive(self.fitted, Refit, "a judgement")

    @cached_property
    def battery(self) -> Battery:
        """Tests on its residual."""
        return battery(self.refit.frame(), alive(self.rng, np.random.Generator, self.model.name))

    @cached_property
    def where(self) -> tuple[Where, ...]:
        """Where it fails; nowhere where noise explains all."""
        # Places are sought by thresholds of their own: beside noise one in hundreds would be an
        # invention.
        if not self.fails:
            return ()
        return tuple(where(self.refit.frame()))

    def __repr__(self) -> str:
        return f"<Judgement {self.model.name}: {self.says}>"

    @cached_property
    def findings(self) -> tuple[Finding, ...]:
        """Each test in a sentence."""
        return self.battery.findings

    @cached_property
    def model(self) -> Model:
        """The model."""
        return self.refit.model

    @cached_property
    def by_test(self) -> tuple[PartResult, ...]:
        """Each test beside its noise floor."""
        data, error = self.refit.data.raw, self.error
        sweep = PartResult.of_sweep(data.name, len(data), error.relative_rms, error.noise_floor)
        return (sweep,)

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """What its numbers do not say."""
        return ()

    @cached_property
    def chi_square(self) -> float:
        """Sum of squares of the residual over the noise."""
        return self.refit.rss

    @cached_property
    def degrees_of_freedom(self) -> float:
        """Measured numbers less those followed, which of a spectrum need not be whole."""
        return self.refit.fit.dof

    @cached_property
    def free_parameters(self) -> int:
        """Parameters that were fitted, lines of a spectrum among them."""
        return len(self.refit.theta)

    @cached_property
    def parameters(self) -> dict[str, Value]:
        """Its parameters with their intervals, in printed units."""
        return printed(self.refit)

    @cached_property
    def fails(self) -> bool:
        """Whether it leaves more than noise, by the tests that `diagnose` makes too."""
        # What rounding leaves of computed data is full of patterns, and nothing is missing.
        if is_arithmetic(self.refit):
            return False
        return self.battery.alarm

    @cached_property
    def unclear(self) -> bool:
        """Whether it is far from the noise, and no test says how.

        Or the noise is larger than one may believe.
        """
        return not self.fails and not self.at_noise

    @property
    def at_noise(self) -> bool:
        """Whether its error is as large as noise makes it.

        What pattern it has, is another question.
        """
        return at_noise(self.refit, self.error)

    @property
    def adequate(self) -> bool:
        """Whether its error is that of noise in size and in pattern, by the rules of `diagnose`."""
        # By size first, which costs nothing: the tests draw thousands of simulated residuals.
        return self.at_noise and not self.fails

    @cached_property
    def says(self) -> str:
        """The judgement in one sentence."""
        if is_arithmetic(self.refit):
            return (
                f"error {percent(self.error.relative_rms)}: that of arithmetic,"
                " and nothing is missing"
            )
        ratio = f"error {percent(self.error.relative_rms)}, without a noise floor"
        if self.error.noise_floor > 0.0:
            ratio = (
                f"error {times(self.error.relative_rms / self.error.noise_floor)} the noise floor"
            )
        if self.unclear and self.error.is_hardly_noise and not beyond_floor(self.refit):
            return f"{ratio}; nothing is left but noise, but {self.error.advice}"
        # Before "nothing is left but noise", which no error beyond the floor may be called.
        if self.unclear:
            return (
                f"{ratio}; what is left has no pattern:"
                " these data cannot tell whether something is missing"
            )
        if not self.fails:
            return f"{ratio}; {ONLY_NOISE}"
        # What fails without a place, such as too much scatter everywhere, is told by its surest
        # test.
        if not self.where:
            return f"{ratio}; {next(finding.says for finding in self.findings if finding.found)}"
        return f"{ratio}; {'; '.join(place.says for place in self.where[:NAMED])}"

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        row = {name: getattr(self, name) for name in TOLD}
        return dict(jsonable({**row, "model": self.model.name, "tests": self.findings}))

    @classmethod
    def from_dict(cls, row: Mapping[str, Any]) -> Judgement:
        """What `to_dict` gave."""
        told = {name: row[name] for name in TOLD if name not in ("error", "delta_bic")}
        told |= {
            "model": parse_model(row["model"]),
            "chi_square": number(row["chi_square"]),
            "parameters": values_of(row["parameters"]),
            "notes": tuple(row["notes"]),
            "by_test": parts_of(row["by_test"]),
            "where": tuple(Where.from_dict(each) for each in row["where"]),
            "findings": tuple(Finding.from_dict(each) for each in row["tests"]),
        }
        error = Error.from_dict(row["error"])
        return cls.told(None, error, number(row["delta_bic"]), told)

    @classmethod
    def told(
        cls, fitted: object | None, error: Error, delta_bic: float, known: Mapping[str, Any]
    ) -> Judgement:
        """One of which all is known that its fit would be asked for."""
        judged = cls(fitted, error, delta_bic)
        # Where a fit keeps what it was asked for once.
        vars(judged).update(known)
        return judged


NEARLY = 1.5
"""Times the error of the nearest model within which fewer parameters are worth more than it."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """Several models against the same data.

    Attributes
    ----------
    data : str
        Name of the data.
    judgements : tuple of Judgement
        One for each model, in the order in which they were given.
    harmonics : tuple of Finding
        What the force harmonics say, whatever the model.
    notes : tuple of str
        What else the user should know.
    one_test : str
        How to choose the rows of one test, ``current=0.5``, where rows of several stand together
        and the best model leaves more than noise; else empty.
    left_out : mapping of str to str
        Models that could not be fitted, and why.

    Examples
    --------
    >>> import springpot
    >>> names = ["fractional-maxwell", "fractional-maxwell + inertia"]
    >>> both = springpot.compare("artificial-hidden", names)
    >>> both.best.model.name
    'fractional-maxwell + inertia'
    >>> [judged.fails for judged in both.judgements]
    [True, True]
    """

    data: str
    judgements: tuple[Judgement, ...]
    harmonics: tuple[Finding, ...]
    notes: tuple[str, ...]
    one_test: str
    left_out: Mapping[str, str] = field(default_factory=dict, kw_only=True)

    @property
    def best(self) -> Judgement:
        """The model with the least information criterion."""
        return best_of(self.judgements)

    @property
    def shown(self) -> tuple[Judgement, ...]:
        """Those that a picture shows."""
        return self.judgements

    @property
    def handy(self) -> Judgement | None:
        """The model of the fewest parameters nearly as near as the nearest that one can write down.

        None where that is the best, or has as many parameters.
        """
        written = [one for one in self.judgements if not is_material(one.model)]
        least = min((one.error.relative_rms for one in written), default=0.0)
        near = [one for one in written if one.error.relative_rms <= NEARLY * least]
        fewest = min(
            near, key=lambda one: (one.free_parameters, one.error.relative_rms), default=self.best
        )
        if fewest.free_parameters >= self.best.free_parameters:
            return None
        return fewest

    @property
    def says(self) -> str:
        """What there is to say of all of them; nothing where they were chosen by hand."""
        return ""

    @property
    def tests(self) -> tuple[PartResult, ...]:
        """Each test beside its noise floor, by the best model."""
        return self.best.by_test

    @cached_property
    def magnitude(self) -> str:
        """What errors are shares of, such as |K|."""
        return self.measurement.units.magnitude

    @cached_property
    def measurement(self) -> Measurement:
        """The data, repeats averaged, with the standard deviations of the noise floor."""
        found = self.judgements[0].refit
        return replace(found.data.mean, sd=found.noise.sd)

    def __str__(self) -> str:
        return text_of(self)

    def __repr__(self) -> str:
        errors = ", ".join(
            f"{one.model.name} {over_floor(one.error.relative_rms, one.error.noise_floor)} x floor"
            for one in self.shown
        )
        return f"<Comparison of {self.data}: {errors}>"

    def plot(
        self, path: str | Path | None = None, *, ax: Axes | None = None
    ) -> Figure | Axes | Path:
        """Data and models in the views that rheologists use, and what is left.

        See `springpot.drawing.draw`.

        Of a ranking those models are drawn that `shown` names.
        """
        return draw(self, path, ax)

    def _repr_html_(self) -> str:
        return html_of(self)

    def to_dict(self) -> dict[str, Any]:
        """Schema ``springpot.comparison/2``."""
        answer = {
            "schema": SCHEMA,
            "data": self.data,
            "best": self.best.model.name,
            "handy": self.handy and self.handy.model.name,
            "tests": self.tests,
            "models": self.judgements,
            "harmonics": self.harmonics,
            "one_test": self.one_test,
            "magnitude": self.magnitude,
            "notes": self.notes,
            "left_out": self.left_out,
        }
        return dict(jsonable(answer))

    @classmethod
    def from_dict(cls, answer: Mapping[str, Any]) -> Self:
        """What `to_dict` gave."""
        judged = some(Judgement.from_dict(row) for row in answer["models"])
        further = cls.further(answer, {one.model.name: one for one in judged})
        comparison = cls(
            answer["data"],
            judged,
            tuple(Finding.from_dict(row) for row in answer["harmonics"]),
            tuple(answer["notes"]),
            answer["one_test"],
            left_out=answer["left_out"],
            **further,
        )
        vars(comparison).update(magnitude=answer["magnitude"])
        return comparison

    @classmethod
    def further(cls, answer: Mapping[str, Any], judged: Mapping[str, Judgement]) -> dict[str, Any]:
        """What a further kind of comparison holds beside: its models are named, and given here."""
        return {}


def compare(
    measurement: Measurement,
    models: Sequence[Model],
    rng: np.random.Generator,
    progress: Progress = silent,
) -> Comparison:
    """Fit models and judge each against the noise floor that they share.

    The floor is the lowest that any of the models finds: a model that fails takes part of its
    failure for noise.

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
    fits = _fits(measurement, models, progress)
    quiet = fits[0]
    notes = []
    if quiet.noise.doubt:
        notes.append(quiet.noise.doubt)
    if measured > len(measurement):
        notes.append(f"compared on {len(measurement)} of the {measured} points")
    progress("looking how near any material comes")
    each = tuple(judgements(fits, material_floors(fits, rng), rng))
    best, one_test = best_of(each), ""
    # Rows of several tests that one model follows to the noise need no parting.
    if best.fails or best.unclear:
        one_test, why = one_test_of(best.refit.data.raw, column_behind(best.refit.frame()))
        notes += filter(None, [why])
    return Comparison(measurement.name, each, harmonics_of(quiet), tuple(notes), one_test)


def best_of(compared: Sequence[Judgement]) -> Judgement:
    """The model with the least information criterion."""
    return min(compared, key=lambda one: one.delta_bic)


def at_noise(found: Refit, error: Error) -> bool:
    """Whether an error is as large as noise makes it, by the rules of `diagnose`.

    Parameters
    ----------
    found : Refit
        The model.
    error : Error
        Its error.
    """
    # Computed data have no scatter: their error is beyond any floor, and nothing is missing.
    if is_arithmetic(found):
        return True
    # Of so few numbers neither the error nor the floor is known.
    if is_hardly_known(found):
        return False
    return not beyond_floor(found) and not error.is_hardly_noise


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
        error = error_of(found, floors[effects_of(found)])
        yield Judgement(found, error, -2.0 * found.log_evidence - least, own_rng)


def material_floors(
    fits: Iterable[Refit], rng: np.random.Generator
) -> dict[Effects, MaterialFloor]:
    """The material floor for each set of effects, sought from the best of the fits with them."""
    alike: dict[Effects, list[Refit]] = {}
    for found in fits:
        alike.setdefault(effects_of(found), []).append(found)
    floors = {}
    for effects, group in alike.items():
        # The floor does not depend on the model, but the values of its effects begin where the best
        # fit ended.
        floors[effects] = material_floor(min(group, key=lambda one: one.rss), rng).beside(group)
    return floors


def effects_of(found: Refit) -> Effects:
    """Names of the effects of a fitted model."""
    return tuple(effect.name for effect in found.model.effects)


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
    # One noise for all, that of the model which leaves the least scatter: errors are then compared,
    # not noises.
    quiet = min(first, key=lambda fitted: fitted.floor)
    in_its_noise = []
    for fitted in first:
        # From where it ended: in another noise the minimum moves a little, and another one may be
        # the least.
        if fitted is not quiet:
            fitted = refit(fitted.model, quiet.data, quiet.noise, [fitted.theta], starts=STARTS)
        in_its_noise.append(fitted)
    return in_its_noise
