"""Missing effects of tests in time, added one by one, and how far each lowers the error."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from springpot.diagnosis.ladder import Ladder, Step, moves
from springpot.diagnosis.result import Diagnosis
from springpot.errors import SpringpotError
from springpot.identification.result import Identification
from springpot.registry import parse_model, plugins
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model

from .diagnosis import diagnose, examine
from .fitting import identify
from .residuals_of_tests import Test
from .verdict import NAN

MOST = 6
"""Effects that are added at most: more than a record has ever told apart."""


def discover(
    tests: Sequence[Test],
    model: Model | str,
    effects: Sequence[Effect] | None = None,
    accept: Sequence[Effect] | None = None,
    progress: Callable[[str], None] | None = None,
    reached: Callable[[Ladder], None] | None = None,
) -> Ladder:
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
    Ladder
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
) -> Ladder:
    """The rungs that a user asks for."""
    told(f"fitting {model.name}")
    steps = [_step(identify(tests, model))]
    for effect in accept:
        model = model + effect
        told(f"fitting {model.name}")
        steps.append(_step(identify(tests, model), steps[-1], (effect.name,)))
    told(f"judging {model.name}")
    return _ladder(steps, diagnose(tests, model, effects), {})


def _climbed(
    tests: Sequence[Test],
    model: Model,
    effects: Sequence[Effect],
    told: Callable[[str], None],
    reached: Callable[[Ladder], None] | None,
) -> Ladder:
    """The rungs that the evidence decides on."""
    known = {effect.name: effect for effect in effects}
    told(f"judging {model.name}")
    case = examine(tests, model, effects)
    # The fit that the diagnosis made: a rung costs no second one.
    steps = [_step(case.base)]
    left_out: dict[str, str] = {}
    # Also where the verdict is unexplained: an effect that helps beyond doubt may be one of
    # several.
    while len(steps) <= MOST:
        if reached is not None:
            reached(_ladder(steps, case.diagnosis, left_out))
        # The first of a class stands for it: the others would fit as well, and are told beside it.
        alike = [name for name in case.diagnosis.leading if name not in left_out]
        if not alike:
            break
        first = alike[0]
        larger = model + known[first]
        told(f"judging {larger.name}")
        base = None
        # The diagnosis has fitted the grown model already, unless only nearly.
        if case.best_fit.model.name == larger.name:
            base = case.best_fit
            larger = base.model
        try:
            case = examine(tests, larger, effects, base=base)
        except SpringpotError as error:
            # The rungs that were reached stay; the next of the class stands for it.
            left_out[first] = str(error)
            continue
        model = larger
        steps.append(_step(case.base, steps[-1], tuple(alike)))
    return _ladder(steps, case.diagnosis, left_out)


def _step(fit: Identification, before: Step | None = None, alike: tuple[str, ...] = ()) -> Step:
    """A rung by its fit, with the effects that may have made it, the accepted one first."""
    # A model is as good as it is for the test that it misses most.
    worst = max(fit.tests, key=lambda test: test.over_floor)
    changed: dict[str, float] = {}
    if before is not None:
        changed = moves(before.parameters, fit.parameters)
    return Step(
        model=fit.model,
        accepted=next(iter(alike), None),
        relative_rms=worst.relative_rms,
        noise_floor=worst.noise_floor,
        material_floor=NAN,
        predicted_error=None,
        parameters=fit.parameters,
        changed=changed,
        material_chance=NAN,
        tests=fit.tests,
        alike=alike,
        examined=fit,
    )


def _ladder(steps: Sequence[Step], diagnosis: Diagnosis, left_out: dict[str, str]) -> Ladder:
    return Ladder(diagnosis.data, tuple(steps), diagnosis.verdict, diagnosis, left_out)
