"""What the evidence says: probabilities of effects, and classes that the data cannot tell apart."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from springpot.rheology import Real

from .frame import Frame
from .harmonics import harmonic_evidence
from .occam import marginal, unknown_marginal
from .refit import Refit
from .search import Grown, Search

CREDIBLE = 0.93
"""A class holds at least this share of the probability of all explanations."""
CLOSE = 0.35
"""Curves this close (root mean square, in units of the noise) are one curve for these data."""
MOST_UNKNOWN = 1.0 - 1e-12
ROUNDING = 1e-6
"""Log-evidence that says nothing."""
PRIOR_NOTHING = 0.5
PRIOR_PAIR = 0.5
"""Prior weight of a second missing effect; pairs have no order, so that two against one weigh half of it."""
OUTSIDE = 0.15
"""Chance, before the data, that what is missing is in no library."""
BESIDE = 0.9
"""Probability from which something is missing beside the leading effect."""
OTHER_NARROW = 0.3
"""Share of a narrow effect's probability that goes to narrow features of another origin."""


@dataclass(frozen=True)
class Posterior:
    """Probabilities of what is missing.

    Attributes
    ----------
    nothing : float
        That the model is complete.
    unknown : float
        That something is missing which no effect of the library explains.
    together : dict of tuple of str to float
        For each set of effects (names in order), that it is just what is missing.
    imitators : frozenset of str
        Effects whose place something else as narrow may hold.
    leaning : frozenset of str
        Effects that the data ask for only in the company of such a one.
    """

    nothing: float
    unknown: float
    together: dict[tuple[str, ...], float]
    imitators: frozenset[str] = frozenset()
    leaning: frozenset[str] = frozenset()

    @property
    def effects(self) -> dict[str, float]:
        """For each effect, that it is among what is missing."""
        found: dict[str, float] = {}
        for names, weight in self.together.items():
            doubtful = bool(self.imitators & set(names))
            for name in set(names):
                found[name] = found.get(name, 0.0) + weight * (self.trust(name) if doubtful else 1.0)
        return found

    @property
    def narrow(self) -> float:
        """That something narrow is missing which only looks like an effect of the library."""
        held = sum(weight for names, weight in self.together.items() if self.imitators & set(names))
        return OTHER_NARROW * held

    def trust(self, name: str) -> float:
        """Chance that what looks like an effect is that effect."""
        return 1.0 - OTHER_NARROW if name in self.imitators | self.leaning else 1.0

    def doubted(self, p_value: float) -> Posterior:
        """The same, where what the best model leaves has this chance of being noise: little if it is none of these.

        The odds for something unknown are those before the test, times the most that such a chance can speak for it
        (Sellke, Bayarri and Berger 2001, doi:10.1198/000313001300339950).
        """
        p_value = min(max(p_value, 1e-12), float(np.exp(-1.0)))
        odds = OUTSIDE / (1.0 - OUTSIDE) / (-np.e * p_value * np.log(p_value))
        unknown = max(self.unknown, odds / (1.0 + odds))
        share = (1.0 - unknown) / max(1.0 - self.unknown, 1e-300)
        together = {names: p * share for names, p in self.together.items()}
        return replace(self, nothing=self.nothing * share, unknown=unknown, together=together)

    def without_unknown(self) -> Posterior:
        """The same, taking for granted that the library explains what is missing."""
        known = max(1.0 - self.unknown, 1e-300)
        together = {names: p / known for names, p in self.together.items()}
        return replace(self, nothing=self.nothing / known, unknown=0.0, together=together)


def posterior(found: Search) -> Posterior:
    """Probabilities from the evidence of the fitted models and the prior weights of the effects."""
    total = max(sum(score.influence.effect.prior for score in found.scan.scores), 1.0)
    names: list[tuple[str, ...]] = []
    logs = [
        found.base.log_likelihood + harmonic_evidence(found.base) + np.log(PRIOR_NOTHING),
        unknown_marginal(found) + np.log((1.0 - PRIOR_NOTHING) / total),
    ]
    for grown in _distinct(found.grown):
        prior = (1.0 - PRIOR_NOTHING) * PRIOR_PAIR ** (len(grown.effects) - 1)
        for effect in grown.effects:
            prior *= effect.prior / total
        names.append(tuple(sorted(grown.names)))
        logs.append(marginal(found, grown) + np.log(max(prior, 1e-300)))
    # The unknown is kept out of the sum first: beside it the rest may be too small for a floating-point number.
    known = np.array([logs[0], *logs[2:]])
    weights = np.exp(known - known.max())
    weights /= weights.sum()
    odds = float(np.exp(np.clip(logs[1] - known.max() - np.log(np.sum(np.exp(known - known.max()))), -700, 700)))
    unknown = min(odds / (1.0 + odds), MOST_UNKNOWN)
    weights *= 1.0 - unknown
    together = dict(zip(names, weights[1:].tolist(), strict=True))
    imitators = frozenset(effect.name for grown in found.grown for effect in grown.effects if effect.narrow)
    alone = {names[0]: log for names, log in zip(names, logs[2:], strict=True) if len(names) == 1}
    leaning = frozenset(name for each in names for name in each if alone.get(name, -np.inf) < logs[0]) - imitators
    return Posterior(float(weights[0]), unknown, together, imitators, leaning)


def _distinct(grown: Sequence[Grown]) -> list[Grown]:
    """One model for each set of effects: the order in which they were added does not matter."""
    seen: dict[tuple[str, ...], Grown] = {}
    for each in sorted(grown, key=lambda one: one.names):
        key = tuple(sorted(each.names))
        if key not in seen or each.refit.log_evidence > seen[key].refit.log_evidence + ROUNDING:
            seen[key] = each
    return list(seen.values())


def distance(frame: Frame, first: Refit, second: Refit) -> float:
    """Root mean square difference of two fitted curves in units of the noise."""
    difference: Real = frame.whiten(first.stiffness - second.stiffness)
    return float(np.sqrt(np.mean(difference**2)))


def classes(found: Search, probabilities: Posterior) -> list[list[str]]:
    """Effects that these data cannot tell apart, the likeliest class first.

    The first class is the smallest set of rivals that holds nearly all of their probability; the rest are grouped by
    their curves.
    """
    best = best_with(found)
    ranked = sorted(best, key=lambda name: -probabilities.effects.get(name, 0.0))
    if not ranked:
        return []
    leader = leading(found, probabilities)
    chances = rivals_of(probabilities, leader)
    first = _credible(chances, sum(chances.values()))
    return [first, *_grouped(found, [name for name in ranked if name not in first])]


def leading(found: Search, probabilities: Posterior) -> str:
    """The effect to name first: of the likeliest explanation, the one that does most by itself."""
    alone = {grown.names[0]: grown.refit.log_evidence for grown in found.grown if len(grown.effects) == 1}
    likeliest = max(probabilities.together, key=lambda names: probabilities.together[names])
    return max(likeliest, key=lambda name: alone.get(name, -np.inf))


def partners(found: Search, probabilities: Posterior) -> dict[str, float]:
    """Effects one of which is missing beside the leading one, with their chances; none where that may be all."""
    leader = leading(found, probabilities)
    chances: dict[str, float] = {}
    for names, weight in probabilities.together.items():
        if len(names) == 2 and leader in names:
            partner = names[1 - names.index(leader)]
            chances[partner] = chances.get(partner, 0.0) + weight
    held = sum(weight for names, weight in probabilities.together.items() if leader in names)
    return chances if sum(chances.values()) > BESIDE * held else {}


def seconds(found: Search, probabilities: Posterior) -> list[str]:
    """The fewest of them that hold nearly all of their probability, the likeliest first."""
    chances = partners(found, probabilities)
    return _credible(chances, sum(chances.values()))


def grown_beside(found: Search, leader: str, names: Iterable[str]) -> dict[str, Grown]:
    """For each effect, the best fitted model that has it and the leading one."""
    return {
        name: grown
        for name in names
        for grown in reversed(found.grown)
        if sorted(grown.names) == sorted((leader, name))
    }


def _credible(chances: dict[str, float], total: float) -> list[str]:
    """The fewest names that hold nearly all of the probability."""
    covered, kept = 0.0, []
    for name in sorted(chances, key=lambda name: -chances[name]):
        if covered < CREDIBLE * total:
            kept.append(name)
        covered += chances[name]
    return kept


def rivals_of(probabilities: Posterior, leader: str) -> dict[str, float]:
    """Effects that could stand in the leading one's place, with their chances.

    Where the best explanation holds a second effect, that one stays while rivals of the leader are counted.
    """
    with_leader = [names for names in probabilities.together if leader in names]
    best = max(with_leader, key=lambda names: probabilities.together[names])
    partners = list(best)
    partners.remove(leader)
    chances: dict[str, float] = {}
    for names, weight in probabilities.together.items():
        rest = list(names)
        for partner in partners:
            if partner in rest:
                rest.remove(partner)
        if len(names) == len(best) and len(rest) == 1:
            chances[rest[0]] = chances.get(rest[0], 0.0) + weight
        elif len(names) < len(best):
            chances[names[0]] = chances.get(names[0], 0.0) + (weight if names[0] not in partners else 0.0)
    return chances


def explanations(found: Search, probabilities: Posterior) -> dict[str, Refit]:
    """For each effect, the likeliest of the fitted models that have it."""
    chosen: dict[str, Refit] = {}
    for grown in sorted(_distinct(found.grown), key=lambda one: -probabilities.together[tuple(sorted(one.names))]):
        for name in grown.names:
            chosen.setdefault(name, grown.refit)
    return chosen


def best_with(found: Search) -> dict[str, Refit]:
    """For each effect, the best fitted model that has it."""
    best: dict[str, Refit] = {}
    for grown in found.grown:
        for name in grown.names:
            if name not in best or grown.refit.log_evidence > best[name].log_evidence:
                best[name] = grown.refit
    return best


def _grouped(found: Search, names: Sequence[str]) -> list[list[str]]:
    """Effects that change the model alike when each joins it alone; one that changes nothing is like no other."""
    alone = {grown.names[0]: grown.refit for grown in reversed(found.grown) if len(grown.effects) == 1}
    groups: list[list[str]] = []
    for name in names:
        visible = name in alone and distance(found.frame, alone[name], found.base) >= CLOSE
        for group in groups:
            if visible and group[0] in alone and distance(found.frame, alone[name], alone[group[0]]) < CLOSE:
                group.append(name)
                break
        else:
            groups.append([name])
    return groups
