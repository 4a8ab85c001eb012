"""Missing effects of tests in time, added one by one, and how far each lowers the error."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass, field

from springpot.diagnosis.in_practice import Accuracy
from springpot.diagnosis.ladder import Ladder, Reached, Step, climbed, replaced_by, with_rivals
from springpot.diagnosis.meanwhile import Fitted, unseen
from springpot.diagnosis.result import Progress, silent
from springpot.plain_data import alive
from springpot.registry import parse_model, plugins
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model

from .diagnosis import examine
from .residuals_of_tests import Test
from .sets import FoundSet, complete_set, likeliest_set
from .specimen import at_tests
from .verdict import TimeCase


def discover(
    tests: Sequence[Test],
    model: Model | str,
    effects: Sequence[Effect] | None = None,
    accept: Sequence[Effect] | None = None,
    progress: Progress = silent,
    reached: Reached | None = None,
    accuracy: Accuracy | None = None,
    begun: Ladder | None = None,
    fitted: Fitted = unseen,
) -> Ladder:
    """Add missing effects one by one; see `springpot.diagnosis.ladder.climbed`.

    Parameters
    ----------
    tests : sequence of TimeTest or Measurement
        Of one specimen, at least one in time.
    model : Model or str
        Where to begin.
    effects : sequence of Effect, optional
        What may be missing; by default all that is installed.
    accept, progress, reached, begun
        As for `climbed`.
    accuracy : Accuracy, optional
        What the instrument promises.
    fitted : callable
        Given each effect that was fitted by itself.

    Raises
    ------
    SpringpotError
        If the model, or one with an effect that was asked for, does not fit the tests.
    """
    if isinstance(model, str):
        model = parse_model(model)
    if effects is None:
        effects = list(plugins().items("effect"))
    rungs = TimeRungs(tests, effects, accuracy, fitted=fitted)
    return climbed(rungs, model, accept, progress, reached, begun)


@dataclass(frozen=True, eq=False)
class TimeRungs:
    """Tests of which one at least is in time.

    Attributes
    ----------
    tests : sequence of TimeTest or Measurement
        Of one specimen.
    effects : sequence of Effect
        Effects that may be missing.
    accuracy : Accuracy or None
        What the instrument promises.
    sets : list of FoundSet
        Sets that were found to explain the tests together.
    plan : list of Effect
        Those of the first such set that are still to be accepted.
    sought : list of str
        The model of which a set was looked for.
    fitted : callable
        Given each effect that was fitted by itself.
    """

    tests: Sequence[Test]
    effects: Sequence[Effect]
    accuracy: Accuracy | None = None
    sets: list[FoundSet] = field(default_factory=list)
    plan: list[Effect] = field(default_factory=list)
    sought: list[str] = field(default_factory=list)
    fitted: Fitted = unseen

    def examined(
        self, model: Model, progress: Progress, before: Step | None, effect: Effect | None
    ) -> TimeCase:
        """The examination of a model, by the fit that the rung before has made of it."""
        progress(f"judging {model.name}")
        known = getattr(before, "examined", None)
        fits = [found.fit for found in self.sets]
        # The diagnosis has fitted the grown model already, unless only nearly.
        if isinstance(known, TimeCase):
            fits.append(known.best_fit)
        base = next((fit for fit in fits if sorted(fit.model.names) == sorted(model.names)), None)
        if base is not None:
            model = base.model
        return examine(
            self.tests, model, self.effects, base=base, accuracy=self.accuracy, fitted=self.fitted
        )

    def wanted(self, steps: Sequence[Step], refused: Container[str]) -> Effect | None:
        """The effect that the evidence asks for, if it is the only one that does what it does.

        Of a class whose members the tests cannot tell apart the first is not proved: a user or
        another test decides. Where the verdict is unexplained several that explain all together
        come first, or one that helps beyond doubt.
        """
        last = steps[-1]
        # Once: what no set explains from there on, none does from a rung that it led to.
        if not self.sought and last.diagnosis.verdict == "unexplained":
            self.sought.append(last.model.name)
            if found := complete_set(self._case(last)):
                self.plan.extend(found.effects)
                self.sets.append(found)
        if self.plan:
            return self.plan.pop(0)
        leading = last.diagnosis.leading
        if len(leading) != 1 or leading[0] in refused:
            return None
        # What one test alone has is named with it.
        there = (each for effect in self.effects for each in at_tests(effect, list(self.tests)))
        return next(effect for effect in there if effect.name == leading[0])

    def settled(self, steps: list[Step], progress: Progress) -> list[Step]:
        """The rungs, each effect the likeliest beside all others."""
        accepted = [step.accepted for step in steps[1:]]
        adequate = steps[-1].diagnosis.verdict == "adequate"
        for found in self.sets:
            # A set that was taken whole has been held beside all others.
            if sorted(map(str, accepted)) == sorted(effect.name for effect in found.effects):
                return with_rivals(steps, found)
        if not accepted or (adequate and len(accepted) == 1):
            return steps
        likeliest = likeliest_set([self._case(step) for step in steps])
        if likeliest is None:
            return steps
        self.sets.append(likeliest)
        return replaced_by(self, steps, likeliest, progress)

    def _case(self, step: Step) -> TimeCase:
        return alive(step.examined, TimeCase, f"the step {step.model.name}")
