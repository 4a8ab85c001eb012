"""What the evidence says.

How likely each explanation is, and which effects the data cannot tell apart.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from springpot.identification.convex import is_passive
from springpot.measurement.independence import at_one_frequency
from springpot.misfit.frame import NoiseFrame
from springpot.misfit.refit import Refit, refit
from springpot.numerics import NEGLIGIBLE, ROUNDING, SMALLEST, rms
from springpot.rheology.effect import Effect
from springpot.rheology.points import Real
from springpot.thresholds import EVIDENCE

from .grown import Grown, Search, SweepDrift, Untold, drift_in_place, untold_in_place
from .marginal import (
    Unknown,
    credible,
    fault_beside,
    harmonic_evidence,
    is_a_limit,
    left_unknown,
    marginal,
    unknown_marginal,
)

ONE_CASE = 1e-4
"""Chi-square a point, beside exact curves, below which one law is a case of another."""


@dataclass(frozen=True, eq=False)
class Explanation:
    """One answer to what is missing: just these effects.

    Attributes
    ----------
    grown : Grown
        The best fitted model that has them.
    probability : float
        That they, and nothing else, are missing.
    """

    grown: Grown
    probability: float

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of its effects in order; one that is missing twice stands twice."""
        return tuple(sorted(self.grown.names))

    @property
    def twice(self) -> bool:
        """Whether one effect is not enough of itself.

        Two modes may stand for a broad spectrum as well.
        """
        return len(set(self.names)) < len(self.names)

    @property
    def one_spectrum(self) -> bool:
        """Whether parts of a material are put together.

        A spectrum of another shape may stand for them all.
        """
        if len(self.names) == 1 and not self.grown.broadens_an_order:
            return False
        others = [effect for effect in self.grown.effects if not is_passive(effect)]
        # What moves with the amplitude, but as fitted does not, is a spring by another name.
        of_amplitude = all("amplitude" in effect.needs for effect in others)
        return not others or (of_amplitude and self.grown.same_at_all_amplitudes)


@dataclass(frozen=True, eq=False)
class Evidence:
    """Probabilities of what is missing, and what follows from them.

    Attributes
    ----------
    search : Search
        The fitted models behind them.
    nothing : float
        That the model is complete.
    unknown : float
        That something is missing which no effect of the library explains.
    explanations : tuple of Explanation
        Sets of effects that were tried, the likeliest first.
    imitators : frozenset of str
        Effects whose place something else as narrow may hold.
    leaning : frozenset of str
        Effects that the data ask for only in the company of such a one.
    beside_material : bool
        Whether they are sought beside a free spectrum because the user's model cannot follow the
        material.
    moved : frozenset of str
        Effects of a condition that was not varied by itself, judged as nothing else explains the
        data.
    drift : SweepDrift or None
        A gain that drifts while the sweep is measured, where it explains the data as well as one of
        the effects.
    untold : Untold or None
        Effects of an amplitude that no column tells, where one of the effects has their curve.
    by_itself : float
        The unknown before it was asked what the best model leaves, or what no specimen reaches:
        that such a thing explains more than the effects do.
    fault : Unknown or None
        The fault of the measuring chain that explains what the leading effect leaves better than
        any second effect does.
    """

    search: Search
    nothing: float
    unknown: float
    explanations: tuple[Explanation, ...]
    imitators: frozenset[str] = frozenset()
    leaning: frozenset[str] = frozenset()
    beside_material: bool = False
    moved: frozenset[str] = frozenset()
    drift: SweepDrift | None = None
    untold: Untold | None = None
    by_itself: float = 0.0
    fault: Unknown | None = None

    @classmethod
    def of(cls, search: Search, beside_material: bool = False) -> Evidence:
        """Weigh the fitted models by marginal likelihoods and the prior weights of their effects.

        Parameters
        ----------
        search : Search
            A finished search.
        beside_material : bool
            Whether a part of the material is missing already.
        """
        tried = one_for_each_set(search.grown)
        logs = _log_weights(search, tried)
        prior = log_prior_of_one(size_of_scanned(search))
        weights, unknown = chances_of(logs, unknown_marginal(search) + prior)
        pairs = list(zip(tried, weights[1:].tolist(), strict=True))
        # What fits best only beyond what any specimen reaches tells that something is missing, but
        # not its name.
        impossible = sum(weight for grown, weight in pairs if grown.beyond_physics)
        explanations = [
            Explanation(grown, 0.0 if grown.beyond_physics else weight) for grown, weight in pairs
        ]
        by_itself, unknown = unknown, min(unknown + impossible, 1.0 - ROUNDING)
        explanations.sort(key=lambda one: -one.probability)
        explanations, fault = _beside_a_fault(search, explanations)
        # What needs a condition that was not varied by itself shares the place of the likeliest
        # explanation: that it fits as well or better is no evidence, as the data cannot tell the
        # two apart.
        if explanations and search.confounded:
            explanations[:1] = _shared(explanations[0], search.confounded)
        # Of all grown models, likely or not: each was tried because nothing simple explained the
        # data.
        imitators = frozenset(
            effect.name for grown in search.grown for effect in grown.effects if effect.narrow
        )
        return cls(
            search,
            nothing=float(weights[0]),
            unknown=unknown,
            by_itself=by_itself,
            fault=fault,
            explanations=tuple(explanations),
            imitators=imitators,
            leaning=_leaning(tried, logs, imitators),
            beside_material=beside_material,
            moved=search.promoted,
        )

    @property
    def one_frequency(self) -> bool:
        """Whether storage and loss are one curve each, along an amplitude or a temperature."""
        return at_one_frequency(self.search.base.fit.measurement)

    @cached_property
    def effects(self) -> dict[str, float]:
        """For each effect, that it is among what is missing."""
        chances: dict[str, float] = {}
        for one in self.explanations:
            for name in set(one.names):
                share = 1.0
                # Before the imitators: the same doubt is not to be charged twice.
                if self._is_patchwork(one):
                    share -= EVIDENCE.other_shape
                elif self._is_imitated(one):
                    share = self.trust(name)
                chances[name] = chances.get(name, 0.0) + one.probability * share
        return chances

    @property
    def narrow(self) -> float:
        """That something narrow is missing which only looks like an effect of the library."""
        return EVIDENCE.other_shape * sum(
            one.probability
            for one in self.explanations
            if self._is_imitated(one) and not self._is_patchwork(one)
        )

    @property
    def other_shape(self) -> float:
        """Probability that an explanation of several pieces stands for something else.

        Such explanations take one effect twice, two beside a part of the material, or a condition.
        """
        return EVIDENCE.other_shape * sum(
            one.probability for one in self.explanations if self._is_patchwork(one)
        )

    def _is_patchwork(self, one: Explanation) -> bool:
        """Whether an explanation puts together what may be one thing of another shape.

        A spectrum and two effects beside it follow any slow error of storage and of loss, and two
        parts of a material nearly any material; two effects at one frequency follow nearly any two
        curves along the amplitude; what goes with an amplitude that moved with the frequency may as
        well go with the frequency, what a drift explains, with time, and what effects of an untold
        amplitude are, with that.
        """
        moved = not self.moved.isdisjoint(one.names)
        drifted = self.drift is not None and self.drift.effect in one.names
        untold = self.untold is not None and self.untold.effect in one.names
        several_beside = len(one.names) > 1 and (self.beside_material or self.one_frequency)
        return one.twice or one.one_spectrum or moved or drifted or untold or several_beside

    def _is_imitated(self, one: Explanation) -> bool:
        """Whether something else as narrow may hold the place of one of its effects."""
        return not self.imitators.isdisjoint(one.names)

    def trust(self, name: str) -> float:
        """Chance that what looks like an effect is that effect."""
        if name in self.imitators | self.leaning:
            return 1.0 - EVIDENCE.other_shape
        return 1.0

    @cached_property
    def rest(self) -> Unknown | None:
        """What the misfit that the best effects leave looks like; None without a description."""
        return self.fault or left_unknown(self.search)

    def beside_drift(self) -> Evidence:
        """The same, having asked whether a drifting gain explains as much as the best model."""
        return replace(self, drift=drift_in_place(self.search))

    def beside_untold(self, library: Sequence[Effect]) -> Evidence:
        """The same, having asked which effects of an untold amplitude are the named one's curve."""
        return replace(self, untold=untold_in_place(self.search, library))

    def doubted(self, p_value: float) -> Evidence:
        """The same, where what the best model leaves has this chance of being noise."""
        return self._with_unknown(doubted(self.unknown, p_value))

    def without_unknown(self) -> Evidence:
        """The same, taking for granted that the library explains what is missing."""
        return self._with_unknown(0.0)

    def _with_unknown(self, unknown: float) -> Evidence:
        share = (1.0 - unknown) / max(1.0 - self.unknown, SMALLEST)
        # All by one factor: what the unknown takes says nothing of which known explanation is
        # right.
        scaled = tuple(
            replace(one, probability=one.probability * share) for one in self.explanations
        )
        return replace(self, nothing=self.nothing * share, unknown=unknown, explanations=scaled)

    @cached_property
    def leader(self) -> str:
        """The effect to name first: of the likeliest explanation, the one that does most alone."""
        alone = {
            each.names[0]: each.refit.log_evidence
            for each in self.search.grown
            if len(each.effects) == 1
        }
        likeliest = self.explanations[0]
        return max(likeliest.names, key=lambda name: alone.get(name, -np.inf))

    @cached_property
    def rivals(self) -> dict[str, float]:
        """Effects that could stand in the leading one's place, with their chances.

        Of sets of as many effects, whatever stands in the other places; and of fewer, one alone.
        """
        best = self.explanations[0].names
        place = best.index(self.leader)
        partners = [*best[:place], *best[place + 1 :]]
        chances = dict(self.stand_ins(best)[place])
        for one in self.explanations:
            if len(one.names) < len(best):
                alone = one.names[0]
                chances.setdefault(alone, 0.0)
                # A partner stays whoever leads: alone it is no rival of the leader.
                if alone not in partners:
                    chances[alone] += one.probability
        return chances

    @cached_property
    def partners(self) -> dict[str, float]:
        """Effects one of which is missing beside the leading one, with their chances.

        None where that may be all.
        """
        with_leader = [one for one in self.explanations if self.leader in one.names]
        chances: dict[str, float] = {}
        for one in with_leader:
            if len(one.names) == 2:
                (partner,) = without(one.names, [self.leader])
                chances[partner] = chances.get(partner, 0.0) + one.probability
        # Where the leader alone is still likely, a partner in the headline would be one too many.
        enough = EVIDENCE.beside * sum(one.probability for one in with_leader)
        if sum(chances.values()) <= enough:
            return {}
        best = self.explanations[0].names
        if len(best) == 2:
            # Beside whatever stands in the leader's place, as that may be another.
            return self.stand_ins(best)[1 - best.index(self.leader)]
        return chances

    @cached_property
    def instead(self) -> tuple[str, ...]:
        """Several effects that may be missing together in place of the likeliest fewer.

        Empty where such sets hold less than what no class needs to hold.
        """
        best, alike = self.explanations[0].names, credible(self.rivals)
        others = [
            one
            for one in self.explanations
            if len(one.names) > len(best) and set(one.names).isdisjoint(alike)
        ]
        if sum(one.probability for one in others) <= 1.0 - EVIDENCE.credible:
            return ()
        return others[0].names

    def stand_ins(self, names: Sequence[str], of_any_size: bool = False) -> list[dict[str, float]]:
        """For each effect of a set, what may stand in its place, with their chances.

        In sets `of_any_size` two may stand in the place of one, and one in that of two.
        """
        chances: list[dict[str, float]] = [{} for _ in names]
        sets = [one for one in self.explanations if of_any_size or len(one.names) == len(names)]
        # Those first that differ in one place: they tell whose place it is where two differ.
        for one in sorted(sets, key=lambda one: len(without(one.names, names))):
            for place, other in _paired(names, one.names, chances):
                chances[place][other] = chances[place].get(other, 0.0) + one.probability
        return chances

    def same_curve(self, names: Sequence[str], of_any_size: bool = False) -> list[list[str]]:
        """For each effect of a set, others whose curve in its place is the same for these data.

        However much dearer their parameters are, as long as they are what they are called: a law at
        its limit, or one that contains the other, is the simpler one by another name. In sets
        `of_any_size` several may stand in the place of one of as many parameters.
        """
        key = tuple(sorted(names))
        best = next((one.grown.refit for one in self.explanations if one.names == key), None)
        alike: list[list[str]] = [[] for _ in names]
        for one in self.explanations:
            new, place = without(one.names, names), without(names, one.names)
            if best is None or len(place) != 1 or not new:
                continue
            other = one.grown.refit
            if len(new) > 1 and not (of_any_size and len(other.own) <= len(best.own)):
                continue
            near = distance(self.search.frame, other, best) < EVIDENCE.one_curve
            near = near and _as_good(other, best)
            known = one.grown.beyond_physics or is_a_limit(self.search, one.grown)
            if near and not known and not _contains(other, best):
                alike[list(names).index(place[0])] += new
        return alike

    def places(self, names: Sequence[str]) -> dict[str | None, tuple[str, ...]]:
        """For each effect of a set, what may stand in its place in sets of any size."""
        chances = self.stand_ins(names, of_any_size=True)
        alike = self.same_curve(names, of_any_size=True)
        return {
            name: tuple(dict.fromkeys([*credible(own, EVIDENCE.unasked), *others]))
            for name, own, others in zip(names, chances, alike, strict=True)
        }

    @property
    def beside(self) -> list[str]:
        """The fewest partners that hold nearly all of their probability, the likeliest first.

        Then those whose curve is the same.
        """
        partners = credible(self.partners)
        best = self.explanations[0].names
        if partners and len(best) == 2:
            alike = self.same_curve(best)[1 - best.index(self.leader)]
            # A second one of the leader is told where it is likely, not where it only could be.
            partners += [name for name in alike if name not in {self.leader, *partners}]
        return partners

    @cached_property
    def classes(self) -> list[list[str]]:
        """Effects that these data cannot tell apart, the likeliest class first.

        The first class is the smallest set of rivals that holds nearly all of their probability,
        the next that of what is missing beside them; the rest are grouped by their curves.
        """
        if not self.explanations:
            return []
        first, best = credible(self.rivals), self.explanations[0].names
        alike = self.same_curve(best)[best.index(self.leader)]
        first += [name for name in alike if name not in first]
        second = [name for name in self.beside if name not in first]
        ranked = sorted(best_with(self.search), key=lambda name: -self.effects.get(name, 0.0))
        others = [name for name in ranked if name not in {*first, *second}]
        return [first, *([second] if second else []), *_grouped(self.search, others)]

    def likeliest_with(self) -> dict[str, Refit]:
        """For each effect, the likeliest of the fitted models that have it."""
        chosen: dict[str, Refit] = {}
        for one in self.explanations:
            for name in one.grown.names:
                chosen.setdefault(name, one.grown.refit)
        return chosen

    def grown_beside(self, names: Iterable[str]) -> dict[str, Grown]:
        """For each effect, the best fitted model that has just it and the leading one."""
        partner_of = {tuple(sorted((self.leader, name))): name for name in names}
        chosen: dict[str, Grown] = {}
        for grown in self.search.grown:
            if grown.key in partner_of:
                chosen.setdefault(partner_of[grown.key], grown)
        return chosen


def _contains(wider: Refit, fitted: Refit) -> bool:
    """Whether a model of more parameters makes the very curve of another: that is a case of it."""
    if len(wider.own) <= len(fitted.own):
        return False
    exact = replace(fitted.data.mean, stiffness=fitted.stiffness)
    data = replace(fitted.data, raw=exact, mean=exact)
    start = wider.seed_from(fitted)
    again = refit(wider.model, data, fitted.noise, [start, wider.theta], starts=2)
    # By much less than any data could show.
    return again.rss < ONE_CASE * len(exact)


def _as_good(fitted: Refit, best: Refit) -> bool:
    """Whether a fit explains data and harmonics nearly as well as another."""
    here, there = (one.log_likelihood + harmonic_evidence(one) for one in (fitted, best))
    return here > there - EVIDENCE.as_good


def _log_weights(search: Search, tried: Sequence[Grown]) -> Real:
    """Log marginal likelihood times prior (1 + m,).

    Of the model as it is, then of each of m grown models.
    """
    complete = (
        search.base.log_likelihood + harmonic_evidence(search.base) + np.log(EVIDENCE.prior_nothing)
    )
    library = size_of_scanned(search)
    return np.array(
        [complete, *(marginal(search, grown) + log_prior(grown, library) for grown in tried)]
    )


def chances_of(logs: Real, log_unknown: float = -np.inf) -> tuple[Real, float]:
    """Probabilities (1 + m,) of what is known, and that of the unknown, which sum to one."""
    # The unknown is kept out of the sum first: beside it the rest may be too small for a
    # floating-point number.
    weights = np.exp(logs - logs.max())
    # Within the exponents that a floating-point number has.
    odds = float(np.exp(np.clip(log_unknown - logs.max() - np.log(np.sum(weights)), -700, 700)))
    unknown = min(odds / (1.0 + odds), 1.0 - ROUNDING)
    weights *= (1.0 - unknown) / np.sum(weights)
    return weights, unknown


def _leaning(tried: Sequence[Grown], logs: Real, imitators: frozenset[str]) -> frozenset[str]:
    """Effects that only help beside a resonance.

    They may mend the wrong shape of it, and share that one's doubt.
    """
    by_itself = set()
    for grown, log in zip(tried, logs[1:], strict=True):
        if len(grown.effects) == 1 and log >= logs[0]:
            by_itself.add(grown.names[0])
    return frozenset(name for grown in tried for name in grown.names) - by_itself - imitators


def size_of_scanned(search: Search) -> float:
    """Sum of the prior weights of the effects of a search's scan."""
    return size_of_library(score.influence.effect for score in search.scan.scores)


def size_of_library(effects: Iterable[Effect]) -> float:
    """Sum of the prior weights of the effects that were scanned.

    One that these data cannot show takes no share.
    """
    return max(sum(effect.prior for effect in effects), 1.0)


def log_prior_of_one(library: float) -> float:
    """Log prior of one common effect of a library, and so of something without a name."""
    return float(np.log((1.0 - EVIDENCE.prior_nothing) / library))


def unknown_odds(p_value: float) -> float:
    """Odds for something unknown, where what the best model leaves has this chance of being noise.

    Those before the test, times the most that such a chance can speak for it (Sellke, Bayarri and
    Berger 2001, doi:10.1198/000313001300339950).
    """
    # The bound holds below 1/e only; and the logarithm of a chance of zero would make the unknown
    # certain.
    p_value = min(max(p_value, ROUNDING), float(np.exp(-1.0)))
    return float(EVIDENCE.outside / (1.0 - EVIDENCE.outside) / (-np.e * p_value * np.log(p_value)))


def doubted(unknown: float, p_value: float) -> float:
    """Chance of something unknown, where what the best model leaves has this chance of being noise.

    Little if it is none of these; see `unknown_odds`. Never less than the evidence says by itself:
    a test that sees nothing does not make it known.
    """
    odds = unknown_odds(p_value)
    return max(unknown, odds / (1.0 + odds))


def without(names: Sequence[str], others: Sequence[str]) -> list[str]:
    """Names that are left when each of the others has taken one of its name away."""
    left = list(names)
    for name in others:
        if name in left:
            left.remove(name)
    return left


def _beside_a_fault(
    search: Search, explanations: list[Explanation]
) -> tuple[list[Explanation], Unknown | None]:
    """The same, the likeliest first, where a fault of the chain may hold a second effect's place.

    A calibration of each sweep is followed by effects of the amplitude too, and worse.
    """
    if not explanations or len(explanations[0].names) < 2:
        return explanations, None
    best = explanations[0]
    alone = [one for one in explanations if len(one.names) == 1 and one.names[0] in best.names]
    first = max(alone, key=lambda one: one.grown.refit.log_evidence, default=None)
    found = first and fault_beside(search, first.grown)
    if not first or not found:
        return explanations, None
    fault, gain = found
    second = marginal(search, best.grown) - marginal(search, first.grown)
    # Where the two are as good as each other, the effect has a law and the fault has none.
    if gain < second + EVIDENCE.as_good:
        return explanations, None
    taken = [one for one in explanations if len(one.names) > 1 and first.names[0] in one.names]
    whole = first.probability + sum(one.probability for one in taken)
    others = [
        replace(one, probability=0.0) if one in taken else one
        for one in explanations
        if one is not first
    ]
    return [replace(first, probability=whole), *others], fault


def _shared(likeliest: Explanation, confounded: Sequence[Grown]) -> list[Explanation]:
    """The likeliest explanation and those that may stand in its place, none of them likelier."""
    best = likeliest.grown.refit.log_evidence
    # At most even odds: an effect of a condition that was not varied by itself fits better for no
    # reason of its own.
    odds = [float(np.exp(min(each.refit.log_evidence - best, 0.0))) for each in confounded]
    share = likeliest.probability / (1.0 + sum(odds))
    others = [Explanation(each, share * odd) for each, odd in zip(confounded, odds, strict=True)]
    return [
        replace(likeliest, probability=share),
        *sorted(others, key=lambda one: -one.probability),
    ]


def log_prior(grown: Grown, library: float) -> float:
    """Log prior of a set of effects.

    Of one half, each by its share in the library, and a second one by half.
    """
    prior = (1.0 - EVIDENCE.prior_nothing) * EVIDENCE.prior_pair ** (len(grown.effects) - 1)
    for effect in grown.effects:
        prior *= effect.prior / library
    prior *= EVIDENCE.beyond_physics ** len(grown.beyond_physics)
    return float(np.log(max(prior, SMALLEST)))


def one_for_each_set(grown: Sequence[Grown]) -> list[Grown]:
    """The best model for each set of effects: the order of adding them does not matter."""
    best: dict[tuple[str, ...], Grown] = {}
    # In a fixed order and by more than rounding, so that two orders of adding an effect cannot
    # change the answer.
    for each in sorted(grown, key=lambda one: one.names):
        known = best.get(each.key)
        if known is None or each.refit.log_evidence > known.refit.log_evidence + NEGLIGIBLE:
            best[each.key] = each
    return list(best.values())


def _paired(
    names: Sequence[str], others: Sequence[str], known: Sequence[Mapping[str, float]]
) -> Iterator[tuple[int, str]]:
    """Each place of a set with the effect of another set that stands in it.

    Of more effects than places that differ, several stand in one place.
    """
    new, differ = list(others), []
    for place, name in enumerate(names):
        if name in new:
            new.remove(name)
            yield place, name
        else:
            differ.append(place)
    empty = list(differ)
    while new and differ:
        # Where it is likeliest by itself.
        pairs = [(place, other) for place in empty for other in new]
        place, other = max(pairs, key=lambda pair: known[pair[0]].get(pair[1], 0.0))
        empty.remove(place)
        new.remove(other)
        yield place, other
        empty = empty or list(differ)


def best_with(search: Search) -> dict[str, Refit]:
    """For each effect, the best fitted model that has it."""
    best: dict[str, Refit] = {}
    for grown in search.grown:
        for name in grown.names:
            if name not in best or grown.refit.log_evidence > best[name].log_evidence:
                best[name] = grown.refit
    return best


def distance(frame: NoiseFrame, first: Refit, second: Refit) -> float:
    """Root mean square difference of two fitted curves in units of the noise."""
    return rms(frame.whiten(first.stiffness - second.stiffness))


def _grouped(search: Search, names: Sequence[str]) -> list[list[str]]:
    """Effects that change the model alike when each joins it alone.

    One that changes nothing is like no other.
    """
    alone = {each.names[0]: each.refit for each in reversed(search.grown) if len(each.effects) == 1}
    groups: list[list[str]] = []
    # Against the first of each group only: in a chain of neighbours the ends can be told apart.
    for name in names:
        seen = (
            name in alone and distance(search.frame, alone[name], search.base) >= EVIDENCE.one_curve
        )
        for group in groups:
            first = alone.get(group[0])
            if (
                seen
                and first is not None
                and distance(search.frame, alone[name], first) < EVIDENCE.one_curve
            ):
                group.append(name)
                break
        else:
            groups.append([name])
    return groups
