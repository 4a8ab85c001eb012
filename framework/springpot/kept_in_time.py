"""Answers on tests in time, taken up again from their JSON.

A fit still predicts. Of a diagnosis, a discovery and a comparison the file holds what they say, not
the fits behind.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any

from springpot.identification.value import Value, values_of
from springpot.plain_data import number
from springpot.registry import parse_model, plugins
from springpot.rheology.model import Model
from springpot.timetests.answer import TimeCandidate, TimeError, best_of, missing_of
from springpot.timetests.prediction import Known
from springpot.timetests.where import Place

from .kept_values import place


@dataclass(frozen=True, eq=False)
class KeptTimeFit(Known):
    """A fit of tests in time, as its file tells it.

    It predicts frequencies and further tests as before.
    """

    kept: Mapping[str, Any] = field(default_factory=dict)

    @property
    def parameters(self) -> dict[str, Value]:
        """Values and 95 % intervals as printed."""
        return values_of(self.kept["parameters"])

    def __getitem__(self, name: str) -> Value:
        """The parameter of that name."""
        return self.parameters[name]

    @property
    def tests(self) -> tuple[Mapping[str, Any], ...]:
        """Each test beside its noise floor, as in the file."""
        return tuple(self.kept["tests"])

    @property
    def relative_rms(self) -> float:
        """Error of the worst test."""
        return float(self.kept["relative_rms"])

    @property
    def notes(self) -> tuple[str, ...]:
        """What the numbers do not say."""
        return tuple(self.kept["notes"])

    def to_dict(self) -> dict[str, Any]:
        """Schema ``springpot.identification-in-time/1``, as in the file."""
        return dict(self.kept)

    def __repr__(self) -> str:
        # A number without a unit has a hyphen for it, which says nothing in a line.
        printed = [
            f"{name} {row.value:.4g} {row.unit}".rstrip(" -")
            for name, row in self.parameters.items()
        ]
        return f"<KeptTimeFit {self.model.name}: {', '.join(printed)}>"


@dataclass(frozen=True, eq=False)
class KeptTimeDiagnosis:
    """What is missing from a model of tests in time, as its file tells it.

    Names as in `TimeDiagnosis`.
    """

    data: str
    model: Model
    error: TimeError
    tests: tuple[Mapping[str, Any], ...]
    verdict: str
    where: tuple[Place, ...]
    candidates: tuple[TimeCandidate, ...]
    classes: tuple[tuple[str, ...], ...]
    says: str
    kept: Mapping[str, Any] = field(repr=False)

    @property
    def best(self) -> TimeCandidate | None:
        """The effect that should be added, if any."""
        return best_of(self.candidates)

    @property
    def missing(self) -> tuple[str, ...]:
        """The effects that may be missing, which these tests cannot tell apart.

        Empty where nothing is.
        """
        return missing_of(self.candidates)

    def to_dict(self) -> dict[str, Any]:
        """Schema ``springpot.diagnosis-in-time/1``, as in the file."""
        return dict(self.kept)

    def __repr__(self) -> str:
        return f"<KeptTimeDiagnosis {self.model.name}: {self.verdict}, {self.says}>"


@dataclass(frozen=True, eq=False)
class KeptTimeStep:
    """One rung of a discovery from tests in time; names as in `TimeStep`, and those of its fit."""

    model: Model
    accepted: str | None
    alike: tuple[str, ...]
    relative_rms: float
    over_floor: float
    tests: tuple[Mapping[str, Any], ...]
    parameters: Mapping[str, Value]


@dataclass(frozen=True, eq=False)
class KeptTimeLadder:
    """A discovery from tests in time, as its file tells it; names as in `TimeLadder`."""

    data: str
    steps: tuple[KeptTimeStep, ...]
    verdict: str
    diagnosis: KeptTimeDiagnosis
    kept: Mapping[str, Any] = field(repr=False)

    @property
    def model(self) -> Model:
        """The model of the last rung."""
        return self.steps[-1].model

    def to_dict(self) -> dict[str, Any]:
        """Schema ``springpot.discovery-in-time/1``, as in the file."""
        return dict(self.kept)

    def __repr__(self) -> str:
        errors = " -> ".join(f"{step.over_floor:.3g}" for step in self.steps)
        return (
            f"<KeptTimeLadder {self.model.name} of {self.data}: error {errors} x floor;"
            f" {self.verdict}>"
        )


@dataclass(frozen=True, eq=False)
class KeptTimeJudgement:
    """One model against tests in time, as the file tells it."""

    model: Model
    delta_bic: float
    relative_rms: float
    tests: tuple[Mapping[str, Any], ...]
    parameters: Mapping[str, Value]
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class KeptTimeComparison:
    """Models against the same tests in time, as their file tells it, the best first."""

    data: str
    judgements: tuple[KeptTimeJudgement, ...]
    left_out: Mapping[str, str]
    kept: Mapping[str, Any] = field(repr=False)

    @property
    def best(self) -> KeptTimeJudgement:
        """The model that was best."""
        return self.judgements[0]

    def to_dict(self) -> dict[str, Any]:
        """Schema ``springpot.comparison-in-time/1``, as in the file."""
        return dict(self.kept)

    def __repr__(self) -> str:
        ranked = ", ".join(f"{one.model.name} +{one.delta_bic:.3g}" for one in self.judgements)
        return f"<KeptTimeComparison of {self.data}, by BIC: {ranked}>"


def fit_in_time(answer: dict[str, Any]) -> KeptTimeFit:
    """A fit, from what it wrote."""
    model = parse_model(str(answer["model"]))
    # What the test itself did is no part of what another test is predicted from.
    known = Known.read(answer, model.of_specimen)
    # Not by `asdict`, which would make dictionaries of model and units too.
    own = {each.name: getattr(known, each.name) for each in fields(known)}
    return KeptTimeFit(**own, kept=answer)


def diagnosis_in_time(answer: Mapping[str, Any]) -> KeptTimeDiagnosis:
    """A diagnosis, from what it wrote."""
    return KeptTimeDiagnosis(
        data=answer["data"],
        model=parse_model(answer["model"]),
        error=_error(answer["error"]),
        tests=tuple(answer["tests"]),
        verdict=answer["verdict"],
        where=tuple(place(Place, row) for row in answer["where"]),
        candidates=tuple(_candidate(row) for row in answer["candidates"]),
        classes=_names(answer["classes"]),
        says=answer["says"],
        kept=answer,
    )


def ladder_in_time(answer: Mapping[str, Any]) -> KeptTimeLadder:
    """A discovery, from what it wrote."""
    steps = tuple(_step(row) for row in answer["steps"])
    return KeptTimeLadder(
        answer["data"], steps, answer["verdict"], diagnosis_in_time(answer["diagnosis"]), answer
    )


def comparison_in_time(answer: Mapping[str, Any]) -> KeptTimeComparison:
    """A comparison, from what it wrote."""
    judgements = tuple(_judgement(row) for row in answer["models"])
    return KeptTimeComparison(answer["data"], judgements, dict(answer["left_out"]), answer)


def _step(row: Mapping[str, Any]) -> KeptTimeStep:
    return KeptTimeStep(
        model=parse_model(row["model"]),
        accepted=row["accepted"],
        alike=tuple(row["class"]),
        relative_rms=number(row["relative_rms"]),
        over_floor=number(row["over_floor"]),
        tests=tuple(row["tests"]),
        parameters=values_of(row["parameters"]),
    )


def _judgement(row: Mapping[str, Any]) -> KeptTimeJudgement:
    return KeptTimeJudgement(
        model=parse_model(row["model"]),
        delta_bic=number(row["delta_bic"]),
        relative_rms=number(row["relative_rms"]),
        tests=tuple(row["tests"]),
        parameters=values_of(row["parameters"]),
        notes=tuple(row["notes"]),
    )


def _names(classes: Sequence[Sequence[str]]) -> tuple[tuple[str, ...], ...]:
    return tuple(tuple(names) for names in classes)


def _error(row: Mapping[str, Any]) -> TimeError:
    return TimeError(
        number(row["relative_rms"]),
        number(row["noise_floor"]),
        number(row["over_floor"]),
        number(row["noise_memory"]),
        row["noise_source"],
    )


def _candidate(row: Mapping[str, Any]) -> TimeCandidate:
    name = row["effect"]
    return TimeCandidate(
        effect=name,
        # A class begins with the effect itself.
        alike=tuple(row["class"][1:]),
        probability=row["probability"],
        delta_bic=number(row["delta_bic"]),
        over_floor=number(row["over_floor"]),
        parameters=row["parameters"],
        verdict=row["verdict"],
        says=row["says"],
        physics=plugins().effect(name),
    )
