"""Missing effects of tests in time, added one by one, and how far each lowers the error."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass

from springpot.diagnosis.examination import Progress, silent
from springpot.diagnosis.in_practice import Accuracy
from springpot.diagnosis.ladder import Ladder, Reached, Step, climbed
from springpot.registry import parse_model, plugins
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model

from .diagnosis import examine
from .residuals_of_tests import Test
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

    Raises
    ------
    SpringpotError
        If the model, or one with an effect that was asked for, does not fit the tests.
    """
    if isinstance(model, str):
        model = parse_model(model)
    if effects is None:
        effects = list(plugins().items("effect"))
    return climbed(TimeRungs(tests, effects, accuracy), model, accept, progress, reached, begun)


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
    """

    tests: Sequence[Test]
    effects: Sequence[Effect]
    accuracy: Accuracy | None = None

    def examined(
        self, model: Model, progress: Progress, before: Step | None, effect: Effect | None
    ) -> TimeCase:
        """The examination of a model, by the fit that the rung before has made of it."""
        progress(f"judging {model.name}")
        known = getattr(before, "examined", None)
        # The diagnosis has fitted the grown model already, unless only nearly.
        if isinstance(known, TimeCase) and known.best_fit.model.name == model.name:
            base = known.best_fit
            return examine(self.tests, base.model, self.effects, base=base, accuracy=self.accuracy)
        return examine(self.tests, model, self.effects, accuracy=self.accuracy)

    def wanted(self, steps: Sequence[Step], refused: Container[str]) -> Effect | None:
        """The effect that the evidence asks for, if it is the only one that does what it does.

        Of a class whose members the tests cannot tell apart the first is not proved: a user or
        another test decides. Also where the verdict is unexplained: an effect that helps beyond
        doubt may be one of several.
        """
        leading = steps[-1].diagnosis.leading
        if len(leading) != 1 or leading[0] in refused:
            return None
        # What one test alone has is named with it.
        there = (each for effect in self.effects for each in at_tests(effect, list(self.tests)))
        return next(effect for effect in there if effect.name == leading[0])

    def settled(self, steps: list[Step], progress: Progress) -> list[Step]:
        """All of them."""
        return steps
