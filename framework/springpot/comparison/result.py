"""What is said of models beside one set of data and one noise floor."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple, Protocol, Self

import numpy as np

from springpot.diagnosis.ladder import Ladder
from springpot.identification.held_material import parameters_of
from springpot.identification.material import is_material
from springpot.identification.value import PartResult, Value, parts_of, values_of
from springpot.lazy import Drawn, Printed
from springpot.measurement.measurement import Measurement
from springpot.misfit.error import Error, over_floor, percent, times
from springpot.misfit.floor import beyond_floor, is_arithmetic, is_hardly_known
from springpot.misfit.material import MaterialFloor, error_of
from springpot.misfit.refit import Refit
from springpot.misfit.residual_tests import Battery, Finding, battery
from springpot.misfit.where import Where, where
from springpot.plain_data import alive, json_number, jsonable, some
from springpot.registry import parse_model
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.thresholds import COMPARISON, VERDICT
from springpot.writing import FEW, NAMED

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
ONLY_NOISE = "nothing is left but noise"
"""What is said of a model beside which no pattern is left."""
UNCLEAR = "what is left has no pattern: these data cannot tell whether something is missing"
"""What is said of a model that is far from the noise, and no test says how."""

LOOKED_AT = 20
"""Of the others, how many are looked at for these."""


class RankedFit(Protocol):
    """A fit of a sweep or of tests in time, in units of a noise that all models share."""

    @property
    def model(self) -> Model:
        """What was fitted."""

    @property
    def theta(self) -> Real:
        """Its parameters, shape (p,)."""

    @property
    def rss(self) -> float:
        """Sum of squares of the residual over the noise."""

    @property
    def dof(self) -> float:
        """Numbers that its parameters do not follow."""

    @property
    def numbers(self) -> float:
        """How many numbers it was judged by, those counted once whose noise is alike."""

    @property
    def noise_dof(self) -> float:
        """Degrees of freedom of the noise."""

    @property
    def floor(self) -> float:
        """The relative error that noise alone leaves."""

    @property
    def least_error(self) -> float:
        """Below which its relative error is not."""

    @property
    def relative_rms(self) -> float:
        """Above which it is not."""

    @property
    def log_evidence(self) -> float:
        """Minus half the Bayesian information criterion, but for what all models share."""

    @property
    def curve(self) -> Real:
        """What it says of each number over the noise, but for what all models share, shape (m,)."""


def _least_error(judged: Iterable[Judgement]) -> float:
    """The least error of some models: it takes a search of those alone whose fit leaves it open."""
    least = np.inf
    for one in sorted(judged, key=lambda one: one.least_error):
        if one.least_error >= least:
            break
        least = min(least, one.error.relative_rms)
    return least


@dataclass(frozen=True, eq=False)
class Judgement:
    """One model against the data.

    Attributes
    ----------
    fitted : Refit, Identification or None
        Its fit, in units of the noise, of tests in time with all that it found; a file does not
        hold it.
    floor : MaterialFloor, optional
        Any material with the same effects.
    delta_bic : float
        Bayesian information criterion above that of the best model compared.
    rng : numpy.random.Generator, optional
        For the simulated noise of its tests, which are made when they are asked for.
    """

    fitted: object | None
    floor: MaterialFloor | None
    delta_bic: float
    rng: np.random.Generator | None = None

    @property
    def refit(self) -> Refit:
        """Its fit, in units of the noise."""
        return alive(self.fitted, Refit, "a judgement")

    @cached_property
    def ranked(self) -> RankedFit:
        """Its fit, as models are put in order by it."""
        return self.refit

    @cached_property
    def error(self) -> Error:
        """Its error, the noise floor and the material floor, relative to |K|."""
        # It takes a search of its own: of many models that fail nobody asks for it.
        return error_of(self.refit, alive(self.floor, MaterialFloor, self.model.name))

    @property
    def least_error(self) -> float:
        """Below which its error is not: that itself, where it is known."""
        if "error" in vars(self):
            return self.error.relative_rms
        return self.ranked.least_error

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
        return parameters_of(self.refit.known)

    @cached_property
    def fails(self) -> bool:
        """Whether it leaves more than noise, by the tests that `diagnose` makes too."""
        # What rounding leaves of computed data is full of patterns, and nothing is missing.
        if self.computed:
            return False
        return self.battery.alarm

    @cached_property
    def unclear(self) -> bool:
        """Whether it is far from the noise, and no test says how.

        Or the noise is larger than one may believe.
        """
        return not self.fails and not self.at_noise

    @cached_property
    def at_noise(self) -> bool:
        """Whether its error is as large as noise makes it.

        What pattern it has, is another question.
        """
        return at_noise(self.refit)

    @cached_property
    def beyond(self) -> bool:
        """Whether its error is beyond what noise makes of it by more than chance."""
        return beyond_floor(self.refit)

    @cached_property
    def computed(self) -> bool:
        """Whether its error is that of arithmetic: the data were computed."""
        return is_arithmetic(self.refit)

    @property
    def adequate(self) -> bool:
        """Whether its error is that of noise in size and in pattern, by the rules of `diagnose`."""
        # By size first, which costs nothing: the tests draw thousands of simulated residuals.
        return self.at_noise and not self.fails

    @cached_property
    def says(self) -> str:
        """The judgement in one sentence."""
        if self.computed:
            return (
                f"error {percent(self.error.relative_rms)}: that of arithmetic,"
                " and nothing is missing"
            )
        ratio = f"error {percent(self.error.relative_rms)}, without a noise floor"
        if self.error.noise_floor > 0.0:
            ratio = (
                f"error {times(self.error.relative_rms / self.error.noise_floor)} the noise floor"
            )
        if self.unclear and self.error.is_hardly_noise and not self.beyond:
            return f"{ratio}; nothing is left but noise, but {self.error.advice}"
        # Before "nothing is left but noise", which no error beyond the floor may be called.
        if self.unclear:
            return f"{ratio}; {UNCLEAR}"
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
            "chi_square": json_number(row["chi_square"]),
            "parameters": values_of(row["parameters"]),
            "notes": tuple(row["notes"]),
            "by_test": parts_of(row["by_test"]),
            "where": tuple(Where.from_dict(each) for each in row["where"]),
            "findings": tuple(Finding.from_dict(each) for each in row["tests"]),
        }
        error = Error.from_dict(row["error"])
        return cls.told(None, error, json_number(row["delta_bic"]), told)

    @classmethod
    def told(
        cls, fitted: object | None, error: Error, delta_bic: float, known: Mapping[str, Any]
    ) -> Judgement:
        """One of which all is known that its fit would be asked for."""
        judged = cls(fitted, None, delta_bic)
        # Where a fit keeps what it was asked for once.
        vars(judged).update(known, error=error)
        return judged


@dataclass(frozen=True, eq=False)
class Comparison(Drawn, Printed):
    """Several models against the same data.

    Its picture has data and models in the views that rheologists use, and what is left; of a
    ranking those models that `shown` names.

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
        most = VERDICT.agrees * _least_error(written)
        simpler = (one for one in written if one.free_parameters < self.best.free_parameters)
        near = [
            one for one in simpler if one.least_error <= most and one.error.relative_rms <= most
        ]
        return min(
            near, key=lambda one: (one.free_parameters, one.error.relative_rms), default=None
        )

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
        """What errors are shares of, such as |K|, or the signal of tests in time."""
        if isinstance(self.judgements[0].fitted, Refit):
            return self.measurement.units.magnitude
        return "the signal"

    @cached_property
    def measurement(self) -> Measurement:
        """The data, repeats averaged, with the standard deviations of the noise floor."""
        found = self.judgements[0].refit
        return replace(found.data.mean, sd=found.noise.sd)

    def __repr__(self) -> str:
        errors = ", ".join(
            f"{one.model.name} {over_floor(one.error.relative_rms, one.error.noise_floor)} x floor"
            for one in self.shown
        )
        return f"<Comparison of {self.data}: {errors}>"

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


def best_of(compared: Sequence[Judgement]) -> Judgement:
    """The model with the least information criterion."""
    return min(compared, key=lambda one: one.delta_bic)


def at_noise(found: Refit) -> bool:
    """Whether the error of a model is as large as noise makes it, by the rules of `diagnose`."""
    # Computed data have no scatter: their error is beyond any floor, and nothing is missing.
    if is_arithmetic(found):
        return True
    # Of so few numbers neither the error nor the floor is known.
    if is_hardly_known(found) or beyond_floor(found):
        return False
    # The fit by the noise leaves no less than the search does whose error is printed: that is dear.
    return not (
        _is_hardly_noise(found, found.relative_rms) and _is_hardly_noise(found, found.error)
    )


def _is_hardly_noise(found: Refit, error: float) -> bool:
    return Error(error, found.floor, found.noise.source).is_hardly_noise


class Skipped(NamedTuple):
    """A model that these data cannot judge, and why."""

    model: str
    reason: str


@dataclass(frozen=True, eq=False, repr=False)
class Ranking(Comparison):
    """All installed models: the simplest adequate one first, the inadequate by their evidence.

    Attributes
    ----------
    ladder : Ladder
        The discovery from any material: what was accepted beside every model.
    adequate : tuple of Judgement
        Models beside which no material does better than noise allows and which leave no more than
        noise, those with the fewest parameters first.
    near : tuple of Judgement
        Models beside which no material does better either, where any material leaves more than
        noise.
    skipped : tuple of Skipped
        Models that were not fitted.

    Examples
    --------
    >>> import numpy as np, springpot
    >>> from springpot.comparison import rank
    >>> rng, omega = np.random.default_rng(1), np.geomspace(1.0, 100.0, 20)
    >>> exact = 100.0 + 5j * omega - 0.02 * omega**2
    >>> noise = 0.01 * rng.normal(size=(2, 20))
    >>> data = springpot.Measurement(omega, exact * (1 + noise[0] + 1j * noise[1]))
    >>> models = [springpot.parse_model(name) for name in ("kelvin", "zener", "maxwell")]
    >>> ranking = rank(data, models, [springpot.plugins().effect("inertia")], rng)
    >>> [judged.model.name for judged in ranking.adequate]
    ['kelvin + inertia', 'zener + inertia']
    """

    ladder: Ladder
    adequate: tuple[Judgement, ...]
    near: tuple[Judgement, ...]
    skipped: tuple[Skipped, ...]

    @property
    def best(self) -> Judgement:
        """The simplest adequate model, or the simplest near one.

        Else that with the least information criterion.
        """
        return self.judgements[0]

    @cached_property
    def groups(self) -> tuple[tuple[Judgement, ...], ...]:
        """Adequate and near models, grouped where the noise cannot tell their curves apart."""
        return (*grouped(self.adequate), *grouped(self.near))

    @cached_property
    def next(self) -> tuple[Judgement, ...]:
        """The best of those that are not adequate, one of each kind of curve."""
        nearest = self.judgements[len(self.adequate) + len(self.near) :][:LOOKED_AT]
        return tuple(group[0] for group in grouped(nearest)[:NAMED])

    @property
    def shown(self) -> tuple[Judgement, ...]:
        """One of each group, and the best of those that are not adequate."""
        return (*(group[0] for group in self.groups), *self.next)[:FEW]

    @cached_property
    def says(self) -> str:
        """The answer in one sentence."""
        name = self.best.model.name
        if self.adequate:
            return (
                f"the simplest model that follows these data as well as any material does is {name}"
            )
        if self.near and self.best.beyond:
            return (
                f"{name} is as near as any linear material, but not at the noise: what is missing"
                " is no part of the material"
            )
        if self.near and self.best.error.is_hardly_noise:
            return f"{name} is as near as any linear material, but {self.best.error.advice}"
        # As large as noise, and no noise by its pattern, or of too few numbers to tell.
        if self.near:
            return f"{name} is as near as any linear material: {self.best.says}"
        return (
            "no installed model follows these data as well as any material does; the nearest is"
            f" {name}"
        )

    def to_dict(self) -> dict[str, Any]:
        """Schema ``springpot.comparison/2``, with the ranking."""
        last = self.ladder.steps[-1]
        return {
            **super().to_dict(),
            "ranking": {
                "says": self.says,
                "accepted": [effect.name for effect in last.model.effects],
                "material": last.to_dict(),
                "adequate": [one.model.name for one in self.adequate],
                "near": [one.model.name for one in self.near],
                "classes": [[one.model.name for one in group] for group in self.groups],
                "next": [one.model.name for one in self.next],
                "skipped": [one._asdict() for one in self.skipped],
                "discovery": self.ladder.to_dict(),
            },
        }

    @classmethod
    def from_dict(cls, answer: Mapping[str, Any]) -> Self:
        """What `to_dict` gave."""
        ranking, kept = super().from_dict(answer), answer["ranking"]
        judged = {one.model.name: one for one in ranking.judgements}
        # Curves that are told apart by their fits.
        groups = tuple(tuple(judged[name] for name in names) for names in kept["classes"])
        following = tuple(judged[name] for name in kept["next"])
        vars(ranking).update(next=following, groups=groups, says=kept["says"])
        return ranking

    @classmethod
    def further(cls, answer: Mapping[str, Any], judged: Mapping[str, Judgement]) -> dict[str, Any]:
        """The discovery behind a ranking, and its models by their merit."""
        kept = answer["ranking"]
        return {
            "ladder": Ladder.from_dict(kept["discovery"]),
            "adequate": tuple(judged[name] for name in kept["adequate"]),
            "near": tuple(judged[name] for name in kept["near"]),
            "skipped": tuple(Skipped(**row) for row in kept["skipped"]),
        }


def grouped(judgements: Sequence[Judgement]) -> tuple[tuple[Judgement, ...], ...]:
    """Models in order, each with the later ones whose curves the noise cannot tell from its own."""
    groups: list[list[Judgement]] = []
    # Against the first of each group only, or a chain of close neighbours would join curves that
    # are far apart.
    for one in judgements:
        known = next(
            (group for group in groups if _distance(group[0], one) < COMPARISON.alike),
            None,
        )
        if known is None:
            groups.append([one])
        else:
            known.append(one)
    return tuple(map(tuple, groups))


def _distance(one: Judgement, other: Judgement) -> float:
    """Standard deviations of the noise between two fitted curves, over all points together."""
    return float(np.linalg.norm(one.ranked.curve - other.ranked.curve))
