"""What a diagnosis says, as plain data: what may be missing, and what a user can do with that.

Each step that a user can take is told with its command and with the error that it leaves.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf, isfinite, isnan, nan
from typing import Any, Literal, NamedTuple, Protocol, TypeAlias

from springpot.identification.value import PartResult, Quantities, Value, parts_of
from springpot.lazy import Drawn, Printed
from springpot.misfit.error import Error, percent
from springpot.misfit.where import Where
from springpot.plain_data import Plain, json_number, jsonable, read
from springpot.registry import parse_model, plugins
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.thresholds import VERDICT
from springpot.writing import NAMED, in_shell, listed, suggested

DATA = "DATA"
"""Stands in commands for what a user called the data, and for the model that is judged."""


@dataclass(frozen=True)
class ToDo:
    """One step.

    Attributes
    ----------
    says : str
        What it is.
    command : str
        What does it; `DATA` stands for the data, and for the model that is judged.
    error_after : float
        The relative error that is foretold, NaN where only the step itself will tell.
    split : str
        The column that is split, if that is the step; a file does not hold it.
    exclude : tuple of int
        Rows of the data that are left out, the first being 1; a file does not hold them.
    wrong : str
        What is turned, or the two that are exchanged, if that is the step; a file does not hold it.
    turns : str
        The test in time of which a channel is turned; a file does not hold it.
    """

    says: str
    command: str
    error_after: float = float("nan")
    split: str = field(default="", compare=False)
    exclude: tuple[int, ...] = field(default=(), compare=False)
    wrong: str = field(default="", compare=False)
    turns: str = field(default="", compare=False)

    def to_dict(self) -> dict[str, Any]:
        """As in the schema."""
        row = {"says": self.says, "command": self.command, "error_after": self.error_after}
        return dict(jsonable(row))

    @classmethod
    def from_dict(cls, row: Mapping[str, Any]) -> ToDo:
        """What `to_dict` gave."""
        return read(cls, row)


def of_data(steps: Iterable[ToDo], *words: str) -> tuple[ToDo, ...]:
    """The steps with the data, and the model that is judged, in their commands.

    Parameters
    ----------
    steps : iterable of ToDo
        Whose commands hold `DATA`.
    *words : str
        The data as the user called them, and the options that name the model.
    """
    given = f" {' '.join(map(in_shell, words))} "
    return tuple(replace(step, command=step.command.replace(f" {DATA} ", given)) for step in steps)


def turning(
    spec: str, test: str = "", error_after: float = float("nan"), what: str = "force"
) -> ToDo:
    """To turn one channel of a test, or the phase, or to exchange two; `spec` opens the data so.

    Of a force that counts the other way every other answer is wrong.
    """
    says = f"the {what} counts the other way: turn it"
    if " and " in what:
        says = f"{what} stand in each other's place: exchange them"
    return ToDo(says, suggested("diagnose", spec), error_after, wrong=what, turns=test)


def splitting(
    column: str, error_after: float = float("nan"), what: str = "what is missing"
) -> ToDo:
    """To let each value of a column have a factor of its own, the material being shared."""
    says = f"{what} goes with {column}: one factor a value, the material shared"
    return ToDo(says, suggested("discover", DATA, "--split", column), error_after, split=column)


def leaving_out(rows: Sequence[int], error_after: float) -> ToDo:
    """To leave out points that stand out, as the answer itself has done."""
    says = f"row {rows[0]} stands out: leave it out of every fit too"
    if len(rows) > 1:
        says = f"rows {listed(rows)} stand out: leave them out of every fit too"
    left_out = [word for row in rows for word in ("--exclude", f"row={row}")]
    return ToDo(says, suggested("diagnose", DATA, *left_out), error_after, exclude=tuple(rows))


def leaving_out_the_beginning(until: float, rows: int) -> ToDo:
    """To leave out the first rows, measured while a step was still made, up to a time in s."""
    says = (
        "the misfit is largest at the beginning, where a step is still made: leave it out, compare"
    )
    command = suggested("diagnose", DATA, "--exclude", f"time=..{until:.3g}")
    return ToDo(says, command, exclude=tuple(range(1, rows + 1)))


def accepting(effect: str, explains: bool, error_after: float) -> ToDo:
    """To add an effect, proved or not."""
    says = f"{effect} helps, which is no proof: accept it"
    if explains:
        says = f"{effect} explains it: accept it"
    return ToDo(says, suggested("discover", DATA, "--accept", effect), error_after)


Verdict = Literal["adequate", "effect-missing", "unexplained", "inconclusive"]
SEEN = frozenset({"unexplained", "effect-missing"})
"""Verdicts after which something is missing, and what the effects leave may have a description."""
EffectVerdict = Literal["missing", "absent", "cannot-tell"]
Shelf = Literal["explains", "helps", "ruled-out"]

SCHEMA = "springpot.diagnosis/2"
TOLD = (
    "probability",
    "delta_bic",
    "score",
    "verdict",
    "predicted_error",
    "error_after",
    "bound",
    "over_floor",
    "parameters",
    "says",
    "error_beside",
)
"""Of a candidate, in the order of its schema; its effect and its class come before."""

Progress: TypeAlias = Callable[[str], None]
"""Called with a stage in a few words when it begins; whatever it raises ends the work."""


class WithEffect(Protocol):
    """What a fit of the model with one more effect leaves, and what it makes of the effect."""

    @property
    def error(self) -> float:
        """Relative error that `identify` leaves."""

    @property
    def over_floor(self) -> float:
        """The same over the noise."""

    @property
    def parameters(self) -> dict[str, Value]:
        """The effect's own parameters."""


@dataclass(frozen=True)
class AsTold:
    """The same as numbers."""

    error: float = nan
    over_floor: float = nan
    parameters: dict[str, Value] = field(default_factory=dict)


@dataclass(frozen=True)
class Candidate:
    """One effect and what adding it would do.

    Attributes
    ----------
    physics : Effect
        The effect itself, to be added to a model.
    alike : tuple of str
        Effects that these data cannot tell from it, itself included.
    probability : float
        That it is among what is missing.
    delta_bic : float
        Drop of the Bayesian information criterion when it joins; positive speaks for it.
    score : float
        Squared residual along what it would change, in units of noise variance, before any refit.
    verdict : {"missing", "absent", "cannot-tell"}
        In one word.
    predicted_error : float
        Relative error foretold by the scan.
    bound : float
        Relative change of K above which the effect would have been seen.
    says : str
        One sentence of physics.
    alone : WithEffect
        The fit of the model with this effect alone, if it was fitted.
    beside : WithEffect
        The fit with the leading effect too, where it only shows beside that.

    Examples
    --------
    >>> import springpot
    >>> mass = springpot.diagnose("artificial-hidden", "fractional-maxwell").best
    >>> mass.effect, mass.verdict, mass.alike
    ('inertia', 'missing', ('inertia',))
    >>> size = mass.parameters["m"]
    >>> f"{size.value:.2g} {size.unit} takes the error to {mass.error_after:.1%}"
    '0.49 kg takes the error to 4.4%'
    """

    physics: Effect
    alike: tuple[str, ...]
    probability: float
    delta_bic: float
    score: float
    verdict: EffectVerdict
    predicted_error: float
    bound: float
    says: str
    alone: WithEffect = AsTold()
    beside: WithEffect = AsTold()

    @property
    def effect(self) -> str:
        """Its name."""
        return self.physics.name

    @property
    def error_after(self) -> float:
        """Relative error that `identify` leaves of the model with it alone; NaN if not fitted."""
        return self.alone.error

    @property
    def over_floor(self) -> float:
        """That error over the noise.

        Of several tests in time before and after, and this, are of the one that the model misses
        most.
        """
        return self.alone.over_floor

    @property
    def error_beside(self) -> float:
        """The error left with it and the leading effect, where it only shows there; else NaN."""
        return self.beside.error

    @property
    def parameters(self) -> dict[str, Value]:
        """Its own parameters: beside the leading effect, where it only shows there."""
        shown = self.beside if isfinite(self.error_beside) else self.alone
        return shown.parameters

    @property
    def after(self) -> float:
        """The error with it: fitted, or as the scan foretells it where it was not.

        With the leading effect too, where it only shows beside that.
        """
        if isfinite(self.error_beside):
            return self.error_beside
        if isfinite(self.error_after):
            return self.error_after
        return self.predicted_error

    def lowers(self, error: Error) -> bool:
        """Whether it takes enough of an error to be seen, and is worth its parameters."""
        # What was not tried at all has no evidence: the better ones stood in its place.
        worth = self.delta_bic > 0.0 or not isfinite(self.delta_bic)
        return worth and self.after < VERDICT.helps * error.relative_rms

    def to_dict(self) -> dict[str, Any]:
        """As in the schema, where `alike` is called class."""
        row = {name: getattr(self, name) for name in TOLD}
        named = {"effect": self.effect}
        # By its name alone a law that somebody typed would be lost.
        if self.physics.expression != self.effect:
            named["law"] = self.physics.expression
        return {**named, "class": list(self.alike), **jsonable(row)}

    @classmethod
    def from_dict(cls, row: Mapping[str, Any]) -> Candidate:
        """What `to_dict` gave."""
        return read(
            cls,
            row,
            physics=plugins().effect(row.get("law", row["effect"])),
            alike=tuple(row["class"]),
            # What could not be computed was infinite: no evidence at all, no bound at all.
            delta_bic=json_number(row["delta_bic"], -inf),
            bound=json_number(row["bound"], inf),
            alone=read(AsTold, row, error=json_number(row["error_after"])),
            beside=read(AsTold, row, error=json_number(row.get("error_beside"))),
        )


@dataclass(frozen=True)
class NextExperiment(Plain):
    """The feasible measurement that would best tell the leading effects apart, or what is unknown.

    Attributes
    ----------
    says : str
        What to measure, and what it will show.
    separates : tuple of str
        The two effects that it tells apart; none where something unknown is asked for.
    expected_separation_sigma : float or None
        By how many standard deviations; None where there are no two effects.
    action : dict of str to list of float
        The new conditions, as far as they can be told in numbers.
    """

    says: str
    separates: tuple[str, ...]
    expected_separation_sigma: float | None
    action: dict[str, list[float]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Diagnosis(Drawn, Printed):
    """The answer to the question what is missing from a model.

    Its picture has the error as it is and with each leading effect, beside the floors.

    Attributes
    ----------
    data, model : str
        What was diagnosed.
    error : Error
        The model's error and the noise floor.
    verdict : {"adequate", "effect-missing", "unexplained", "inconclusive"}
        Overall.
    says : str
        The verdict in one sentence.
    split : str
        What the material floor says: how much of what is missing is a part of the material.
    where : tuple of Where
        Where the model fails.
    candidates : tuple of Candidate
        Effects, the best first.
    classes : tuple of tuple of str
        Effects that these data cannot tell apart.
    next_experiment : NextExperiment or None
        What would tell the leading ones apart, or whether what is unknown is there again.
    notes : tuple of str
        What else the user should know.
    evidence : dict of str to float
        The chances on which the verdict rests.
    parameters : dict of str to Value
        Those of the model as it is, with their intervals.
    leading : tuple of str
        Effects that the sentence of the verdict names, the one to add first.
    one_test : str
        How to choose the rows of one test, ``current=0.5``, where rows of several tests are the
        likely cause; else empty.
    tests : tuple of PartResult
        Each test beside its noise floor.
    left_out : mapping of str to str
        Effects that could not be fitted, and why.
    steps : tuple of ToDo
        What can be done with the data themselves: turn a channel, split by a column, leave a row
        out.
    quantities : Quantities, optional
        Crossover, loss factor ... of an adequate model: of another they would be no one's.

    Examples
    --------
    >>> import springpot
    >>> found = springpot.diagnose("artificial-hidden", "fractional-maxwell")
    >>> found.verdict, found.best.effect
    ('effect-missing', 'inertia')
    >>> found.says
    'the error is 21 x the noise floor; missing is inertia, and beside it time-delay or
    fixture-resonance'
    >>> [f"{row.effect} {row.probability:.0%}" for row in found.candidates[:2]]
    ['inertia 100%', 'time-delay 91%']
    """

    data: str
    model: Model
    error: Error
    verdict: Verdict
    says: str
    split: str
    where: tuple[Where, ...]
    candidates: tuple[Candidate, ...]
    classes: tuple[tuple[str, ...], ...]
    next_experiment: NextExperiment | None = None
    notes: tuple[str, ...] = ()
    evidence: dict[str, float] = field(default_factory=dict)
    parameters: Mapping[str, Value] = field(default_factory=dict)
    leading: tuple[str, ...] = ()
    one_test: str = ""
    tests: tuple[PartResult, ...] = ()
    left_out: Mapping[str, str] = field(default_factory=dict)
    steps: tuple[ToDo, ...] = ()
    quantities: Quantities | None = None

    @property
    def actions(self) -> tuple[ToDo, ...]:
        """What can be done next: first with the data themselves, then the effects to accept."""
        if self.verdict == "adequate":
            return self.steps
        explain = self.on_shelf("explains")
        shown = [*explain, *self.on_shelf("helps")][:NAMED]
        return (
            *self.steps,
            *(accepting(row.effect, row in explain, row.after) for row in shown),
        )

    @property
    def best(self) -> Candidate | None:
        """The effect that should be added, or None if none is missing."""
        # Candidates stand in the table beside every verdict; only this one says that the first is
        # to be believed.
        if self.candidates and self.verdict == "effect-missing":
            return self.candidates[0]
        return None

    @property
    def turns(self) -> list[ToDo]:
        """The steps that turn a channel or exchange two, before which nothing else holds."""
        return [step for step in self.steps if step.wrong]

    def behind_a_sign(self) -> Diagnosis:
        """The same, which says first that a channel is to be turned, where one is."""
        turns = self.turns
        if self.verdict == "adequate" or not turns:
            return self
        what = turns[0].wrong
        first = f"the {what} seems to count the other way: until it is turned nothing else holds"
        if " and " in what:
            stand = f"{what} stand in each other's place, as it seems"
            first = f"{stand}: until they are exchanged nothing else holds"
        # Nor does what would be measured next, turned as it is.
        bare = replace(self, next_experiment=None)
        if isnan(after := turns[0].error_after):
            return replace(bare, says=f"{first}; {self.says}")
        # The noise is read from what this model leaves, and tells nothing of the other.
        before = percent(self.error.relative_rms)
        return replace(bare, says=f"{first}; the error is {before}, and {percent(after)} turned")

    def shelf_of(self, candidate: Candidate) -> Shelf:
        """What an effect does for the misfit of this model.

        It ``explains`` it, alone or as one of those that the data cannot tell apart; it ``helps``:
        the error falls with it, whatever the proof is worth; or it is ``ruled-out`` as a cause.
        """
        if self.verdict == "effect-missing" and (
            candidate.verdict == "missing"
            or candidate.effect in self.leading
            # One of the rivals for the place beside the leading effect.
            or isfinite(candidate.error_beside)
        ):
            return "explains"
        if candidate.lowers(self.error):
            return "helps"
        return "ruled-out"

    def on_shelf(self, shelf: Shelf) -> tuple[Candidate, ...]:
        """The effects of a shelf; of those that help the one that takes most of the error first.

        What helps only beside another effect stands behind those that help alone.
        """
        found = [each for each in self.candidates if self.shelf_of(each) == shelf]
        if shelf == "helps":
            # What the headline names stands as it names it; of what may be chance the likeliest.
            named = self.leading
            if self.verdict == "inconclusive":
                named = named or tuple(each.effect for each in self.candidates[:1])
            first = {name: place for place, name in enumerate(named)}
            found.sort(
                key=lambda each: (
                    first.get(each.effect, len(first)),
                    isfinite(each.error_beside),
                    each.after,
                )
            )
        return tuple(found)

    @property
    def offered(self) -> str:
        """The effect to try next, a help where none is named; empty where none lowers the error."""
        # Of an adequate model nothing is left to lower.
        if self.verdict == "adequate":
            return ""
        helps = [each.effect for each in self.on_shelf("helps")]
        ruled_out = {each.effect for each in self.on_shelf("ruled-out")}
        return next((name for name in [*self.leading, *helps] if name not in ruled_out), "")

    @property
    def onward(self) -> str:
        """What a command that accepts `offered` is: ``next``, or no more than a help.

        One of several effects that the data cannot tell apart is not known to be the missing one.
        """
        if self.best is not None and self.best.verdict == "missing":
            return "next"
        return "helps, but is no proof"

    def __repr__(self) -> str:
        return f"<Diagnosis {self.model.name} of {self.data}: {self.verdict}; {self.says}>"

    def to_dict(self) -> dict[str, Any]:
        """Schema ``springpot.diagnosis/2``."""
        answer = {
            "schema": SCHEMA,
            "data": self.data,
            "model": self.model.name,
            "error": self.error,
            "tests": self.tests,
            "verdict": self.verdict,
            "says": self.says,
            "split": self.split,
            "parameters": self.parameters,
            "where": self.where,
            "candidates": [
                {**each.to_dict(), "shelf": self.shelf_of(each)} for each in self.candidates
            ],
            "classes": self.classes,
            "leading": self.leading,
            "one_test": self.one_test,
            "next_experiment": self.next_experiment,
            "notes": self.notes,
            "evidence": self.evidence,
            "left_out": self.left_out,
            "steps": self.steps,
            "actions": self.actions,
        }
        if self.quantities:
            answer |= {"quantities": self.quantities.rows, "kept": self.quantities.kept}
        return dict(jsonable(answer))

    @classmethod
    def from_dict(cls, answer: Mapping[str, Any]) -> Diagnosis:
        """What `to_dict` gave."""
        return read(
            cls,
            answer,
            model=parse_model(answer["model"]),
            tests=parts_of(answer["tests"]),
            quantities=Quantities.within(answer),
        )


def silent(stage: str) -> None:
    """For those who do not ask."""


def within(whole: str, progress: Progress) -> Progress:
    """Stages of a part, told as such: ``step 1: fitting fractional-maxwell``."""
    return lambda stage: progress(f"{whole}: {stage}")


class TriedEffect(NamedTuple):
    """An effect that was fitted by itself, for those who draw it before the answer is there.

    Attributes
    ----------
    effect : Effect
        The effect.
    model : Model
        The model with it.
    theta : ndarray, shape (p,)
        Its parameters.
    """

    effect: Effect
    model: Model
    theta: Real


Fitted: TypeAlias = Callable[[TriedEffect], None]
"""Called with each effect as its fit comes, and once more where a better one does."""


def unseen(tried: TriedEffect) -> None:
    """For those who wait for the answer."""
