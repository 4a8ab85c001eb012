"""The ladder: effects accepted one after the other, and the error falling to the noise floor.

With all that a diagnosis of a sweep found, for those who go on from it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice, zip_longest
from math import isfinite, isnan
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, Protocol, TypeAlias, TypeVar

import numpy as np

from springpot.errors import ModelError, SpringpotError
from springpot.identification.native import FittedModel
from springpot.identification.space import require_conditions
from springpot.identification.uncertainty import Uncertainty
from springpot.identification.value import PartResult, Value, in_floors, parts_of
from springpot.lazy import Drawn, Printed
from springpot.measurement.opening import Test
from springpot.misfit.drift_search import Course
from springpot.misfit.error import over_floor
from springpot.misfit.material import MaterialFloor
from springpot.misfit.outliers import Outlier
from springpot.misfit.refit import Refit
from springpot.plain_data import alive, jsonable, read, some
from springpot.registry import parse_model
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.thresholds import VERDICT

from .grown import Search, Untold, key_of
from .in_practice import Accuracy
from .result import (
    SEEN,
    Candidate,
    Diagnosis,
    Fitted,
    NextExperiment,
    Progress,
    Verdict,
    silent,
    unseen,
    within,
)
from .scan import scan_effects

if TYPE_CHECKING:
    from .evidence import Evidence


class GrownBy(NamedTuple):
    """A model with one more effect.

    Attributes
    ----------
    model : Model
        The grown model.
    theta : ndarray, shape (p,)
        Its parameters.
    refitted : bool
        Whether it was fitted with the effect; else the effect stands where the scan puts it, and
        the rest as before.
    """

    model: Model
    theta: Real
    refitted: bool


class Examined(Protocol):
    """A model that was examined, on tests of whatever kind."""

    @property
    def diagnosis(self) -> Diagnosis:
        """What is said of it."""

    @property
    def base(self) -> FittedModel:
        """The fit that was judged."""

    @property
    def tests(self) -> Sequence[Test]:
        """What it was fitted to."""

    @property
    def correlated(self) -> tuple[Model, Real]:
        """The model whose parameters are told, and the correlations (p, p) of these."""

    @property
    def untold(self) -> Untold | None:
        """Effects of an amplitude that no column tells, which may stand in a named one's place."""

    def grown_with(self, effect: Effect) -> GrownBy:
        """The model as accepting one effect would make it, without a new fit."""


@dataclass(frozen=True, eq=False)
class Case:
    """All that a diagnosis of a sweep found, for those who go on from it.

    Attributes
    ----------
    search : Search
        Fits and scans of the model.
    naming : Search
        Those by which effects are named: of the model, or of any material where the model does not
        follow it.
    floor : MaterialFloor
        The least error that any material reaches.
    evidence : Evidence
        Of every effect.
    outliers : tuple of Outlier
        Points set aside.
    diagnosis : Diagnosis
        The answer.
    course : Course or None
        How the specimen changed with time, where that is what the misfit goes with.
    drawn : mapping or None
        State of the generator of simulated noise after it, from which a further rung goes on.
    """

    search: Search
    naming: Search
    floor: MaterialFloor
    evidence: Evidence
    outliers: tuple[Outlier, ...]
    diagnosis: Diagnosis
    course: Course | None = None
    drawn: Mapping[str, Any] | None = None

    def __repr__(self) -> str:
        return f"<Case {self.diagnosis!r:.200}>"

    @property
    def base(self) -> Refit:
        """The fit that was judged."""
        return self.search.base

    @property
    def tests(self) -> Sequence[Test]:
        """The sweep, without what was set aside."""
        return [self.base.data.raw]

    @property
    def correlated(self) -> tuple[Model, Real]:
        """As the model is identified: its lines may be others where the material is free."""
        fit = self.base.identified
        return fit.model, Uncertainty.of(fit).correlation

    @property
    def untold(self) -> Untold | None:
        """Effects of an amplitude that no column tells, which may stand in a named one's place."""
        return self.evidence.untold

    def grown_with(self, effect: Effect) -> GrownBy:
        """The model as accepting one effect would make it, without a new fit.

        Parameters
        ----------
        effect : Effect
            Scanned or not: the ``physics`` of a candidate, or any other.

        Raises
        ------
        ModelError
            If the model cannot take the effect, the data lack a column that it needs, or nothing is
            known of it.

        Examples
        --------
        >>> import springpot
        >>> ladder = springpot.discover("artificial-hidden", "fractional-maxwell", accept="inertia")
        >>> case = ladder.steps[0].case
        >>> grown = case.grown_with(case.diagnosis.best.physics)
        >>> grown.model.name, grown.refitted
        ('fractional-maxwell + inertia', True)
        """
        base = self.search.base
        # A fit that was made is better than what the scan foretells of it.
        for grown in self.search.grown:
            if grown.names == (effect.name,):
                return GrownBy(grown.refit.identified.model, grown.refit.identified.theta, True)
        if effect.by_levels:
            raise ModelError(
                f"{effect.name} has a factor for each level, which only a fit can tell"
            )
        if not effect.element.parameters:
            raise ModelError(f"{effect.name} has no parameter, and nothing of it can be fitted")
        require_conditions(base.model + effect, base.fit.measurement)
        scores = [score for score in self.search.scan.scores if score.influence.effect == effect]
        for score in scores or scan_effects(base, self.search.frame, [effect]).scores:
            for theta in score.starts[:1]:
                return GrownBy(score.influence.model, theta, False)
        raise ModelError(f"{effect.name} changes nothing that these data show of {base.model.name}")


LONGEST = 6
"""Effects accepted at most."""
SCHEMA = "springpot.discovery/2"


@dataclass(frozen=True, eq=False)
class Step:
    """One rung: a model, what was accepted to reach it, and its error against the floor.

    Attributes
    ----------
    model : Model
        The model of this rung.
    accepted : str or None
        The effect that was added, None for the first rung.
    relative_rms, noise_floor, material_floor : float
        Relative error, what noise alone leaves, and the least that any material reaches with the
        same effects.
    predicted_error : float or None
        What the rung before foretold.
    parameters : dict of str to Value
        All parameters with their intervals.
    changed : dict of str to float
        Old parameters that moved by more than their interval, with the ratio new over old.
    material_chance : float
        That noise alone leaves a residual like that material's.
    tests : tuple of PartResult
        Each test beside its noise floor.
    alike : tuple of str
        Effects that the data could not tell from the accepted one, itself included.
    examined : Examined, optional
        The examination of this rung's model; a file does not hold it.
    test : str, optional
        The test of which errors and floors are told, the one missed most, where there are several.
    next_experiment : NextExperiment, optional
        What would tell apart the effects that may be missing from this rung's model.
    """

    model: Model
    accepted: str | None
    relative_rms: float
    noise_floor: float
    material_floor: float
    predicted_error: float | None
    parameters: Mapping[str, Value]
    changed: dict[str, float]
    material_chance: float
    tests: tuple[PartResult, ...]
    alike: tuple[str, ...] = ()
    examined: Examined | None = None
    test: str = ""
    next_experiment: NextExperiment | None = None

    @property
    def over_floor(self) -> float:
        """The error in noise floors."""
        return in_floors(self.relative_rms, self.noise_floor)

    @property
    def case(self) -> Case:
        """The examination of this rung's model: fit, noise, scan and diagnosis."""
        return alive(self.examined, Case, f"the step {self.model.name}")

    @property
    def diagnosis(self) -> Diagnosis:
        """What is said of this rung's model."""
        assert self.examined is not None
        return self.examined.diagnosis

    def __repr__(self) -> str:
        return (
            f"<Step {self.model.name}: error {over_floor(self.relative_rms, self.noise_floor)} x"
            " floor>"
        )

    def to_dict(self) -> dict[str, Any]:
        """As in the schema."""
        row = {
            "model": self.model.name,
            "accepted": self.accepted,
            "relative_rms": self.relative_rms,
            "noise_floor": self.noise_floor,
            "over_floor": self.over_floor,
            "material_floor": self.material_floor,
            "predicted_error": self.predicted_error,
            "material_chance": self.material_chance,
            "class": self.alike,
            "parameters": self.parameters,
            "changed": self.changed,
            "tests": self.tests,
            "next_experiment": self.next_experiment,
        }
        if self.test:
            row["test"] = self.test
        return dict(jsonable(row))

    @classmethod
    def from_dict(cls, row: Mapping[str, Any]) -> Step:
        """What `to_dict` gave."""
        model, tests = parse_model(row["model"]), parts_of(row["tests"])
        return read(cls, row, model=model, tests=tests, alike=tuple(row["class"]))


@dataclass(frozen=True, eq=False)
class Ladder(Drawn, Printed):
    """Steps from the user's model to the last accepted one, with the last diagnosis.

    Its picture is the error that falls to the noise floor.

    Attributes
    ----------
    data : str
        What was measured.
    steps : tuple of Step
        The first is the user's model.
    verdict : {"adequate", "effect-missing", "unexplained", "inconclusive"}
        That of the last diagnosis.
    diagnosis : Diagnosis
        Of the last step.
    left_out : mapping of str to str
        Effects that would have been accepted but could not be gone on from, and why.
    """

    data: str
    steps: tuple[Step, ...]
    verdict: Verdict
    diagnosis: Diagnosis
    left_out: Mapping[str, str] = field(default_factory=dict)

    @property
    def model(self) -> Model:
        """The model of the last rung."""
        return self.steps[-1].model

    @property
    def undecided(self) -> Step:
        """The rung whose next experiment is open.

        The last one; or, where that has no question, an earlier one that could not tell what was
        accepted from what was not: taking one of two rivals answers nothing.
        """
        last = self.steps[-1]
        if last.next_experiment is not None:
            return last
        accepted = {step.accepted for step in self.steps}
        for before, step in zip(self.steps[-2::-1], self.steps[:0:-1], strict=True):
            proposed = before.next_experiment
            if proposed is None or step.accepted not in proposed.separates:
                continue
            if len(accepted & set(proposed.separates)) == 1:
                return before
        return last

    @property
    def proposed(self) -> dict[str, Any] | None:
        """What to measure next, as in a diagnosis: of the rung that cannot be decided."""
        experiment = self.undecided.next_experiment
        return None if experiment is None else experiment.to_dict()

    def __repr__(self) -> str:
        errors = " -> ".join(over_floor(step.relative_rms, step.noise_floor) for step in self.steps)
        return f"<Ladder {self.model.name} of {self.data}: error {errors} x floor; {self.verdict}>"

    def to_dict(self) -> dict[str, Any]:
        """Schema ``springpot.discovery/2``."""
        return {
            "schema": SCHEMA,
            "data": self.data,
            "tests": [test.to_dict() for test in self.diagnosis.tests],
            "steps": [step.to_dict() for step in self.steps],
            "verdict": self.verdict,
            "diagnosis": self.diagnosis.to_dict(),
            "left_out": dict(self.left_out),
        }

    @classmethod
    def from_dict(cls, answer: Mapping[str, Any]) -> Ladder:
        """What `to_dict` gave."""
        steps = some(Step.from_dict(row) for row in answer["steps"])
        diagnosis = Diagnosis.from_dict(answer["diagnosis"])
        return cls(answer["data"], steps, answer["verdict"], diagnosis, answer["left_out"])


Reached: TypeAlias = Callable[[Ladder], None]


F = TypeVar("F", bound=FittedModel)


class FoundSet(NamedTuple, Generic[F]):
    """Effects that explain the tests together.

    Attributes
    ----------
    effects : tuple of Effect
        In the order in which they are to be accepted.
    fit : Refit or Identification
        With all of them.
    places : callable
        Gives for each of their names what may stand in its place.
    """

    effects: tuple[Effect, ...]
    fit: F
    places: Callable[[Sequence[str]], Mapping[str | None, tuple[str, ...]]]


@dataclass(frozen=True, eq=False, kw_only=True)
class Rungs(ABC, Generic[F]):
    """Tests of one specimen, of any kind: how a rung is examined, and what of it decides.

    Attributes
    ----------
    effects : sequence of Effect
        Effects that may be missing.
    accuracy : Accuracy or None
        What the instrument promises.
    fitted : callable
        Given each effect that was fitted by itself.
    sets : list of FoundSet
        Sets that were found to explain the tests together.
    plan : list of Effect
        Those of the last such set that are still to be accepted.
    """

    effects: Sequence[Effect]
    accuracy: Accuracy | None = None
    fitted: Fitted = unseen
    sets: list[FoundSet[F]] = field(default_factory=list)
    plan: list[Effect] = field(default_factory=list)

    @abstractmethod
    def examined(
        self, model: Model, progress: Progress, before: Step | None, effect: Effect | None
    ) -> Examined:
        """A model; where it is that of the rung before with an effect, by what that has found."""

    @abstractmethod
    def complete_set(self, steps: Sequence[Step]) -> FoundSet[F] | None:
        """Several effects that explain together what the last rung leaves, where none alone does.

        None without such.
        """

    @abstractmethod
    def decisive(self, steps: Sequence[Step]) -> Effect | None:
        """The effect that the last rung asks for beyond doubt, if there is one."""

    @abstractmethod
    def likeliest_set(self, steps: Sequence[Step]) -> FoundSet[F] | None:
        """The likeliest set, begun with the effects accepted one after the other.

        None where that asks nothing more than the diagnosis has answered.
        """

    def fits_of(self, model: Model, others: Sequence[F] = ()) -> list[F]:
        """Fits of sets and others that are of a model, whatever the order of its effects."""
        fits, names = [*(found.fit for found in self.sets), *others], sorted(model.names)
        return [fit for fit in fits if sorted(fit.model.names) == names]

    def wanted(self, steps: Sequence[Step], refused: Container[str]) -> Effect | None:
        """The effect whose absence is beyond doubt, if there is one that was not refused."""
        if not self.plan:
            # "Inconclusive" is no ground for a decision that nobody looks at.
            if steps[-1].diagnosis.verdict not in SEEN:
                return None
            if found := self.complete_set(steps):
                self.sets.append(found)
                self.plan.extend(found.effects)
        effect = self.plan.pop(0) if self.plan else self.decisive(steps)
        if effect is None or effect.name in refused:
            return None
        return effect

    def settled(self, steps: list[Step], progress: Progress) -> list[Step]:
        """The rungs that stay, once no effect is wanted.

        Alone or first, an effect may only have seemed needed: with all others in place it is asked
        anew which set it is.
        """
        found = self.likeliest_set(steps)
        if found is None:
            return steps
        self.sets.append(found)
        # What stays keeps its rung.
        stay, others = [], list(found.effects)
        for effect in accepted_of(steps):
            if effect in others:
                others.remove(effect)
                stay.append(effect)
        return replaced_by(self, steps, found._replace(effects=(*stay, *others)), progress)


def first_named(diagnosis: Diagnosis) -> Candidate:
    """The candidate that the headline names first, and the next step with it.

    Else the first of the table, which may begin with one of a pair of which another effect does
    more by itself than either.

    Parameters
    ----------
    diagnosis : Diagnosis
        With one candidate at least.
    """
    for candidate in diagnosis.candidates:
        if diagnosis.leading and candidate.effect == diagnosis.leading[0]:
            return candidate
    return diagnosis.candidates[0]


def told_apart(diagnosis: Diagnosis) -> Candidate | None:
    """The same, unless the data cannot tell it from others that are as likely; None then.

    Of such a class only what is likelier than all the others goes in: else a user or another
    test decides.
    """
    first = first_named(diagnosis)
    if len(first.alike) > 1 and not first.probability >= VERDICT.likely:
        return None
    return first


def accepted_of(steps: Sequence[Step]) -> tuple[Effect, ...]:
    """The effects that led from the first rung to the last, as the model of that has them."""
    added = list(steps[-1].model.effects)
    for effect in steps[0].model.effects:
        added.remove(effect)
    return tuple(
        next(effect for effect in added if effect.name == step.accepted) for step in steps[1:]
    )


def in_order(
    effects: Sequence[Effect], worth: Mapping[tuple[str, ...], float]
) -> tuple[Effect, ...]:
    """The effects of a set, the ones first that do most without the others.

    Parameters
    ----------
    effects : sequence of Effect
        The set.
    worth : mapping of tuple of str to float
        Of each set that was fitted, by its key: the more, the likelier it is.
    """
    left, order = list(effects), []
    while left:
        # Last is what is missed the least.
        others = [key_of(other for other in left if other is not one) for one in left]
        order.append(left.pop(int(np.argmax([worth.get(key, -np.inf) for key in others]))))
    return tuple(order[::-1])


def climbed(
    rungs: Rungs[F],
    model: Model,
    accept: Sequence[Effect] | None = None,
    progress: Progress = silent,
    reached: Reached | None = None,
    begun: Ladder | None = None,
) -> Ladder:
    """Accept effects until nothing significant is left, or the given ones in order.

    Parameters
    ----------
    rungs : Rungs
        The tests, and by what rules of them the evidence decides.
    model : Model
        Where to begin.
    accept : sequence of Effect, optional
        Effects to accept in this order; without it every decision is taken by the evidence.
    progress : callable
        Printed in a few words what is being done.
    reached : callable, optional
        Given the ladder as it stands after each rung, so that what was reached is there even if the
        rest is interrupted. The ladder that is returned may be shorter: rungs that led nowhere are
        taken back.
    begun : Ladder, optional
        The first rungs, with the first of what is accepted, of the same tests and model: they are
        not climbed again.

    Raises
    ------
    SpringpotError
        If the model, or one with an effect that was asked for, cannot be fitted.
    """
    steps: list[Step] = []
    refused: dict[str, str] = {}

    def climb(step: Step) -> None:
        steps.append(step)
        if reached is not None:
            reached(_ladder(steps, refused))

    # Every rung is examined in full: what is missing beside the last effect is asked of the grown
    # model anew.
    given = iter(accept or ())
    if begun is None:
        climb(rung_of(rungs.examined(model, within("step 0", progress), None, None)))
    else:
        steps += begun.steps
        given = islice(given, len(steps) - 1, None)
    while True:
        # One effect a rung: which one is missing beside it is better told once it is there.
        effect = next(given, None)
        if accept is None and len(steps) <= LONGEST:
            effect = rungs.wanted(steps, refused)
        if effect is None:
            break
        before = steps[-1]
        told = within(f"step {len(steps)}", progress)
        try:
            case = rungs.examined(before.model + effect, told, before, effect)
        except SpringpotError as error:
            # What a user asks for is refused; where the evidence decides, the rungs that were
            # reached stay.
            if accept is not None:
                raise
            refused[effect.name] = str(error)
            continue
        climb(rung_of(case, before, effect.name))
    # Who chose the effects keeps them all; a machine's choice is looked over once more.
    if accept is None:
        steps = rungs.settled(steps, within(f"step {len(steps)}", progress))
    return _ladder(steps, refused)


def replaced_by(
    rungs: Rungs[F], steps: list[Step], found: FoundSet[F], progress: Progress
) -> list[Step]:
    """The rungs by the effects of a set, each with its rivals; those that stay as they are.

    The same list where these lead to no better verdict.
    """
    kept = [steps[0]]
    for step, effect in zip_longest(steps[1:], found.effects):
        if effect is None:
            break
        model = kept[-1].model + effect
        if step is None or step.model.name != model.name:
            # What cannot be fitted is no better.
            try:
                case = rungs.examined(model, progress, kept[-1], effect)
            except SpringpotError:
                return steps
            step = rung_of(case, kept[-1], effect.name)
        kept.append(step)
    if kept[-1].diagnosis.verdict not in ("adequate", steps[-1].diagnosis.verdict):
        return steps
    places = found.places([effect.name for effect in found.effects])
    return [replace(step, alike=places.get(step.accepted, step.alike)) for step in kept]


def _ladder(steps: Sequence[Step], refused: Mapping[str, str]) -> Ladder:
    """The ladder that ends with the last of these steps."""
    last = steps[-1].diagnosis
    return Ladder(last.data, tuple(steps), last.verdict, last, dict(refused))


def rung_of(case: Examined, before: Step | None = None, accepted: str | None = None) -> Step:
    """A rung, told beside the one before and what that foretold of the effect that was accepted."""
    told, error = case.diagnosis, case.diagnosis.error
    changed: dict[str, float] = {}
    predicted, alike = None, tuple(filter(None, [accepted]))
    if before is not None:
        changed = moves(before.parameters, told.parameters)
        for candidate in before.diagnosis.candidates:
            if candidate.effect == accepted:
                alike = candidate.alike
                # Not where nothing was foretold, or of another test, or of a model with two.
                foretold = isfinite(candidate.predicted_error) and isnan(candidate.error_beside)
                if foretold and before.test == error.test:
                    predicted = candidate.predicted_error
        untold = before.examined and before.examined.untold
        if untold and untold.effect == accepted:
            alike = (*alike, *untold.others)
    return Step(
        model=told.model,
        accepted=accepted,
        relative_rms=error.relative_rms,
        noise_floor=error.noise_floor,
        material_floor=error.material_floor,
        predicted_error=predicted,
        parameters=told.parameters,
        changed=changed,
        material_chance=error.material_chance,
        tests=told.tests,
        alike=alike,
        examined=case,
        test=error.test,
        next_experiment=told.next_experiment,
    )


def moves(before: Mapping[str, Value], after: Mapping[str, Value]) -> dict[str, float]:
    """Old parameters that moved by more than their interval, with the ratio new over old."""
    changed = {}
    for name, old in before.items():
        new = after.get(name)
        # Within its interval a change is no news; and nothing is a multiple of zero.
        if new is not None and old.value and not old.low <= new.value <= old.high:
            changed[name] = new.value / old.value
    return changed
