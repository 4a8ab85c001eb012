"""Missing effects of tests in time, added one by one or as sets, and how far the error falls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from springpot.diagnosis.grown import MOST_TOGETHER, go_on_to_neighbours, key_of, without_one
from springpot.diagnosis.in_practice import Accuracy
from springpot.diagnosis.ladder import (
    FoundSet,
    Ladder,
    Reached,
    Rungs,
    Step,
    accepted_of,
    climbed,
    in_order,
    told_apart,
)
from springpot.diagnosis.result import Fitted, Progress, silent, unseen
from springpot.errors import SpringpotError
from springpot.identification.material import is_material
from springpot.identification.result import Identification
from springpot.misfit.residual_scatter import ResidualScatter
from springpot.misfit.residuals_of_tests import Test
from springpot.plain_data import alive
from springpot.registry import parse_model, plugins
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.thresholds import EVIDENCE, SEARCH

from .diagnosis import examine
from .fitting import identify
from .hypotheses import AskedTests, FitResiduals, Hypothesis
from .score import TimeScan
from .screening import EXACT, approximately_fitted, leading_of_scan, noise_of_best
from .verdict import TimeCase


@dataclass(frozen=True, eq=False)
class TimeSets:
    """The sets that were fitted so far beside a model of tests in time.

    Attributes
    ----------
    asked : AskedTests
        The tests, and the effects of which sets are made.
    base : Identification
        The fit of the model.
    fitted : dict of tuple of str to Hypothesis
        By their names.
    given_up : set of tuple of str
        Sets that cannot be fitted exactly.
    """

    asked: AskedTests
    base: Identification
    fitted: dict[tuple[str, ...], Hypothesis] = field(default_factory=dict)
    given_up: set[tuple[str, ...]] = field(default_factory=set)

    def add(self, one: Hypothesis) -> None:
        """Take a set up, where it is new or better than the fit of it there is."""
        known = self.fitted.get(one.key)
        if known is None or one.cost < known.cost:
            self.fitted[one.key] = one

    def likeliest(self) -> list[Hypothesis]:
        """The likeliest first."""
        return sorted(self.fitted.values(), key=lambda one: one.cost)

    def open(self, near: Sequence[Hypothesis]) -> None:
        """Fit sets with one effect more, where there is more than noise to explain."""
        # A linear step foretells little of what goes by no small one: from the likeliest set more
        # are tried.
        likeliest = self.likeliest()[0]
        for one in near:
            if one.left.doubtful:
                self._extend(one, SEARCH.singles if one is likeliest else SEARCH.seconds)

    extend = open
    """Sets with an effect more are all the neighbours that are fitted."""

    def exchange(self, best: Hypothesis) -> None:
        """Fit sets with another effect in each place of the best one."""
        for effect in best.effects:
            self._extend(self._without(best, effect), SEARCH.singles)

    def _extend(self, one: Hypothesis, most: int) -> None:
        if len(one.effects) >= MOST_TOGETHER:
            return
        asked, grown = self.asked, replace(self.base, model=one.model, theta=one.theta)
        names = [effect.name for effect in one.effects]
        new = [
            effect
            for effect in asked.effects
            if tuple(sorted([*names, effect.name])) not in self.fitted
        ]
        entries = TimeScan(grown, asked.quick).entries(new)
        leading = leading_of_scan(entries, one.left)[:most]
        # Beside another effect the scan's first place is near enough; others were tried alone.
        for each in approximately_fitted(asked, grown, leading, one.left, starts=1):
            self.add(replace(each, effects=(*one.effects, each.effect)))

    def _without(self, best: Hypothesis, effect: Effect) -> Hypothesis:
        """The fit of the others, or where they stand in the whole set if that is better."""
        there = self._left_there(best, effect)
        # A fit that is worse was caught in another minimum, and an effect would only mend that.
        return min(self.fitted.get(there.key, there), there, key=lambda one: one.cost)

    def _left_there(self, best: Hypothesis, effect: Effect) -> Hypothesis:
        """A set without one of its effects, the rest as it is."""
        rest = tuple(other for other in best.effects if other is not effect)
        model, theta = without_one(best.model, best.theta, effect)
        left = FitResiduals.by(model, theta, self.base.reference, self.asked.parts)
        return Hypothesis(rest, model, theta, left)

    def settle(self) -> Hypothesis:
        """The best set, once those near it and the best of each size are fitted exactly."""
        while True:
            best = self.likeliest()[0]
            margin = 2.0 * EVIDENCE.rivals
            near = [one for one in self.likeliest() if one.cost < best.cost + margin]
            # By what fixed exponentials are off, or from a start that leads astray, a set that
            # leaves noise alone may look as if it did not.
            for count in range(1, len(best.effects) + 1):
                alike = [one for one in self.likeliest() if len(one.effects) == count]
                near += alike[:EXACT]
            near += [self._without(best, effect) for effect in best.effects]
            inexact = {
                one.key: one for one in near if one.fit is None and one.key not in self.given_up
            }
            if not inexact:
                return best
            for one in inexact.values():
                self._fit_exactly(one)

    def _fit_exactly(self, one: Hypothesis) -> None:
        self.fitted.pop(one.key, None)
        try:
            fit = identify(
                self.asked.tests,
                one.model,
                seeds=[one.theta],
                noise=self.asked.known,
            )
        except SpringpotError:
            self.given_up.add(one.key)
            return
        self.fitted[one.key] = Hypothesis.exactly(one.effects, fit, self.asked.parts)


def best_set(
    case: TimeCase, fewer: int, accepted: Hypothesis | None = None
) -> FoundSet[Identification] | None:
    """The smallest set that is as good as any, if it leaves noise alone.

    Parameters
    ----------
    case : TimeCase
        The model to which effects are added, examined.
    fewer : int
        Effects of which a set is none that is looked for.
    accepted : Hypothesis, optional
        A set to begin with, beside the model as it is and with each effect that was fitted.
    """
    if is_material(case.base.model):
        return None
    sets = TimeSets(case.asked._replace(left_out={}), case.base)
    for one in (Hypothesis.exactly((), case.base, case.asked.parts), *case.tried, accepted):
        if one is not None:
            sets.add(one)
    go_on_to_neighbours(sets)
    first = sets.settle()
    noise = noise_of_best(sets.fitted[()].left, first.left)
    # The smallest that is not beyond doubt worse: what more effects explain may be chance.
    tried = [one for one in sets.likeliest() if _behind(one, first, noise) < SEARCH.decisive]
    best = min(tried, key=lambda one: len(one.effects))
    if len(best.effects) <= fewer or best.fit is None or best.left.misfit:
        return None
    # As for sweeps: of what a machine accepts among others, 99 in 100 are to be told.
    alike = [
        one.key
        for one in sets.likeliest()
        if len(one.effects) == len(best.effects) and _behind(one, best, noise) < SEARCH.decisive
    ]
    worth = {key: -one.cost for key, one in sets.fitted.items()}
    return FoundSet(in_order(best.effects, worth), best.fit, partial(places, alike))


def places(
    rivals: Sequence[tuple[str, ...]], names: Sequence[str]
) -> dict[str | None, tuple[str, ...]]:
    """For each effect of a set, what stands in its place beside the others in sets as large.

    Parameters
    ----------
    rivals : sequence of tuple of str
        Those that are not beyond doubt worse, with itself.
    names : sequence of str
        Of the set.
    """
    alike: dict[str | None, tuple[str, ...]] = {}
    for name in names:
        others = {*names} - {name}
        instead = [set(rival) - others for rival in rivals if others <= set(rival)]
        alike[name] = (name, *sorted(set().union(*instead) - {name}))
    return alike


def _behind(one: Hypothesis, best: Hypothesis, noise: Sequence[ResidualScatter]) -> float:
    """By how much a set explains the tests worse than the best one, over its noise."""
    more = one.left.squares(noise) - best.left.squares(noise)
    count = sum(len(value) for value in best.left.residuals)
    return more + (len(one.theta) - len(best.theta)) * float(np.log(count))


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
    rungs = TimeRungs(tests=tests, effects=effects, accuracy=accuracy, fitted=fitted)
    return climbed(rungs, model, accept, progress, reached, begun)


@dataclass(frozen=True, eq=False, kw_only=True)
class TimeRungs(Rungs[Identification]):
    """Tests of which one at least is in time.

    Attributes
    ----------
    tests : sequence of TimeTest or Measurement
        Of one specimen.
    """

    tests: Sequence[Test]

    def examined(
        self, model: Model, progress: Progress, before: Step | None, effect: Effect | None
    ) -> TimeCase:
        """The examination of a model, by the fit that the rung before has made of it."""
        progress(f"judging {model.name}")
        fits = []
        # The diagnosis has fitted the grown model already, unless only nearly.
        if before is not None and isinstance(before.examined, TimeCase):
            fits.append(before.examined.best_fit)
        base = next(iter(self.fits_of(model, fits)), None)
        if base is not None:
            model = base.model
        return examine(
            self.tests, model, self.effects, base=base, accuracy=self.accuracy, fitted=self.fitted
        )

    def complete_set(self, steps: Sequence[Step]) -> FoundSet[Identification] | None:
        """Several effects that together explain all, where no one does; None without such."""
        *before, last = (step.diagnosis.verdict == "unexplained" for step in steps)
        # Once: what no set explains from there on, none does from a rung that it led to.
        if not last or any(before):
            return None
        return best_set(_case(steps[-1]), 1)

    def decisive(self, steps: Sequence[Step]) -> Effect | None:
        """The effect that the evidence asks for."""
        diagnosis = steps[-1].diagnosis
        first = told_apart(diagnosis) if diagnosis.leading else None
        return first.physics if first else None

    def likeliest_set(self, steps: Sequence[Step]) -> FoundSet[Identification] | None:
        """The likeliest set, begun with the effects accepted one after the other.

        None where there are none, one was enough, or no set explains all.
        """
        accepted = accepted_of(steps)
        for found in self.sets:
            # A set that was taken whole has been held beside all others.
            if key_of(found.effects) == key_of(accepted):
                return found
        if not accepted or (steps[-1].diagnosis.verdict == "adequate" and len(accepted) == 1):
            return None
        first, last = _case(steps[0]), _case(steps[-1]).base
        return best_set(first, 0, Hypothesis.exactly(accepted, last, first.asked.parts))


def _case(step: Step) -> TimeCase:
    return alive(step.examined, TimeCase, f"the step {step.model.name}")
