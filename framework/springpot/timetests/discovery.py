"""Missing effects of tests in time, added one by one, and how far each lowers the error."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from springpot.errors import SpringpotError
from springpot.registry import parse_model, plugins
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model

from .answer import TimeDiagnosis
from .diagnosis import diagnose
from .fitting import identify
from .residuals_of_tests import Test
from .result import TimeIdentification

SCHEMA = "springpot.discovery-in-time/1"
MOST = 6
"""Effects that are added at most: more than a record has ever told apart."""


@dataclass(frozen=True, eq=False)
class TimeStep:
    """One rung.

    Attributes
    ----------
    fit : TimeIdentification
        Of the model of this rung.
    accepted : str or None
        The effect that made it; None on the first rung.
    alike : tuple of str
        Effects that it could not be told from.
    """

    fit: TimeIdentification
    accepted: str | None
    alike: tuple[str, ...] = ()

    @property
    def over_floor(self) -> float:
        """Error over the noise floor, of the worst test."""
        return max(test.ratio for test in self.fit.tests)

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "model": self.fit.model.name,
            "accepted": self.accepted,
            "class": list(self.alike),
            "relative_rms": self.fit.relative_rms,
            "over_floor": self.over_floor,
            "tests": [test.to_dict() for test in self.fit.tests],
            "parameters": self.fit.parameters,
        }


@dataclass(frozen=True, eq=False)
class TimeLadder:
    """A discovery from tests in time.

    Attributes
    ----------
    steps : tuple of TimeStep
        The first is the model without further effects.
    diagnosis : TimeDiagnosis
        Of the last one.
    left_out : dict of str to str
        Effects that would have been accepted but could not be gone on from, and why.
    """

    steps: tuple[TimeStep, ...]
    diagnosis: TimeDiagnosis
    left_out: dict[str, str] = field(default_factory=dict)

    @property
    def model(self) -> Model:
        """The model of the last rung."""
        return self.steps[-1].fit.model

    @property
    def verdict(self) -> str:
        """That of the last diagnosis."""
        return self.diagnosis.verdict

    def to_dict(self) -> dict[str, Any]:
        """Schema ``springpot.discovery-in-time/1``."""
        return {
            "schema": SCHEMA,
            "data": " + ".join(test.name for test in self.steps[-1].fit.tests),
            "steps": [step.to_dict() for step in self.steps],
            "verdict": self.verdict,
            "diagnosis": self.diagnosis.to_dict(),
            "left_out": self.left_out,
        }


def discover(
    tests: Sequence[Test],
    model: Model | str,
    effects: Sequence[Effect] | None = None,
    accept: Sequence[Effect] | None = None,
    progress: Callable[[str], None] | None = None,
    reached: Callable[[TimeLadder], None] | None = None,
) -> TimeLadder:
    """Add missing effects one by one.

    Parameters
    ----------
    tests : sequence of TimeTest or Measurement
        Of one specimen, at least one in time.
    model : Model or str
        Where to begin.
    effects : sequence of Effect, optional
        What may be missing; by default all that is installed.
    accept : sequence of Effect, optional
        Effects to add, in this order; without it the evidence decides.
    progress : callable, optional
        Told in a few words what is being done.
    reached : callable, optional
        Given the ladder as it stands after each step on which the evidence decides.

    Returns
    -------
    TimeLadder
        Each rung, and what is said of the last one.

    Raises
    ------
    SpringpotError
        If the model, or one with an effect that was asked for, does not fit the tests.
    """
    if isinstance(model, str):
        model = parse_model(model)
    if effects is None:
        effects = list(plugins().items("effect"))

    def told(words: str) -> None:
        if progress is not None:
            progress(words)

    if accept is not None:
        return _given(tests, model, effects, accept, told)
    return _climbed(tests, model, effects, told, reached)


def _given(
    tests: Sequence[Test],
    model: Model,
    effects: Sequence[Effect],
    accept: Sequence[Effect],
    told: Callable[[str], None],
) -> TimeLadder:
    """The rungs that a user asks for."""
    told(f"fitting {model.name}")
    steps = [TimeStep(identify(tests, model), None)]
    for effect in accept:
        model = model + effect
        told(f"fitting {model.name}")
        steps.append(TimeStep(identify(tests, model), effect.name))
    told(f"judging {model.name}")
    return TimeLadder(tuple(steps), diagnose(tests, model, effects))


def _climbed(
    tests: Sequence[Test],
    model: Model,
    effects: Sequence[Effect],
    told: Callable[[str], None],
    reached: Callable[[TimeLadder], None] | None,
) -> TimeLadder:
    """The rungs that the evidence decides on."""
    known = {effect.name: effect for effect in effects}
    told(f"judging {model.name}")
    diagnosis = diagnose(tests, model, effects)
    # The fit that the diagnosis made: a rung costs no second one.
    steps = [TimeStep(diagnosis.base, None)]
    left_out: dict[str, str] = {}
    # Also where the verdict is unexplained: an effect that helps beyond doubt may be one of
    # several.
    while len(steps) <= MOST:
        if reached is not None:
            reached(TimeLadder(tuple(steps), diagnosis, left_out))
        # The first of a class stands for it: the others would fit as well, and are told beside it.
        alike = [name for name in diagnosis.missing if name not in left_out]
        if not alike:
            break
        first, *others = alike
        larger = model + known[first]
        told(f"judging {larger.name}")
        base = None
        # The diagnosis has fitted the grown model already, unless only nearly.
        if diagnosis.best_fit.model.name == larger.name:
            base = diagnosis.best_fit
            larger = base.model
        try:
            diagnosis = diagnose(tests, larger, effects, base=base)
        except SpringpotError as error:
            # The rungs that were reached stay; the next of the class stands for it.
            left_out[first] = str(error)
            continue
        model = larger
        steps.append(TimeStep(diagnosis.base, first, tuple(others)))
    return TimeLadder(tuple(steps), diagnosis, left_out)
