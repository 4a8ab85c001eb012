"""Missing effects of tests in time, added one by one or as sets, and how far the error falls."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from springpot.diagnosis.grown import go_on_to_neighbours
from springpot.diagnosis.in_practice import Accuracy
from springpot.diagnosis.ladder import Ladder, Reached, Step, climbed, replaced_by, with_rivals
from springpot.diagnosis.result import Fitted, Progress, silent, unseen
from springpot.errors import SpringpotError
from springpot.identification.material import is_material
from springpot.identification.result import Identification
from springpot.plain_data import alive
from springpot.registry import parse_model, plugins
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.thresholds import SEARCH

from .diagnosis import examine
from .fitting import identify
from .left import Left, plain_bic, weight_of
from .residuals_of_tests import Test
from .scatter import ResidualScatter
from .score import TimeScan
from .sieve import EXACT, MARGIN, leading_of_scan, nearly_fitted, noise_of_both
from .specimen import at_tests
from .verdict import AskedTests, TimeCase

MOST = 3
"""Effects of a set at most."""
STARTS = 1
"""Places in the parameters of an effect from which its fit beside others begins."""


@dataclass(frozen=True, eq=False)
class TimeSet:
    """Effects that were fitted together, and what they leave of the tests."""

    effects: tuple[Effect, ...]
    model: Model
    theta: Real
    left: Left
    fit: Identification | None = None

    @property
    def key(self) -> tuple[str, ...]:
        """Their names in alphabetical order."""
        return tuple(sorted(effect.name for effect in self.effects))

    @property
    def cost(self) -> float:
        """Information criterion with how common the effects are."""
        return plain_bic(self.left) - 2.0 * sum(
            float(np.log(weight_of(effect))) for effect in self.effects
        )


@dataclass(frozen=True, eq=False)
class TimeSets:
    """The sets that were fitted so far beside a model of tests in time.

    Attributes
    ----------
    asked : AskedTests
        The tests, and the effects of which sets are made.
    base : Identification
        The fit of the model.
    fitted : dict of tuple of str to TimeSet
        By their names.
    given_up : set of tuple of str
        Sets that cannot be fitted exactly.
    """

    asked: AskedTests
    base: Identification
    fitted: dict[tuple[str, ...], TimeSet] = field(default_factory=dict)
    given_up: set[tuple[str, ...]] = field(default_factory=set)

    def add(self, one: TimeSet) -> None:
        """Take a set up, where it is new or better than the fit of it there is."""
        known = self.fitted.get(one.key)
        if known is None or one.cost < known.cost:
            self.fitted[one.key] = one

    def likeliest(self) -> list[TimeSet]:
        """The likeliest first."""
        return sorted(self.fitted.values(), key=lambda one: one.cost)

    def open(self, near: Sequence[TimeSet]) -> None:
        """Fit sets with one effect more, where there is more than noise to explain."""
        # A linear step foretells little of what goes by no small one: from the likeliest set more
        # are tried.
        likeliest = self.likeliest()[0]
        for one in near:
            if one.left.doubtful:
                self._extend(one, SEARCH.singles if one is likeliest else SEARCH.seconds)

    extend = open
    """Sets with an effect more are all the neighbours that are fitted."""

    def exchange(self, best: TimeSet) -> None:
        """Fit sets with another effect in each place of the best one."""
        for effect in best.effects:
            self._extend(self._without(best, effect), SEARCH.singles)

    def _extend(self, one: TimeSet, most: int) -> None:
        if len(one.effects) >= MOST:
            return
        asked, grown = self.asked, replace(self.base, model=one.model, theta=one.theta)
        names = [effect.name for effect in one.effects]
        new = [
            effect
            for effect in asked.effects
            if tuple(sorted([*names, effect.name])) not in self.fitted
        ]
        promises = TimeScan(grown, asked.quick).promises(new)
        leading = leading_of_scan(promises, one.left)[:most]
        # Beside another effect the scan's first place is near enough; others were tried alone.
        for each in nearly_fitted(
            grown, asked.parts, asked.quick, leading, one.left, {}, starts=STARTS
        ):
            self.add(TimeSet((*one.effects, each.effect), each.model, each.theta, each.left))

    def _without(self, best: TimeSet, effect: Effect) -> TimeSet:
        """The fit of the others, or where they stand in the whole set if that is better."""
        there = self._left_there(best, effect)
        # A fit that is worse was caught in another minimum, and an effect would only mend that.
        return min(self.fitted.get(there.key, there), there, key=lambda one: one.cost)

    def _left_there(self, best: TimeSet, effect: Effect) -> TimeSet:
        """A set without one of its effects, the rest as it is."""
        rest = tuple(other for other in best.effects if other is not effect)
        model = best.model - effect.name
        known = dict(zip(best.model.names, best.theta.tolist(), strict=True))
        theta = model.vector({name: known[name] for name in model.names})
        left = Left.by(model, theta, self.base.reference, self.asked.parts)
        return TimeSet(rest, model, theta, left)

    def settle(self) -> TimeSet:
        """The best set, once those near it and the best of each size are fitted exactly."""
        while True:
            best = self.likeliest()[0]
            near = [one for one in self.likeliest() if one.cost < best.cost + MARGIN]
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

    def _fit_exactly(self, one: TimeSet) -> None:
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
        left = Left.by(fit.model, fit.theta, fit.reference, self.asked.parts)
        self.fitted[one.key] = replace(one, model=fit.model, theta=fit.theta, left=left, fit=fit)


@dataclass(frozen=True, eq=False)
class FoundSet:
    """Effects that explain the tests together.

    Attributes
    ----------
    effects : tuple of Effect
        In the order in which they are to be accepted.
    fit : Identification
        With all of them.
    rivals : tuple of tuple of str
        Sets as large that are not beyond doubt worse, with itself.
    """

    effects: tuple[Effect, ...]
    fit: Identification
    rivals: tuple[tuple[str, ...], ...]

    def places(self) -> dict[str | None, tuple[str, ...]]:
        """For each effect of the set, what may stand in its place."""
        names = [effect.name for effect in self.effects]
        alike: dict[str | None, tuple[str, ...]] = {}
        for name in names:
            others = {*names} - {name}
            instead = [set(rival) - others for rival in self.rivals if others <= set(rival)]
            alike[name] = (name, *sorted(set().union(*instead) - {name}))
        return alike


def complete_set(case: TimeCase) -> FoundSet | None:
    """Several effects that together explain all, where no one does; None without such.

    Parameters
    ----------
    case : TimeCase
        A model, examined.
    """
    if case.asked is None or is_material(case.base.model):
        return None
    sets = TimeSets(case.asked, case.base)
    begin(sets, case)
    return best_set(sets, 1)


def likeliest_set(cases: Sequence[TimeCase]) -> FoundSet | None:
    """The likeliest set, begun with the effects accepted one after the other.

    None where no set explains all.

    Parameters
    ----------
    cases : sequence of TimeCase
        From the user's model to the one with all of them.
    """
    first, last = cases[0], cases[-1].base
    if first.asked is None or is_material(first.base.model):
        return None
    sets = TimeSets(first.asked, first.base)
    begin(sets, first)
    chosen = list(last.model.effects)
    for effect in first.base.model.effects:
        chosen.remove(effect)
    left = Left.by(last.model, last.theta, last.reference, first.asked.parts)
    sets.add(TimeSet(tuple(chosen), last.model, last.theta, left, last))
    found = best_set(sets, 0)
    if found is None:
        return None
    # What stays keeps its rung.
    stay = [effect for effect in chosen if effect in found.effects]
    new = [effect for effect in found.effects if effect not in stay]
    return replace(found, effects=(*stay, *new))


def begin(sets: TimeSets, case: TimeCase) -> None:
    """Take up the model as it is, and with each effect that was fitted."""
    base, asked = case.base, sets.asked
    left = Left.by(base.model, base.theta, base.reference, asked.parts)
    sets.add(TimeSet((), base.model, base.theta, left, base))
    for each in case.tried:
        sets.add(TimeSet((each.effect,), each.model, each.theta, each.left, each.fit))


def best_set(sets: TimeSets, fewer: int) -> FoundSet | None:
    """The smallest set that is as good as any, if it leaves noise alone.

    Parameters
    ----------
    sets : TimeSets
        To begin with.
    fewer : int
        Effects of which a set is none that is looked for.
    """
    go_on_to_neighbours(sets)
    first = sets.settle()
    noise = noise_of_both(sets.fitted[()].left, first.left)
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
    return FoundSet(_in_order(sets, best), best.fit, tuple(alike))


def _behind(one: TimeSet, best: TimeSet, noise: Sequence[ResidualScatter]) -> float:
    """By how much a set explains the tests worse than the best one, over its noise."""
    more = one.left.squares(noise) - best.left.squares(noise)
    count = sum(len(value) for value in best.left.residuals)
    return more + (len(one.theta) - len(best.theta)) * float(np.log(count))


def _in_order(sets: TimeSets, best: TimeSet) -> tuple[Effect, ...]:
    """The effects of a set, the ones first that do most without the others."""
    left, order = list(best.effects), []
    while left:
        # Last is what is missed the least.
        costs = []
        for effect in left:
            key = tuple(sorted(other.name for other in left if other is not effect))
            known = sets.fitted.get(key)
            costs.append(np.inf if known is None else known.cost)
        order.append(left.pop(int(np.argmin(costs))))
    return tuple(order[::-1])


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
