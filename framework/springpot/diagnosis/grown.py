"""What a search has in hand: models grown by effects, and the sets of these worth a refit.

Some of it one sweep cannot tell. Beside any material a gain that goes as omega^e is a phase of
-e pi/2: K omega^e = K (i omega)^e exp(-i e pi/2), and K (i omega)^e is a material again. So a gain
that drifts while it is measured, of a specimen that stiffens, dries or recovers from one end of the
frequencies to the other, looks like a phase that is wrong. And at one amplitude some effects of an
amplitude, which no column tells, are the curve of one that needs none: dry friction is a constant
loss, as hysteresis in a structure is.

Of several effects a first one takes the room of the others, so that one after the other leads
astray. A set has neighbours: one effect more, one less, another one or two in the place of one.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Protocol, TypeAlias, TypeVar

import numpy as np

from springpot.identification.convex import is_passive
from springpot.identification.known_factors import refused_laws
from springpot.identification.leastsquares import Effort
from springpot.measurement.mixed_up import sweeps_of
from springpot.misfit.frame import NoiseFrame
from springpot.misfit.refit import Refit, refit
from springpot.misfit.residual_tests import Battery
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.thresholds import EVIDENCE, SEARCH

from ..numerics import PRINTED
from .scan import (
    PARALLEL,
    Directions,
    Scan,
    Score,
    applicable,
    best_pairs,
    influence,
    scan_effects,
    shifted_twice,
)


@dataclass(frozen=True, eq=False)
class Grown:
    """The fitted model with effects added.

    Attributes
    ----------
    effects : tuple of Effect
        Those added.
    refit : Refit
        The fit.
    predicted : float
        Whitened residual sum of squares that the scan foretold.
    """

    effects: tuple[Effect, ...]
    refit: Refit
    predicted: float

    @property
    def beyond_physics(self) -> list[Effect]:
        """Effects larger than any specimen makes them, at the end of their range, or no law.

        And those of an amplitude that was varied widely, where they do nothing that goes with it.
        """
        units, beyond = self.refit.fit.measurement.units, []
        for effect in self.effects:
            factor, _ = units.of(effect.element.parameters[0].unit)
            too_large = (
                units.is_modulus
                and factor * size_of(self.refit.model, self.refit.theta, effect)
                > effect.largest_of_modulus
            )
            # Constants of a shift trade with each other, and one at its end says nothing of the
            # law.
            ended = effect.plane != "shift" and at_its_limit(self.refit, effect)
            if too_large or ended or effect.name in self.refused or self.is_idle(effect):
                beyond.append(effect)
        return beyond

    def is_idle(self, effect: Effect) -> bool:
        """Whether an effect of the amplitude is none, as fitted, though that went to twice as much.

        A slider that never slips follows the data as a spring would that no effect of the library
        puts there.
        """
        amplitude = self.refit.fit.measurement.points.amplitude
        if "amplitude" not in effect.needs or amplitude is None:
            return False
        return bool(amplitude.max() >= 2.0 * amplitude.min()) and self.same_at_all_amplitudes

    @cached_property
    def refused(self) -> dict[str, str]:
        """What laws do that are none of a material, by their name."""
        return {effect.name: does for effect, does in refused_laws(self.refit.fit)}

    @cached_property
    def same_at_all_amplitudes(self) -> bool:
        """Whether effects of the amplitude do nothing, as fitted, that goes with it.

        A slider that never slips.

        Then it is a spring, and a part of the material by its true name.
        """
        points = self.refit.fit.measurement.points
        if points.amplitude is None:
            return False
        at_one_amplitude = points.at_amplitude(
            np.full_like(points.amplitude, np.median(points.amplitude))
        )
        moved = self.refit.stiffness - self.refit.model.stiffness(
            self.refit.theta, at_one_amplitude
        )
        noise = self.refit.noise.sd
        # As fits are compared: what changes chi-square by less than its own scatter of one is not
        # seen.
        return float(np.sum((moved.real / noise.real) ** 2 + (moved.imag / noise.imag) ** 2)) < 1.0

    @property
    def broadens_an_order(self) -> bool:
        """Whether one part with its own time or order joins a model that has an order already.

        A springpot has a broad and symmetric spectrum. What such a model lacks may be that the
        material's is skewed (Havriliak and Negami 1967, doi:10.1016/0032-3861(67)90021-3): one mode
        or springpot more follows that.
        """
        (effect,) = self.effects
        model = self.refit.model
        others = list(model.effects)
        others.remove(effect)
        own = [
            *model.material.parameters,
            *(each for other in others for each in other.element.parameters),
        ]
        return len(effect.element.parameters) > 1 and any(parameter.is_order for parameter in own)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the effects added."""
        return tuple(effect.name for effect in self.effects)

    @property
    def key(self) -> tuple[str, ...]:
        """The same in alphabetical order, whatever was added first."""
        return key_of(self.effects)


def key_of(effects: Iterable[Effect]) -> tuple[str, ...]:
    """The names of a set in alphabetical order, whatever was added first."""
    return tuple(sorted(effect.name for effect in effects))


def size_of(model: Model, theta: Real, effect: Effect) -> float:
    """The size of an effect in a fitted model; of one that was added twice, that of the second."""
    return effect.own_of(model.named(theta)).get(effect.element.parameters[0].name, 0.0)


def at_its_limit(fitted: Refit, effect: Effect) -> bool:
    """Whether the size of an effect rests on a bound at which it does not vanish.

    More of it than physics knows.

    What follows the data only there does so by its shape alone, as a modulus that would go as T^20.
    """
    size = effect.element.parameters[0]
    value = size_of(fitted.model, fitted.theta, effect)
    ends = [
        end for end in (size.lower, size.upper) if np.isfinite(end) and end != effect.vanishes_at
    ]
    return any(abs(value - end) <= SEARCH.near_an_end * abs(end) for end in ends)


@dataclass(eq=False)
class Search:
    """A model's fit, the scan of the library on it, and the grown models that were fitted.

    Attributes
    ----------
    base : Refit
        The user's model.
    frame : NoiseFrame
        Its linear geometry.
    scan : Scan
        Scores of the library.
    structure : Battery
        The test for structure of any kind in its residual.
    grown : list of Grown
        Grown models, the best evidence first.
    left : Battery
        The test on the residual of the best model.
    repeats : Battery
        The test on the scatter of repeats.
    confounded : list of Grown
        Models grown by effects of a condition that was not varied by itself and that explain the
        data as well as any other, the best evidence first.
    promoted : frozenset of str
        Effects of such a condition that are judged all the same, as nothing else explains the data.
    """

    base: Refit
    frame: NoiseFrame
    scan: Scan
    structure: Battery
    grown: list[Grown] = field(default_factory=list)
    left: Battery = field(default_factory=lambda: Battery(1.0, {}))
    repeats: Battery = field(default_factory=lambda: Battery(1.0, {}))
    confounded: list[Grown] = field(default_factory=list)
    promoted: frozenset[str] = frozenset()

    @property
    def best(self) -> Refit:
        """The model with the best evidence, the base included."""
        refits = [self.base, *(grown.refit for grown in self.grown)]
        return max(refits, key=lambda refit: refit.log_evidence)

    @property
    def alarm(self) -> float:
        """Chance that noise alone gives such a score or such structure, whichever is rarer."""
        return min(self.scan.p_value, self.structure.p_value)

    @property
    def gain(self) -> float:
        """Drop of the information criterion that the best model brings."""
        return 2.0 * (self.best.log_evidence - self.base.log_evidence)


LARGEST = 0.5
"""Drift from first to last row, as a logarithm, beyond which nobody calls the rows one sweep."""


@dataclass(frozen=True)
class SweepDrift:
    """A drifting gain that explains the data in an effect's place.

    Attributes
    ----------
    effect : str
        The effect.
    share : float
        By how much the gain grows from the first row to the last, relative to it.
    """

    effect: str
    share: float

    @property
    def says(self) -> str:
        """As the last of a row of names."""
        return f"a gain that drifts by {100.0 * self.share:.2g} % while the sweep is measured"


def drift_in_place(search: Search) -> SweepDrift | None:
    """The effect of the best grown model in whose place a drifting gain explains the data as well.

    None without one.

    Asked only of one sweep from one end of the frequencies to the other.

    Parameters
    ----------
    search : Search
        A finished search.
    """
    data, grown = search.base.data.raw, search.grown
    steps = np.diff(data.omega)
    one_way = bool(np.all(steps > 0) or np.all(steps < 0))
    if not grown or not one_way or len(sweeps_of(data)) > 1:
        return None
    best = grown[0]
    as_good = best.refit.fair_rss + 2.0 * EVIDENCE.as_good
    least, likeliest = as_good, None
    # A drift is slow: what is narrow is nothing that it could stand for.
    for effect in [effect for effect in best.effects if not effect.narrow]:
        share, rss = _drifting(_without(search, effect.name))
        # As many parameters as an effect of one; one of more would have to explain more to be
        # preferred.
        nearer = rss <= as_good and (likeliest is None or rss < least)
        if nearer and abs(share) > PRINTED:
            least, likeliest = rss, SweepDrift(effect.name, share)
    return likeliest


def _without(search: Search, effect: str) -> Refit:
    """The fit of the best grown model's other effects alone."""
    others = [name for name in search.grown[0].names if name != effect]
    alone = (grown.refit for grown in search.grown if list(grown.names) == others)
    return next(alone, search.base)


def _drifting(before: Refit) -> tuple[float, float]:
    """Drift of the gain with which a fit follows the data best, and the whitened squares left."""
    from scipy.optimize import minimize_scalar  # a diagnosis that never asks must not wait for it

    mean = before.data.mean
    time = np.linspace(0.0, 1.0, len(mean))

    def left(drift: float) -> float:
        undone = replace(mean, stiffness=mean.stiffness * np.exp(-drift * time))
        data = replace(before.data, raw=undone, mean=undone)
        return refit(before.model, data, before.noise, [before.theta], starts=0).fair_rss

    best = minimize_scalar(
        left, bounds=(-LARGEST, LARGEST), method="bounded", options={"xatol": PRINTED}
    )
    return float(np.expm1(best.x)), float(best.fun)


Seek: TypeAlias = Callable[[Refit, Sequence[Effect], np.random.Generator], Search]
"""Looks for what is missing from a fitted model among some effects."""


COLUMN = "amplitude"


@dataclass(frozen=True)
class Untold:
    """Effects in whose place another one is named, as their amplitude is not known.

    Attributes
    ----------
    effect : str
        The one that is named.
    others : tuple of str
        Those that may be it as well.
    """

    effect: str
    others: tuple[str, ...]

    @property
    def says(self) -> str:
        """As the last of a row of names."""
        names = " or ".join(self.others)
        return f"{names}, the same curve at one {COLUMN}, which no column tells"


def untold_in_place(search: Search, library: Sequence[Effect]) -> Untold | None:
    """The effect of the best grown model whose curve effects of an untold amplitude have too.

    None where the amplitude is told, or nothing is alike. A part of a material is one whatever the
    amplitude: nobody looks for a spring that stiffens where a spring is missing.

    Parameters
    ----------
    search : Search
        A finished search.
    library : sequence of Effect
        All that may be missing.
    """
    base, data = search.base, search.base.fit.measurement
    if COLUMN in data.conditions or not search.grown:
        return None
    held = replace(data, conditions={**data.conditions, COLUMN: np.ones(len(data))})
    # Of one parameter, its size: a law of more makes nearly any curve.
    others = [
        effect
        for effect in applicable(library, held)
        if COLUMN in effect.needs and len(effect.element.parameters) == 1
    ]
    frame = search.frame
    for named in [effect for effect in search.grown[0].effects if not is_passive(effect)]:
        at = influence(base.model, base.theta, base.stiffness, named, data)
        own = Directions.of(frame, at).unit
        alike = []
        # A rarer one is no reason to doubt: a clock is wrong more often than a joint has play.
        for other in [effect for effect in others if effect.prior >= named.prior]:
            there = influence(base.model, base.theta, base.stiffness, other, held)
            unit = Directions.of(frame, there).unit
            if np.max(own.T @ unit, initial=0.0) > PARALLEL:
                alike.append(other.name)
        if alike:
            return Untold(named.name, tuple(alike))
    return None


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
        return key_of(self.effects)

    def joined(self, other: AskedSet) -> AskedSet:
        """The same set with the starts of both."""
        starts, predicted = [*self.starts, *other.starts], min(self.predicted, other.predicted)
        return replace(
            self, starts=starts, read_off=max(self.read_off, other.read_off), predicted=predicted
        )

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
        asked.append(AskedSet((*present, *both), pair.model, [pair.start], 2, predicted))
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
    search: Search, grown: Grown, effects: Sequence[Effect], two_too: bool = True
) -> Iterator[AskedSet]:
    """Sets with another effect or two in the place of one, the best at first sight; see above."""
    for place in _places(search, grown, effects):
        both = (place.standing, place.near), (place.fitted, place.afar)
        two = [
            asked
            for fitted, scores in both
            if two_too
            for asked in two_more(place.rest, fitted, fitted.frame(), scores)
        ]
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
    standing, fitted : Refit
        These as they stand in the set, and fitted anew: they take the place as far as they can, and
        what could stand there is seen from afar.
    near, afar : list of Score
        What may stand there, seen beside the others as they stand and as they are fitted anew.
    """

    rest: tuple[Effect, ...]
    standing: Refit
    fitted: Refit
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
        standing, fitted = _standing(grown, effect), _lacking(search, grown, i)
        near, afar = (scanned_beside(rest, one, others) for one in (standing, fitted))
        yield _Place(rest, standing, fitted, near, afar)


def _standing(grown: Grown, effect: Effect) -> Refit:
    """A fitted set as it stands without one of its effects."""
    model, theta = without_one(grown.refit.model, grown.refit.theta, effect)
    left = replace(grown.refit, fit=replace(grown.refit.fit, model=model, theta=theta))
    residual = left.frame().residual
    return replace(left, fit=replace(left.fit, cost=float(residual @ residual)))


def without_one(model: Model, theta: Real, effect: Effect) -> tuple[Model, Real]:
    """A model without an effect of a set that it has, and the parameters (p,) that are left."""
    less = model - effect.name
    return less, less.picked(model.named(theta))


def _from_there(grown: Grown, asked: Sequence[AskedSet]) -> Iterator[AskedSet]:
    """Sets that also begin with the values that they share with another, fitted one."""
    known = grown.refit.model.named(grown.refit.theta)
    for each in asked:
        start = each.model.picked(each.model.named(each.starts[0]) | known)
        yield replace(each, starts=[*each.starts, start])


def _lacking(search: Search, grown: Grown, i: int) -> Refit:
    """The fit of a set without one of its effects, which joins the search."""
    rest = (*grown.effects[:i], *grown.effects[i + 1 :])
    if not rest:
        return search.base
    key = key_of(rest)
    # As found so far: the best of several fits, where it was grown in several ways.
    known = [one.refit for one in search.grown if one.key == key]
    if known:
        return max(known, key=lambda one: one.log_evidence)
    model, start = without_one(grown.refit.model, grown.refit.theta, grown.effects[i])
    fitted = refit(model, search.base.data, search.base.noise, [start], starts=2)
    search.grown.append(Grown(rest, fitted, fitted.rss))
    return fitted


class OneSet(Protocol):
    """Effects that were fitted together."""

    @property
    def key(self) -> tuple[str, ...]:
        """Their names in alphabetical order."""


S = TypeVar("S", bound=OneSet)


class Sets(Protocol[S]):
    """The sets that were fitted so far, and how others are."""

    def likeliest(self) -> list[S]:
        """One fit of each set, the likeliest first."""

    def open(self, near: Sequence[S]) -> None:
        """Fit the neighbours of some sets."""

    def extend(self, near: Sequence[S]) -> None:
        """Fit sets with one effect more than some."""

    def exchange(self, best: S) -> None:
        """Fit whatever may stand in a place of the best set."""


MOST_TOGETHER = 4
"""Effects sought together at most: more of them follow any misfit."""


def go_on_to_neighbours(sets: Sets[S]) -> None:
    """Go on to sets that are neighbours of the best, until none is better.

    Nor the likeliest that lacks one of its effects, with another: one that imitates several is in
    all of the likeliest, and what it stands for would never be asked.

    Parameters
    ----------
    sets : Sets
        With those to begin with.
    """
    opened: set[tuple[str, ...]] = set()
    extended: set[tuple[str, ...]] = set()
    exchanged: set[tuple[str, ...]] = set()
    while near := sets.likeliest()[: SEARCH.beam]:
        best = near[0]
        if new := [one for one in near if one.key not in opened]:
            opened.update(one.key for one in new)
            sets.open(new)
        elif best.key not in exchanged:
            exchanged.add(best.key)
            sets.exchange(best)
        elif without := _likeliest_without_each(sets, opened | extended):
            extended.update(one.key for one in without)
            sets.extend(without)
        else:
            break


def _likeliest_without_each(sets: Sets[S], known: Container[tuple[str, ...]]) -> list[S]:
    """For each effect of the best set the likeliest one without it, where that is not known."""
    best, *others = sets.likeliest()
    lacking = (next((one for one in others if name not in one.key), None) for name in best.key)
    return list({one.key: one for one in lacking if one and one.key not in known}.values())
