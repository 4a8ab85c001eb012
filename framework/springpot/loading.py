"""``springpot.load``: what springpot wrote as JSON, taken up again.

A fit is whole again: it predicts, draws and tells its intervals as before. Of a discovery and a
comparison the file holds what they say, not the fits behind it, and so do `KeptLadder` and
`KeptComparison`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from springpot.diagnosis.result import Candidate, Diagnosis, NextExperiment
from springpot.drawing import draw
from springpot.errors import DataError, ModelError
from springpot.identification.kept import fit_of, measurement_of, uncertainty_of
from springpot.identification.objective import Objective, default_objective
from springpot.identification.result import Identification
from springpot.inputs import json_of, text_in
from springpot.misfit.error import Error
from springpot.misfit.values import Value
from springpot.misfit.where import Where
from springpot.misfit.words import over_floor
from springpot.registry import parse_model, plugins
from springpot.rheology.model import Model

from .judgement import standing_of
from .kept_in_time import (
    KeptTimeComparison,
    KeptTimeDiagnosis,
    KeptTimeFit,
    KeptTimeLadder,
    comparison_in_time,
    diagnosis_in_time,
    fit_in_time,
    ladder_in_time,
)
from .kept_values import number, place, values

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


SHOWN = 3
"""Models of a comparison that its line names."""
AGAIN = "give the output of a command of springpot with --json"


@dataclass(frozen=True, eq=False)
class KeptStep:
    """One rung of a discovery, as its file tells it; names as in `springpot.diagnosis.Step`."""

    model: Model
    accepted: str | None
    relative_rms: float
    noise_floor: float
    material_floor: float
    predicted_error: float | None
    parameters: Mapping[str, Value]
    changed: Mapping[str, float]
    alike: tuple[str, ...]

    def __repr__(self) -> str:
        return (
            f"<Step {self.model.name}:"
            f" error {over_floor(self.relative_rms, self.noise_floor)} x floor>"
        )


@dataclass(frozen=True, eq=False)
class KeptLadder:
    """A discovery, as its file tells it; names as in `springpot.diagnosis.Ladder`."""

    data: str
    steps: tuple[KeptStep, ...]
    verdict: str
    diagnosis: Diagnosis
    kept: Mapping[str, Any]

    @property
    def model(self) -> Model:
        """The model of the last rung."""
        return self.steps[-1].model

    def plot(
        self, path: str | Path | None = None, *, ax: Axes | None = None
    ) -> Figure | Axes | Path:
        """The error falling to the noise floor; see `springpot.drawing.draw`."""
        return draw(self, path, ax)

    def to_dict(self) -> dict[str, Any]:
        """Schema ``springpot.discovery/1``, as in the file."""
        return dict(self.kept)

    def __repr__(self) -> str:
        errors = " -> ".join(over_floor(step.relative_rms, step.noise_floor) for step in self.steps)
        return (
            f"<KeptLadder {self.model.name} of {self.data}: error {errors} x floor; {self.verdict}>"
        )


@dataclass(frozen=True, eq=False)
class KeptJudgement:
    """One model against the data, as its file tells it.

    Names as in `springpot.comparison.Judgement`.
    """

    model: Model
    error: Error
    delta_bic: float
    fails: bool
    says: str
    parameters: Mapping[str, Value]
    where: tuple[Where, ...]

    def __repr__(self) -> str:
        return (
            f"<{self.model.name}:"
            f" {over_floor(self.error.relative_rms, self.error.noise_floor)} x floor>"
        )


@dataclass(frozen=True, eq=False)
class KeptComparison:
    """Models against the same data, as their file tells it.

    Names as in `springpot.comparison.Comparison`.
    """

    data: str
    judgements: tuple[KeptJudgement, ...]
    notes: tuple[str, ...]
    kept: Mapping[str, Any]

    @property
    def best(self) -> KeptJudgement:
        """The model that was best."""
        return next(one for one in self.judgements if one.model.name == self.kept["best"])

    def to_dict(self) -> dict[str, Any]:
        """Schema ``springpot.comparison/1``, as in the file."""
        return dict(self.kept)

    def __repr__(self) -> str:
        shown = ", ".join(repr(one) for one in self.judgements[:SHOWN])
        if len(self.judgements) > SHOWN:
            shown += f", and {len(self.judgements) - SHOWN} more"
        return f"<KeptComparison of {self.data}: {shown}>"


Loaded: TypeAlias = (
    Identification
    | Diagnosis
    | KeptLadder
    | KeptComparison
    | KeptTimeFit
    | KeptTimeDiagnosis
    | KeptTimeLadder
    | KeptTimeComparison
)


def load(path: str | Path) -> Loaded:
    """What a command or `to_dict` wrote as JSON: a fit, a diagnosis, a discovery or a comparison.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    Identification, Diagnosis, KeptLadder or KeptComparison
        By the schema that the file names; of tests in time a KeptTimeFit, KeptTimeDiagnosis,
        KeptTimeLadder or KeptTimeComparison.

    Raises
    ------
    DataError
        If the file cannot be read or holds none of these.
    ModelError
        If a model or effect in it is not installed.

    Examples
    --------
    >>> import json, springpot
    >>> fit = springpot.identify("artificial-hidden", "fractional-maxwell + inertia + time-delay")
    >>> with open("fit.json", "w") as file:
    ...     json.dump(fit.to_dict(), file)
    >>> springpot.load("fit.json")["inertia.m"] == fit["inertia.m"]
    True
    """
    answer = _read(Path(path))
    schema = None
    # Other JSON may be a list or a number.
    if isinstance(answer, dict):
        schema = answer.get("schema")
    if not isinstance(schema, str) or schema not in _KNOWN:
        raise DataError(
            f"{path} holds no answer that can be loaded ({schema or 'no schema'}): {AGAIN}"
        )
    try:
        return _KNOWN[schema](answer)
    except (DataError, ModelError) as error:
        raise type(error)(f"{path}: {error}") from None
    # A file that was cut off or edited by hand fails anywhere: to its user these are one fault.
    except (KeyError, TypeError, ValueError, AttributeError, IndexError, OverflowError) as error:
        raise DataError(
            f"{path} is damaged or of an older version ({type(error).__name__}: {error}): {AGAIN}"
        ) from None


def _read(path: Path) -> Any:
    try:
        return json_of(text_in(path), finite=True)
    except ValueError as error:
        why = getattr(error, "msg", error)
        raise DataError(
            f"{path} is no JSON ({why}): {AGAIN}; data are opened by springpot.read"
        ) from None


def _fit(answer: dict[str, Any]) -> Identification:
    kept, objective = answer["kept"], answer["objective"]
    fit = fit_of(
        kept,
        model=parse_model(answer["model"]),
        objective=_objective(objective["name"], kept),
        cost=number(objective["value"]),
        evaluations=int(answer["evaluations"]),
    )
    uncertainty, low, high = uncertainty_of(kept, fit)
    return Identification(
        fit,
        low,
        high,
        uncertainty,
        optimiser=str(answer["optimiser"]),
        status=str(answer["status"]),
        evaluations=fit.evaluations,
        seconds=float(answer["seconds"]),
        notes=tuple(answer["notes"]),
        seed=int(kept["seed"]),
        # Floors are found when they are asked for, as those of a fit that was just made.
        judge=standing_of,
    )


def _objective(name: str, kept: dict[str, Any]) -> Objective:
    # The objective that is taken where none is named need not be a plugin's, so it comes first.
    standard = default_objective(measurement_of(kept["measurement"]))
    if standard.name == name:
        return standard
    objective: Objective = plugins().find("objective", name)
    return objective


def _diagnosis(answer: dict[str, Any]) -> Diagnosis:
    advice = answer["next_experiment"]
    if advice is not None:
        # JSON has lists only.
        separates = tuple(advice["separates"])
        advice = NextExperiment(**(advice | {"separates": separates}))
    return Diagnosis(
        data=answer["data"],
        model=parse_model(answer["model"]),
        error=_error(answer["error"]),
        verdict=answer["verdict"],
        says=answer["says"],
        split=answer["split"],
        where=tuple(place(Where, row) for row in answer["where"]),
        candidates=tuple(_candidate(row) for row in answer["candidates"]),
        classes=tuple(tuple(names) for names in answer["classes"]),
        next_experiment=advice,
        notes=tuple(answer["notes"]),
        evidence=answer["evidence"],
        # Files of older versions have none of these three.
        parameters=values(answer.get("parameters", {})),
        leading=tuple(answer.get("leading", ())),
        one_test=answer.get("one_test", ""),
    )


def _error(row: dict[str, Any]) -> Error:
    return Error(**row)


def _candidate(row: dict[str, Any]) -> Candidate:
    # What could not be computed was infinite, for which JSON has no word: no evidence at all, no
    # bound at all.
    delta_bic, bound = row["delta_bic"], row["bound"]
    if delta_bic is None:
        delta_bic = -inf
    if bound is None:
        bound = inf
    return Candidate(
        physics=plugins().effect(row["effect"]),
        alike=tuple(row["class"]),
        probability=row["probability"],
        delta_bic=delta_bic,
        score=number(row["score"]),
        verdict=row["verdict"],
        predicted_error=number(row["predicted_error"]),
        error_after=number(row["error_after"]),
        bound=bound,
        parameters=values(row["parameters"]),
        says=row["says"],
    )


def _ladder(answer: dict[str, Any]) -> KeptLadder:
    steps = tuple(_step(row) for row in answer["steps"])
    return KeptLadder(
        answer["data"], steps, answer["verdict"], _diagnosis(answer["diagnosis"]), answer
    )


def _comparison(answer: dict[str, Any]) -> KeptComparison:
    judgements = tuple(_judgement(row) for row in answer["models"])
    return KeptComparison(answer["data"], judgements, tuple(answer["notes"]), answer)


def _step(row: dict[str, Any]) -> KeptStep:
    return KeptStep(
        model=parse_model(row["model"]),
        accepted=row["accepted"],
        relative_rms=row["relative_rms"],
        noise_floor=row["noise_floor"],
        material_floor=row["material_floor"],
        predicted_error=row["predicted_error"],
        parameters=values(row["parameters"]),
        changed=row["changed"],
        alike=tuple(row["class"]),
    )


def _judgement(row: dict[str, Any]) -> KeptJudgement:
    return KeptJudgement(
        model=parse_model(row["model"]),
        error=_error(row["error"]),
        delta_bic=number(row["delta_bic"]),
        fails=row["fails"],
        says=row["says"],
        parameters=values(row["parameters"]),
        where=tuple(place(Where, each) for each in row["where"]),
    )


# At the end, as it holds the functions above. The number is that of the schema: a change of it is
# another reader.
_KNOWN: dict[str, Callable[[dict[str, Any]], Loaded]] = {
    "springpot.identification/1": _fit,
    "springpot.diagnosis/1": _diagnosis,
    "springpot.discovery/1": _ladder,
    "springpot.comparison/1": _comparison,
    "springpot.identification-in-time/1": fit_in_time,
    "springpot.diagnosis-in-time/1": diagnosis_in_time,
    "springpot.discovery-in-time/1": ladder_in_time,
    "springpot.comparison-in-time/1": comparison_in_time,
}
