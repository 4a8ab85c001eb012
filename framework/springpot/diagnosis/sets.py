"""Sets of effects that are missing together from a model of a sweep."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from springpot.identification.material import is_material
from springpot.misfit.refit import Refit, refit
from springpot.misfit.residual_battery import battery
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.thresholds import EVIDENCE, SEARCH, VERDICT

from .asked import AskedSet, in_each_place, one_more, one_or_two_for_one, scanned_beside
from .evidence import (
    Evidence,
    credible,
    log_prior,
    one_for_each_set,
    size_of_scanned,
)
from .grown import Grown, Search
from .neighbours import go_on_to_neighbours
from .scan import applicable, scan_effects
from .search import fit_new, sort_by_evidence

if TYPE_CHECKING:
    from .case import Case


def searched_sets(search: Search, effects: Sequence[Effect]) -> Search:
    """The search, gone on to sets that are neighbours of the best, until none is better.

    Parameters
    ----------
    search : Search
        With the sets to begin with.
    effects : sequence of Effect
        Of which sets are made.
    """
    found = replace(search, grown=list(search.grown), confounded=[])
    go_on_to_neighbours(GrownSets(found, effects))
    sort_by_evidence(found)
    return found


@dataclass(frozen=True, eq=False)
class GrownSets:
    """The sets of a search of one sweep, and the effects of which others are made."""

    search: Search
    effects: Sequence[Effect]

    def likeliest(self) -> list[Grown]:
        """One fit of each set, the likeliest first."""
        return _likeliest(self.search)

    def open(self, near: Sequence[Grown]) -> None:
        """Fit sets that differ from some by an effect, or by two in the place of one."""
        asked: list[AskedSet] = []
        for grown in near:
            asked += _neighbours(self.search, grown, self.effects)
        fit_new(self.search, asked)

    def exchange(self, best: Grown) -> None:
        """Fit the best set with another effect in each place."""
        fit_new(self.search, list(in_each_place(self.search, best, self.effects)))


def _neighbours(search: Search, grown: Grown, effects: Sequence[Effect]) -> Iterator[AskedSet]:
    """Sets that differ from one by an effect, or by two in the place of one."""
    yield from one_more(grown.effects, scanned_beside(grown.effects, grown.refit, effects))
    yield from one_or_two_for_one(search, grown, effects)


def _likeliest(search: Search) -> list[Grown]:
    """One fit of each set, the likeliest first."""
    library = size_of_scanned(search)
    sets = one_for_each_set(search.grown)
    return sorted(sets, key=lambda one: -one.refit.log_evidence - log_prior(one, library))


@dataclass(frozen=True, eq=False)
class EffectSet:
    """Effects that explain the data together.

    Attributes
    ----------
    effects : tuple of Effect
        In the order in which they are to be accepted.
    refit : Refit
        The fit with all of them.
    evidence : Evidence
        Of all sets that were tried.
    """

    effects: tuple[Effect, ...]
    refit: Refit
    evidence: Evidence

    def makes(self, model: Model) -> bool:
        """Whether a model has all of them, and no more."""
        return sorted(self.refit.model.names) == sorted(model.names)

    def start(self, model: Model) -> Real:
        """Parameters (p,) of a model that it makes, as they were fitted."""
        names = self.refit.model.names
        return model.vector(dict(zip(names, self.refit.theta.tolist(), strict=True)))

    def places(self) -> dict[str | None, tuple[str, ...]]:
        """For each effect of the set, what may stand in its place."""
        names = [effect.name for effect in self.effects]
        chances = self.evidence.stand_ins(names, of_any_size=True)
        alike = self.evidence.same_curve(names)
        return {
            name: tuple(dict.fromkeys([*credible(own, EVIDENCE.unasked), *others]))
            for name, own, others in zip(names, chances, alike, strict=True)
        }


def complete_set(case: Case, rng: np.random.Generator) -> EffectSet | None:
    """Several effects that together explain all, where no one or two do; None without such.

    Parameters
    ----------
    case : Case
        A model, examined.
    rng : numpy.random.Generator
        For simulated noise.
    """
    search = case.search
    explained = search.left.p_value >= VERDICT.structure_alarm
    # What changes with time, and what a free spectrum follows with effects, has no such answer.
    if explained or case.course is not None or is_material(search.base.model):
        return None
    if not search.grown or search.alarm > VERDICT.accepted:
        return None
    found = searched_sets(search, [score.influence.effect for score in search.scan.scores])
    evidence = Evidence.of(found)
    best = evidence.explanations[0].grown
    # As where effects are named: beside any material only if that is clearly better.
    behind = case.naming.best.log_evidence_of_all - best.refit.log_evidence_of_all
    left = battery(best.refit.frame(), rng)
    if (
        evidence.unknown > VERDICT.likely
        or 2.0 * behind > SEARCH.decisive
        or 2.0 * _needed(found, best) < SEARCH.decisive
        or left.p_value < VERDICT.structure_alarm
        or best.beyond_physics
    ):
        return None
    return EffectSet(tuple(_in_order(found, best)), best.refit, evidence)


def likeliest_set(
    cases: Sequence[Case], accepted: Sequence[str], library: Sequence[Effect]
) -> EffectSet | None:
    """The likeliest set of effects, begun with those accepted one after the other.

    None where fewer than two were.

    Parameters
    ----------
    cases : sequence of Case
        From the user's model to the one with all of them.
    accepted : sequence of str
        Their names.
    library : sequence of Effect
        Effects that may be missing.
    """
    if len(accepted) < 2:
        return None
    first, last = cases[0].search, cases[-1].search.base
    # In units of the noise that is known in the end, and without the points set aside.
    base = refit(first.base.model, last.data, last.noise, [first.base.theta])
    scanned = {score.influence.effect for case in cases for score in case.search.scan.scores}
    chosen = _accepted(last.model, base.model, accepted)
    # Beside another effect what is narrow may stand for a broad one as well.
    effects = [
        effect
        for effect in applicable(library, base.fit.measurement)
        if effect in scanned or effect in chosen or effect.narrow
    ]
    frame = base.frame()
    scan = scan_effects(base, frame, effects)
    begun = Grown(chosen, last, last.rss)
    search = replace(first, base=base, frame=frame, scan=scan, grown=[begun], promoted=frozenset())
    # Rivals that the first rung has seen may differ in every place.
    least = first.best.log_evidence - EVIDENCE.rivals
    seen = [one for one in first.grown if one.refit.log_evidence > least and len(one.effects) > 1]
    fit_new(
        search,
        [
            AskedSet(one.effects, one.refit.model, [one.refit.theta], 0, one.predicted)
            for one in seen
        ],
    )
    found = searched_sets(search, effects)
    evidence = Evidence.of(found)
    best = evidence.explanations[0].grown
    # What stays keeps its rung.
    order, others = [], _in_order(found, best)
    for effect in chosen:
        if effect in others:
            others.remove(effect)
            order.append(effect)
    return EffectSet((*order, *others), best.refit, evidence)


def _accepted(model: Model, base: Model, names: Sequence[str]) -> tuple[Effect, ...]:
    """The effects of these names that a model has beyond the base's, in their order."""
    added = list(model.effects)
    for effect in base.effects:
        added.remove(effect)
    return tuple(next(effect for effect in added if effect.name == name) for name in names)


def _in_order(search: Search, grown: Grown) -> list[Effect]:
    """The effects of a set, the ones first that do most without the others."""
    fits = {one.key: one.refit for one in one_for_each_set(search.grown)}
    left, order = list(grown.effects), []
    while left:
        # Last is what is missed the least.
        evidence = []
        for one in left:
            fit = fits.get(tuple(sorted(each.name for each in left if each is not one)))
            evidence.append(-np.inf if fit is None else fit.log_evidence)
        order.append(left.pop(int(np.argmax(evidence))))
    return order[::-1]


def _needed(search: Search, grown: Grown) -> float:
    """Log-evidence that a set has beyond the best with fewer effects."""
    fewer = [one.refit for one in search.grown if len(one.effects) < len(grown.effects)]
    return grown.refit.log_evidence - max(fit.log_evidence for fit in (search.base, *fewer))
