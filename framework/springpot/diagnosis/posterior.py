"""What the evidence says: probabilities of effects, and classes that the data cannot tell apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from springpot.identification import Uncertainty
from springpot.rheology import Real

from .directions import Window, shows
from .frame import Frame
from .harmonics import harmonic_evidence
from .refit import Refit
from .search import Grown, Search

CREDIBLE = 0.93
"""A class holds at least this share of the probability of all explanations."""
CLOSE = 0.35
"""Curves this close (root mean square, in units of the noise) are one curve for these data."""
UNKNOWN_SIZE = float(np.log(10.0 * np.log(10.0) / np.sqrt(2.0 * np.pi)))
"""Cost of a size that may lie anywhere in ten decades."""
UNKNOWN_SIGN = float(np.log(2.0))
"""Cost of a size that may be positive or negative."""
MOST_UNKNOWN = 1.0 - 1e-12
VAGUE = 10.0
"""Square of the relative width within which a parameter other than a size is known beforehand."""
PRIOR_NOTHING = 0.5
PRIOR_PAIR = 0.5
"""Prior weight of two missing effects against one, spread over the pairs."""
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
    """

    nothing: float
    unknown: float
    together: dict[tuple[str, ...], float]
    imitators: frozenset[str] = frozenset()

    @property
    def effects(self) -> dict[str, float]:
        """For each effect, that it is among what is missing."""
        found: dict[str, float] = {}
        for names, weight in self.together.items():
            for name in set(names):
                found[name] = found.get(name, 0.0) + weight * self.trust(name)
        return found

    @property
    def narrow(self) -> float:
        """That something narrow is missing which only looks like an effect of the library."""
        held = sum(weight for names, weight in self.together.items() if self.imitators & set(names))
        return OTHER_NARROW * held

    def trust(self, name: str) -> float:
        """Chance that what looks like an effect is that effect."""
        return 1.0 - OTHER_NARROW if name in self.imitators else 1.0

    def without_unknown(self) -> Posterior:
        """The same, taking for granted that the library explains what is missing."""
        known = max(1.0 - self.unknown, 1e-300)
        together = {names: p / known for names, p in self.together.items()}
        return Posterior(self.nothing / known, 0.0, together, self.imitators)


def posterior(found: Search) -> Posterior:
    """Probabilities from the evidence of the fitted models and the prior weights of the effects."""
    total = max(sum(score.influence.effect.prior for score in found.scan.scores), 1.0)
    names: list[tuple[str, ...]] = []
    logs = [
        found.base.log_likelihood + harmonic_evidence(found.base) + np.log(PRIOR_NOTHING),
        _unknown_evidence(found) + np.log((1.0 - PRIOR_NOTHING) / total),
    ]
    for grown in _distinct(found.grown):
        prior = (1.0 - PRIOR_NOTHING) * PRIOR_PAIR ** (len(grown.effects) - 1)
        for effect in grown.effects:
            prior *= effect.prior / total
        names.append(tuple(sorted(grown.names)))
        logs.append(_evidence(found, grown) + np.log(max(prior, 1e-300)))
    # The unknown is kept out of the sum first: beside it the rest may be too small for a floating-point number.
    known = np.array([logs[0], *logs[2:]])
    weights = np.exp(known - known.max())
    weights /= weights.sum()
    odds = float(np.exp(np.clip(logs[1] - known.max() - np.log(np.sum(np.exp(known - known.max()))), -700, 700)))
    unknown = min(odds / (1.0 + odds), MOST_UNKNOWN)
    weights *= 1.0 - unknown
    together = dict(zip(names, weights[1:].tolist(), strict=True))
    imitators = frozenset(effect.name for grown in found.grown for effect in grown.effects if effect.narrow)
    return Posterior(float(weights[0]), unknown, together, imitators)


def _distinct(grown: Sequence[Grown]) -> list[Grown]:
    """One model for each set of effects: the order in which they were added does not matter."""
    seen: dict[tuple[str, ...], Grown] = {}
    for each in grown:
        key = tuple(sorted(each.names))
        if key not in seen or each.refit.log_evidence > seen[key].refit.log_evidence:
            seen[key] = each
    return list(seen.values())


def _evidence(found: Search, grown: Grown) -> float:
    """Log of the marginal likelihood of a grown model, by Laplace's method, up to what all models share.

    What an effect's parameters cost is the logarithm of how much narrower the data make them than they were. Its
    size is of unknown order of magnitude, and of unknown sign where physics allows both; its parameters are known the
    better, the more the effect explains: to a relative width of one over the square root of the drop in chi-square
    (MacKay 1992, doi:10.1162/neco.1992.4.3.415). One that the data leave less certain than that costs less.
    """
    spent = len(grown.refit.theta) - len(found.base.theta)
    cost = UNKNOWN_SIGN * sum(effect.element.parameters[0].lower < 0.0 for effect in grown.effects)
    explained = _discounted(found, grown.refit.log_likelihood, spent, len(grown.effects))
    return explained + harmonic_evidence(grown.refit) - cost + _refund(found, grown)


def _refund(found: Search, grown: Grown) -> float:
    """What is charged too much for parameters, sizes apart, that the data hardly determine.

    An effect with one that has gone beyond what the data show pays in full: it has become a simpler effect.
    """
    refit, window = grown.refit, Window.of(grown.refit.fit.measurement)
    sizes = {(each.name, each.element.parameters[0].name) for each in grown.effects}
    mine: dict[str, list[int]] = {}
    for i, parameter in enumerate(refit.model.parameters):
        owner, _, short = parameter.name.rpartition(".")
        if parameter.name not in found.base.model.names and (owner.partition("#")[0], short) not in sizes:
            mine.setdefault(owner, []).append(i)
    parameters, theta = refit.model.parameters, refit.theta
    shown = [rows for rows in mine.values() if all(shows(parameters[i], float(theta[i]), window) for i in rows)]
    if not shown or not np.all(np.isfinite(refit.fit.jacobian_u)):
        return 0.0
    drop = max(2.0 * (refit.log_likelihood - found.base.log_likelihood), 0.0)
    variance = np.diag(Uncertainty(refit.fit, absolute=True).covariance)[np.concatenate(shown)]
    needed = np.minimum(drop, VAGUE / np.where(variance > 0.0, variance, 1e-300))
    return 0.5 * float(np.sum(np.log1p(drop) - np.log1p(needed)))


def _unknown_evidence(found: Search) -> float:
    """The same for structure of any kind on top of the base model: costly, as it has many parameters."""
    frame = found.frame
    whole = float(frame.rest @ frame.rest)
    evidence = []
    for basis in (frame.smooth, frame.structured):
        left = whole - float(np.sum((basis.T @ frame.rest) ** 2))
        likelihood = found.base.noise.log_likelihood(left, frame.size)
        evidence.append(_discounted(found, likelihood, int(basis.shape[1]), 1))
    return max(evidence)


def _discounted(found: Search, log_likelihood: float, spent: int, effects: int) -> float:
    drop = max(2.0 * (log_likelihood - found.base.log_likelihood), 0.0)
    return float(log_likelihood - effects * UNKNOWN_SIZE - 0.5 * spent * np.log1p(drop))


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
    chances = rivals_of(found, probabilities, leader)
    total, covered = sum(chances.values()), 0.0
    first: list[str] = []
    for name in sorted(chances, key=lambda name: -chances[name]):
        if covered < CREDIBLE * total:
            first.append(name)
        covered += chances[name]
    return [first, *_grouped(found, [name for name in ranked if name not in first])]


def leading(found: Search, probabilities: Posterior) -> str:
    """The effect to name first: of the likeliest explanation, the one that does most by itself."""
    alone = {grown.names[0]: grown.refit.log_evidence for grown in found.grown if len(grown.effects) == 1}
    likeliest = max(probabilities.together, key=lambda names: probabilities.together[names])
    return max(likeliest, key=lambda name: alone.get(name, -np.inf))


def rivals_of(found: Search, probabilities: Posterior, leader: str) -> dict[str, float]:
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
    return {name: grown.refit for name, grown in _best_grown(found).items()}


def _best_grown(found: Search) -> dict[str, Grown]:
    best: dict[str, Grown] = {}
    for grown in found.grown:
        for name in grown.names:
            if name not in best or grown.refit.log_evidence > best[name].refit.log_evidence:
                best[name] = grown
    return best


def _grouped(found: Search, names: Sequence[str]) -> list[list[str]]:
    """Effects whose fitted curves agree; two that work together in one model are no rivals."""
    best = _best_grown(found)
    groups: list[list[str]] = []
    for name in names:
        for group in groups:
            first = best[group[0]]
            together = name in first.names or group[0] in best[name].names
            if not together and distance(found.frame, best[name].refit, first.refit) < CLOSE:
                group.append(name)
                break
        else:
            groups.append([name])
    return groups
