"""Sets of effects that are worth a refit: one more beside those there are, or two at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from springpot.identification.native import Effort
from springpot.misfit.frame import NoiseFrame
from springpot.misfit.refit import Refit, refit
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.thresholds import SEARCH

from .grown import Grown
from .scan import Score, best_pairs, enough_for, shifted_twice


@dataclass(frozen=True, eq=False)
class AskedSet:
    """A set of effects to be refitted: from given starts (p,), and so many read off the data."""

    effects: tuple[Effect, ...]
    model: Model
    starts: list[Real]
    read_off: int
    predicted: float

    @property
    def key(self) -> tuple[str, ...]:
        """Names of its effects in alphabetical order."""
        return tuple(sorted(effect.name for effect in self.effects))

    def joined(self, other: AskedSet) -> AskedSet:
        """The same set with the starts of both."""
        starts, predicted = [*self.starts, *other.starts], min(self.predicted, other.predicted)
        return replace(
            self, starts=starts, read_off=max(self.read_off, other.read_off), predicted=predicted
        )

    def is_judged_by(self, base: Refit) -> bool:
        """Whether the data are numbers enough for it."""
        return enough_for(base, self.model)

    def fitted(self, base: Refit, effort: Effort) -> Grown:
        """The refit beside a base, in units of its noise."""
        found = refit(self.model, base.data, base.noise, self.starts, self.read_off, effort)
        return Grown(self.effects, found, self.predicted)


def beside(present: Sequence[Effect], model: Model, effects: Sequence[Effect]) -> list[Effect]:
    """Those of some effects that may be missing beside others that a model has been given."""
    return [
        effect
        for effect in effects
        if not (effect.narrow and any(one.narrow for one in present))
        and not shifted_twice(model, effect)
        and not _second_law(present, effect)
    ]


def one_more(
    present: tuple[Effect, ...], scores: Sequence[Score], most: int = SEARCH.seconds
) -> list[AskedSet]:
    """The best so many of the effects that were scanned beside others, with these."""
    # Beside another effect the scan's own starts are near enough; those read off the data know of
    # neither.
    return [
        AskedSet(
            (*present, score.influence.effect),
            score.influence.model,
            list(score.starts),
            0,
            score.predicted,
        )
        for score in scores[:most]
    ]


def two_more(
    present: tuple[Effect, ...], fitted: Refit, frame: NoiseFrame, scores: Sequence[Score]
) -> list[AskedSet]:
    """Pairs that explain together what a model with some effects leaves, with these."""
    asked = []
    for pair in best_pairs(frame, scores, fitted.model, fitted.theta, SEARCH.together):
        both = (pair.first.influence.effect, pair.second.influence.effect)
        if _second_law(both[:1], both[1]):
            continue
        predicted = fitted.rss - pair.gain
        asked.append(AskedSet((*present, *both), pair.model, [pair.start], 1, predicted))
    return asked


def _second_law(effects: Sequence[Effect], other: Effect) -> bool:
    """Whether another shift by the same condition is among them.

    Of a material's times there is one law.

    What a second one would mend, such as a temperature that was misread, is no physics of the
    material.
    """
    if other.plane != "shift":
        return False
    return any(effect.plane == "shift" and effect.needs == other.needs for effect in effects)


def once(asked: Sequence[AskedSet]) -> list[AskedSet]:
    """Each set once, with the starts of all its ways: ten starts take hardly longer than five."""
    sets: dict[tuple[str, ...], AskedSet] = {}
    for each in asked:
        if each.key in sets:
            each = sets[each.key].joined(each)
        sets[each.key] = each
    return list(sets.values())
