"""Sets of effects that are worth a refit: one more, two at once, or one in the place of another.

Of several effects a first one takes the room of the others, so that one after the other leads
astray. A set has neighbours: one effect more, one less, another one or two in the place of one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol, TypeVar

import numpy as np

from springpot.identification.native import Effort
from springpot.misfit.frame import NoiseFrame
from springpot.misfit.refit import Refit, refit
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.thresholds import SEARCH

from .grown import Grown, Search
from .scan import Score, best_pairs, enough_for, scan_effects, shifted_twice


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


def in_each_place(search: Search, grown: Grown, effects: Sequence[Effect]) -> Iterator[AskedSet]:
    """Sets with another effect in the place of one, for each place and as many as stand alone.

    Beside others an effect's twins may all be worse at first sight than what cannot be it: a name
    is unique only once each of them was fitted.

    Parameters
    ----------
    search : Search
        To which fits of the sets without an effect are added.
    grown : Grown
        A set, fitted.
    effects : sequence of Effect
        What may stand in a place.
    """
    for place in _places(search, grown, effects):
        yield from _from_there(grown, one_more(place.rest, place.scores, SEARCH.singles))


def one_or_two_for_one(
    search: Search, grown: Grown, effects: Sequence[Effect]
) -> Iterator[AskedSet]:
    """Sets with another effect or two in the place of one, the best at first sight; see above."""
    for place in _places(search, grown, effects):
        two = two_more(place.rest, place.standing, place.standing.frame(), place.near)
        yield from _from_there(grown, [*one_more(place.rest, place.scores), *two])


def scanned_beside(
    present: Sequence[Effect], fitted: Refit, effects: Sequence[Effect]
) -> list[Score]:
    """Scores of what may be missing beside effects that a fitted model has been given."""
    others = beside(present, fitted.model, effects)
    return scan_effects(fitted, fitted.frame(), others).scores


@dataclass(frozen=True, eq=False)
class _Place:
    """The place of one effect of a set, and what may stand there.

    Attributes
    ----------
    rest : tuple of Effect
        The others.
    standing : Refit
        These as they stand in the set: fitted anew they take the place as far as they can, and what
        could stand there is seen from afar.
    near, afar : list of Score
        What may stand there, seen beside the others as they stand and as they are fitted anew.
    """

    rest: tuple[Effect, ...]
    standing: Refit
    near: list[Score]
    afar: list[Score]

    @property
    def scores(self) -> list[Score]:
        """Of both that which foretells the least of each effect, the best effects first."""
        best: dict[str, Score] = {}
        for score in sorted([*self.near, *self.afar], key=lambda score: score.predicted):
            best.setdefault(score.influence.effect.name, score)
        return list(best.values())


def _places(search: Search, grown: Grown, effects: Sequence[Effect]) -> Iterator[_Place]:
    """The places of a set."""
    for i, effect in enumerate(grown.effects):
        rest = (*grown.effects[:i], *grown.effects[i + 1 :])
        others = [other for other in effects if other.name != effect.name]
        standing, fitted = _standing(grown, effect), _without(search, grown, i)
        near, afar = (scanned_beside(rest, one, others) for one in (standing, fitted))
        yield _Place(rest, standing, near, afar)


def _standing(grown: Grown, effect: Effect) -> Refit:
    """A fitted set as it stands without one of its effects."""
    model, theta = _less(grown, effect)
    left = replace(grown.refit, fit=replace(grown.refit.fit, model=model, theta=theta))
    residual = left.frame().residual
    return replace(left, fit=replace(left.fit, cost=float(residual @ residual)))


def _less(grown: Grown, effect: Effect) -> tuple[Model, Real]:
    """The model of a set without an effect, and the parameters (p,) that are left."""
    model = grown.refit.model - effect.name
    values = dict(zip(grown.refit.model.names, grown.refit.theta.tolist(), strict=True))
    return model, np.array([values[name] for name in model.names])


def _from_there(grown: Grown, asked: Sequence[AskedSet]) -> Iterator[AskedSet]:
    """Sets that also begin with the values that they share with another, fitted one."""
    known = dict(zip(grown.refit.model.names, grown.refit.theta.tolist(), strict=True))
    for each in asked:
        own = zip(each.model.names, each.starts[0].tolist(), strict=True)
        start: Real = np.array([known.get(name, value) for name, value in own])
        yield replace(each, starts=[*each.starts, start])


def _without(search: Search, grown: Grown, i: int) -> Refit:
    """The fit of a set without one of its effects, which joins the search."""
    rest = (*grown.effects[:i], *grown.effects[i + 1 :])
    if not rest:
        return search.base
    key = tuple(sorted(effect.name for effect in rest))
    # As found so far: the best of several fits, where it was grown in several ways.
    known = [one.refit for one in search.grown if one.key == key]
    if known:
        return max(known, key=lambda one: one.log_evidence)
    model, start = _less(grown, grown.effects[i])
    fitted = refit(model, search.base.data, search.base.noise, [start], starts=2)
    search.grown.append(Grown(rest, fitted, fitted.rss))
    return fitted


class OneSet(Protocol):
    """Effects that were fitted together."""

    @property
    def key(self) -> tuple[str, ...]:
        """Their names in alphabetical order."""
        ...


S = TypeVar("S", bound=OneSet)


class Sets(Protocol[S]):
    """The sets that were fitted so far, and how others are."""

    def likeliest(self) -> list[S]:
        """One fit of each set, the likeliest first."""
        ...

    def open(self, near: Sequence[S]) -> None:
        """Fit the neighbours of some sets."""
        ...

    def exchange(self, best: S) -> None:
        """Fit whatever may stand in a place of the best set."""
        ...


def go_on_to_neighbours(sets: Sets[S]) -> None:
    """Go on to sets that are neighbours of the best, until none is better.

    Parameters
    ----------
    sets : Sets
        With those to begin with.
    """
    opened: set[tuple[str, ...]] = set()
    exchanged: set[tuple[str, ...]] = set()
    while near := sets.likeliest()[: SEARCH.beam]:
        if near[0].key not in opened:
            new = [one for one in near if one.key not in opened]
            opened.update(one.key for one in new)
            sets.open(new)
        elif near[0].key not in exchanged:
            exchanged.add(near[0].key)
            sets.exchange(near[0])
        else:
            break
