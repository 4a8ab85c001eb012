"""Sets with another effect in the place of one: what the data cannot tell from it there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from springpot.misfit.refit import Refit, refit
from springpot.rheology.effect import Effect
from springpot.rheology.points import Real
from springpot.thresholds import SEARCH

from .asked import AskedSet, beside, one_more, two_more
from .grown import Grown, Search
from .scan import Score, scan_effects


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
    for rest, _, scores in _places(search, grown, effects):
        yield from _from_there(grown, one_more(rest, scores, SEARCH.singles))


def one_or_two_for_one(
    search: Search, grown: Grown, effects: Sequence[Effect]
) -> Iterator[AskedSet]:
    """Sets with another effect or two in the place of one, the best at first sight; see above."""
    for rest, fitted, scores in _places(search, grown, effects):
        two = two_more(rest, fitted, fitted.frame(), scores)
        yield from _from_there(grown, [*one_more(rest, scores), *two])


def scanned_beside(
    present: Sequence[Effect], fitted: Refit, effects: Sequence[Effect]
) -> list[Score]:
    """Scores of what may be missing beside effects that a fitted model has been given."""
    others = beside(present, fitted.model, effects)
    return scan_effects(fitted, fitted.frame(), others).scores


def _places(
    search: Search, grown: Grown, effects: Sequence[Effect]
) -> Iterator[tuple[tuple[Effect, ...], Refit, list[Score]]]:
    """For each effect of a set: the others, their fit, and the scores of what may stand there."""
    for i in range(len(grown.effects)):
        rest = (*grown.effects[:i], *grown.effects[i + 1 :])
        fitted = _without(search, grown, i)
        others = [effect for effect in effects if effect.name != grown.names[i]]
        yield rest, fitted, scanned_beside(rest, fitted, others)


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
    model = grown.refit.model - grown.effects[i].name
    values = dict(zip(grown.refit.model.names, grown.refit.theta, strict=True))
    start = np.array([values[name] for name in model.names])
    fitted = refit(model, search.base.data, search.base.noise, [start], starts=2)
    search.grown.append(Grown(rest, fitted, fitted.rss))
    return fitted
