"""What the evidence says of laws: which one, which others the data cannot tell from it, if any."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from springpot.diagnosis.evidence import distance, log_prior_of_one
from springpot.diagnosis.grown import Grown, Search
from springpot.diagnosis.marginal import harmonic_evidence, marginal
from springpot.diagnosis.scan import applicable, scan_effects
from springpot.diagnosis.search import grown_with
from springpot.misfit.floor import is_arithmetic
from springpot.rheology.effect import Effect
from springpot.thresholds import EVIDENCE, INVENTION, VERDICT

from .grammar import symbols
from .search import possible

Verdict = Literal["law", "class", "none"]


@dataclass(frozen=True)
class Weighed:
    """A fitted law and how likely it is.

    Attributes
    ----------
    grown : Grown
        The model with it.
    log_weight : float
        Log of its marginal likelihood and prior.
    probability : float
        Beside the other laws.
    """

    grown: Grown
    log_weight: float
    probability: float

    @property
    def effect(self) -> Effect:
        """The law."""
        return self.grown.effects[0]


def weighed(search: Search) -> list[Weighed]:
    """The laws that were fitted, each formula once, the likeliest first.

    Parameters
    ----------
    search : Search
        A finished search.
    """
    best: dict[str, Grown] = {}
    for grown in search.grown:
        best.setdefault(grown.effects[0].name, grown)
    rivals = [grown for grown in best.values() if _is_rival(search, grown)]
    if not rivals:
        return []
    exact = [grown for grown in best.values() if is_arithmetic(grown.refit)]
    if exact:
        # What is left is rounding, and says nothing: the shortest formula is the law.
        rivals = exact
        logs = np.array([search.best.log_likelihood + _log_prior(g.effects[0]) for g in exact])
    else:
        logs = np.array([marginal(search, g) + _log_prior(g.effects[0]) for g in rivals])
    chances = np.exp(logs - logs.max())
    chances = chances / chances.sum()
    rows = zip(rivals, logs.tolist(), chances.tolist(), strict=True)
    return sorted((Weighed(*row) for row in rows), key=lambda law: -law.log_weight)


def _is_rival(search: Search, grown: Grown) -> bool:
    """Whether its price could still decide: a law far from the data needs none."""
    return grown.refit.log_likelihood > search.best.log_likelihood - INVENTION.hopeless


def _log_prior(effect: Effect) -> float:
    """The longer a formula, the more of its length there are."""
    return log_prior_of_one(1.0) - INVENTION.symbol * symbols(effect)


def rivals_of(laws: Sequence[Weighed]) -> list[Weighed]:
    """The class of the likeliest law: those that these data cannot tell from it."""
    kept: list[Weighed] = []
    for law in laws:
        near = law.log_weight > laws[0].log_weight - EVIDENCE.rivals
        if near and not any(_is_same(law, other) for other in kept):
            kept.append(law)
    return kept


def _is_same(law: Weighed, other: Weighed) -> bool:
    """Whether a law has become another one, as c omega^a does where a is nothing."""
    frame = other.grown.refit.frame()
    return distance(frame, law.grown.refit, other.grown.refit) < INVENTION.same


def nothing(search: Search) -> float:
    """Log-evidence that no law is missing."""
    complete = search.base.log_likelihood + harmonic_evidence(search.base)
    return complete + float(np.log(EVIDENCE.prior_nothing))


def verdict_of(search: Search, laws: Sequence[Weighed]) -> Verdict:
    """Whether a law is found, a class of them, or none.

    One is found where noise alone is no credible cause of the misfit, the evidence prefers the law,
    and what it leaves is noise.
    """
    if not laws or search.alarm >= INVENTION.alarm:
        return "none"
    clear = laws[0].log_weight > nothing(search) + EVIDENCE.as_good
    structure = search.left.p_value < VERDICT.structure_alarm
    if not clear or (structure and not is_arithmetic(laws[0].grown.refit)):
        return "none"
    return "law" if len(rivals_of(laws)) == 1 else "class"


def known_alike(search: Search, law: Weighed, library: Sequence[Effect]) -> list[Grown]:
    """Effects with a name that these data cannot tell from a law, the likeliest first.

    Parameters
    ----------
    search : Search
        A finished search.
    law : Weighed
        The law.
    library : sequence of Effect
        Effects with a name.
    """
    effects = possible(search.base, applicable(library, search.base.fit.measurement))
    scores = scan_effects(search.base, search.frame, effects).scores[: INVENTION.known]
    grown = [grown_with(search, score) for score in scores]
    least = law.grown.refit.log_likelihood - EVIDENCE.rivals
    alike = [each for each in grown if each.refit.log_likelihood > least]
    return sorted(alike, key=lambda each: -each.refit.log_likelihood)
