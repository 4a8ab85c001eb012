"""The discovery on a sweep: which effects are missing, one by one or as a set, and which stay."""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from springpot.identification.material import is_material
from springpot.identification.space import require_conditions
from springpot.measurement.measurement import Measurement
from springpot.misfit.refit import Refit, prediction_gain, refit
from springpot.misfit.residual_tests import battery
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.thresholds import EVIDENCE, SEARCH, VERDICT

from .evidence import (
    Evidence,
    credible,
    log_prior,
    one_for_each_set,
    size_of_scanned,
)
from .examination import examine
from .grown import (
    AskedSet,
    Grown,
    Search,
    at_its_limit,
    go_on_to_neighbours,
    in_each_place,
    one_more,
    one_or_two_for_one,
    scanned_beside,
)
from .in_practice import Accuracy
from .ladder import Case, Ladder, Reached, Step, climbed, replaced_by, with_rivals
from .result import Candidate, Diagnosis, Fitted, Progress, silent, unseen
from .scan import applicable, scan_effects
from .search import fit_new, sort_by_evidence
from .verdict import by_chain

if TYPE_CHECKING:
    from .ladder import Case


MOST_TOGETHER = 4
"""Effects sought together at most: more of them follow any misfit."""


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
    begun = max((len(one.effects) for one in search.grown), default=0)
    go_on_to_neighbours(GrownSets(found, effects, max(MOST_TOGETHER, begun)))
    sort_by_evidence(found)
    return found


@dataclass(frozen=True, eq=False)
class GrownSets:
    """The sets of a search of one sweep, and how others are made.

    Attributes
    ----------
    search : Search
        With the sets that were fitted so far.
    effects : sequence of Effect
        Of which others are made.
    most : int
        Effects of a set at most: a misfit that nothing explains takes one more for ever.
    """

    search: Search
    effects: Sequence[Effect]
    most: int

    def likeliest(self) -> list[Grown]:
        """One fit of each set, the likeliest first."""
        return _likeliest(self.search)

    def open(self, near: Sequence[Grown]) -> None:
        """Fit sets that differ from some by an effect, or by two in the place of one."""
        asked: list[AskedSet] = []
        for grown in near:
            asked += _neighbours(self.search, grown, self.effects)
        self._fit(asked)

    def extend(self, near: Sequence[Grown]) -> None:
        """Fit sets with one effect more than some."""
        self._fit([each for one in near for each in _extended(one, self.effects)])

    def _fit(self, asked: Sequence[AskedSet]) -> None:
        fit_new(self.search, [each for each in asked if len(each.effects) <= self.most])

    def exchange(self, best: Grown) -> None:
        """Fit the best set with another effect in each place."""
        fit_new(self.search, list(in_each_place(self.search, best, self.effects)))


def _neighbours(search: Search, grown: Grown, effects: Sequence[Effect]) -> Iterator[AskedSet]:
    """Sets that differ from one by an effect, or by two in the place of one."""
    yield from _extended(grown, effects)
    yield from one_or_two_for_one(search, grown, effects)


def _extended(grown: Grown, effects: Sequence[Effect]) -> list[AskedSet]:
    """Sets with one effect more than one."""
    return one_more(grown.effects, scanned_beside(grown.effects, grown.refit, effects))


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
        alike = self.evidence.same_curve(names, of_any_size=True)
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


def beside_what_is_left(case: Case, accepted: str) -> EffectSet | None:
    """An effect and what else is missing, with what may stand in the place of either.

    None where nothing else is.

    Parameters
    ----------
    case : Case
        The examination of the model without it.
    accepted : str
        The effect.
    """
    effects = [score.influence.effect for score in case.search.scan.scores]
    pairs = [one for one in case.search.grown if accepted in one.names and len(one.effects) > 1]
    if not pairs or case.search.grown[0].key != pairs[0].key:
        return None
    search = replace(case.search, grown=list(case.search.grown), confounded=[])
    GrownSets(search, effects, MOST_TOGETHER).open(pairs[:1])
    sort_by_evidence(search)
    return EffectSet(pairs[0].effects, pairs[0].refit, Evidence.of(search))


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


MOST_HIDDEN = 2
"""Effects that may be accepted from an unexplained rung on, if they complete the model."""


def discover(
    measurement: Measurement,
    model: Model,
    library: Sequence[Effect],
    rng: np.random.Generator,
    accept: Sequence[Effect] | None = None,
    progress: Progress = silent,
    reached: Reached | None = None,
    accuracy: Accuracy | None = None,
    begun: Ladder | None = None,
    fitted: Fitted = unseen,
) -> Ladder:
    """Accept effects that are missing from a model of a sweep; see `climbed`.

    Parameters
    ----------
    measurement : Measurement
        The data.
    library : sequence of Effect
        Effects that may be missing.
    rng : numpy.random.Generator
        For simulated noise.
    model, accept, progress, reached, begun
        As for `climbed`.
    accuracy : Accuracy, optional
        What the instrument promises.
    fitted : callable
        Given each effect that was fitted by itself.
    """
    # The same noise as if all of it were climbed now, so that the ladder is the same to the bit.
    if begun is not None:
        drawn = begun.steps[-1].case.drawn
        assert drawn is not None
        rng.bit_generator.state = drawn
    rungs = SweepRungs(measurement, library, rng, accuracy, fitted=fitted)
    return climbed(rungs, model, accept, progress, reached, begun)


@dataclass(frozen=True, eq=False)
class SweepRungs:
    """A sweep that stands alone.

    Attributes
    ----------
    measurement : Measurement
        The data.
    effects : sequence of Effect
        Effects that may be missing.
    rng : numpy.random.Generator
        For simulated noise.
    accuracy : Accuracy or None
        What the instrument promises.
    sets : list of EffectSet
        Sets that were found to explain the data together.
    plan : list of Effect
        Those of the last such set that are still to be accepted.
    fitted : callable
        Given each effect that was fitted by itself.
    """

    measurement: Measurement
    effects: Sequence[Effect]
    rng: np.random.Generator
    accuracy: Accuracy | None = None
    sets: list[EffectSet] = field(default_factory=list)
    plan: list[Effect] = field(default_factory=list)
    fitted: Fitted = unseen

    def examined(
        self, model: Model, progress: Progress, before: Step | None, effect: Effect | None
    ) -> Case:
        """The examination of a model, begun where the rung before has led."""
        starts: list[Real] = []
        if before is not None and effect is not None:
            require_conditions(model, self.measurement)
            starts = _starts(before.case, effect)
        starts += [found.start(model) for found in self.sets if found.makes(model)]
        case = examine(
            self.measurement,
            model,
            self.effects,
            self.rng,
            starts,
            progress,
            self.accuracy,
            self.fitted,
        )
        return replace(case, drawn=self.rng.bit_generator.state)

    def wanted(self, steps: Sequence[Step], refused: Container[str]) -> Effect | None:
        """The effect whose absence is beyond doubt, if there is one and a further rung could count.

        See `_explained`.
        """
        last = steps[-1].case
        # "Inconclusive" is no ground for a decision that nobody looks at.
        if last.diagnosis.verdict not in ("effect-missing", "unexplained"):
            return None
        if not self.plan and (found := complete_set(last, self.rng)):
            self.plan.extend(found.effects)
            self.sets.append(found)
        effect = self.plan.pop(0) if self.plan else _decisive(steps)
        if effect is None or effect.name in refused:
            return None
        return effect

    def settled(self, steps: list[Step], progress: Progress) -> list[Step]:
        """The rungs that explain something, each the likeliest beside all others."""
        steps = _explained(steps, [len(found.effects) for found in self.sets])
        # Alone or first, an effect may only have seemed needed: with all others in place it is
        # asked anew which set it is.
        cases = [step.case for step in steps]
        names = [step.accepted for step in steps[1:] if step.accepted]
        if len(names) == 1 and cases[-1].diagnosis.verdict == "effect-missing":
            beside = beside_what_is_left(cases[0], names[0])
            return steps if beside is None else with_rivals(steps, beside)
        found = likeliest_set(cases, names, self.effects)
        if found is None:
            return steps
        self.sets.append(found)
        return replaced_by(self, steps, found, progress)


# Beside the starts read off the data: those know nothing of what the rung before has found.
def _starts(case: Case, effect: Effect) -> list[Real]:
    """Parameters (p,) of the smaller model with the effect as the scan saw it.

    The next rung cannot do worse.
    """
    scanned = scan_effects(case.search.base, case.search.frame, [effect]).scores
    starts = [start for score in scanned for start in score.starts]
    # The scan's even where a fit is known: that one ended early where it was no rival.
    return starts + [
        grown.refit.theta for grown in case.search.grown if grown.names == (effect.name,)
    ]


def _decisive(steps: Sequence[Step]) -> Effect | None:
    """The effect that the last rung asks for beyond doubt."""
    verdicts = [step.case.diagnosis.verdict for step in steps]
    if "unexplained" in verdicts[:-MOST_HIDDEN]:
        return None
    case = steps[-1].case
    candidates = case.diagnosis.candidates
    if not candidates:
        return None
    # What changes with time is mended by no effect, however much of it one takes.
    if case.course is not None:
        return None
    # Nor is what the measuring chain did: an effect only follows a part of it, and what that leaves
    # then asks for another.
    if verdicts[-1] == "unexplained" and by_chain(case.evidence):
        return None
    # Where several others may be missing together in its place, or a cause that goes with what was
    # not varied by itself, nobody could decide.
    if case.evidence.instead or case.naming.confounded:
        return None
    # Factors without a law do better than what heads the table: whether they are physics only a
    # user knows.
    named = [candidate.effect for candidate in candidates]
    if case.diagnosis.leading and case.diagnosis.leading[0] not in named:
        return None
    if case.naming.alarm > VERDICT.accepted or case.naming.gain < SEARCH.decisive:
        return None
    first = _first_named(case.diagnosis)
    # Of a class that the data cannot tell apart only what is likelier than all the others goes in.
    if len(first.alike) > 1 and first.probability < VERDICT.likely:
        return None
    # Where the evidence prefers what has no name, an effect goes in unasked only if it takes most
    # of the error.
    little = not first.error_after <= VERDICT.takes_most * case.diagnosis.error.relative_rms
    if verdicts[-1] == "unexplained" and little:
        return None
    # An effect that shows only beside another may head the table without a fit of its own.
    fitted = case.evidence.likeliest_with().get(first.effect)
    if fitted is not None and at_its_limit(fitted, first.physics):
        return None
    # The headline offers a drift in its place: only another experiment decides between the two.
    drift = case.evidence.drift
    if drift is not None and drift.effect == first.effect:
        return None
    # Storage and loss at one frequency are two curves, which nearly any two effects of one column
    # follow.
    taken = {column for effect in steps[-1].model.effects for column in effect.needs}
    if case.evidence.one_frequency and not taken.isdisjoint(first.physics.needs):
        return None
    return first.physics


def _first_named(diagnosis: Diagnosis) -> Candidate:
    """The candidate that the headline names first, and the next step with it.

    Else the first of the table.

    The table may begin with one of a pair, of which another effect does more by itself than either.
    """
    for candidate in diagnosis.candidates:
        if diagnosis.leading and candidate.effect == diagnosis.leading[0]:
            return candidate
    return diagnosis.candidates[0]


def _explained(steps: list[Step], sets: Sequence[int] = ()) -> list[Step]:
    """The rungs up to the first unexplained one, and those beyond it that proved to be physics.

    Effects that hide one another can leave a rung unexplained that two more steps explain; where
    they do not, they may only have been fitted to what is no effect of the library. What predicts
    data that were left out much better than the model before, such as a shift of moduli beside a
    shift of times, stays, and so does what takes nearly all of the misfit: sweeps at temperatures
    too far apart to overlap predict one another by no law. The rest is still unexplained.
    """
    verdicts = [step.case.diagnosis.verdict for step in steps]
    if "unexplained" not in verdicts:
        return steps
    first = verdicts.index("unexplained")
    # So few more effects that complete the model are two that hid each other, not a curve bent to a
    # misfit.
    most = max([MOST_HIDDEN, *sets])
    if verdicts[-1] in ("adequate", "inconclusive") and len(verdicts) - 1 - first <= most:
        return steps
    kept = first + 1
    # One after the other: a rung that predicts nothing new ends what may be believed of those above
    # it.
    while kept < len(steps):
        before, after = steps[kept - 1], steps[kept]
        left = (after.relative_rms / before.relative_rms) ** 2
        if left > VERDICT.remainder and _prediction_gain(before, after) > VERDICT.predicts:
            break
        kept += 1
    return steps[:kept]


def _prediction_gain(before: Step, after: Step) -> float:
    return prediction_gain(before.case.search.base, after.case.search.base)
