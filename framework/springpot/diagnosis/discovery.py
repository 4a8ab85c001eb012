"""The discovery on a sweep: which effects are missing, one by one or as a set, and which stay."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

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

from .evidence import Evidence, log_prior, one_for_each_set, size_of_scanned
from .examination import examine
from .grown import (
    MOST_TOGETHER,
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
from .ladder import (
    Case,
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
from .result import Fitted, Progress, silent, unseen
from .scan import applicable, scan_effects
from .search import fit_new, sort_by_evidence
from .verdict import by_chain


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
    """Sets that differ from one by an effect, or by two in the place of one.

    Of more effects only beside one that leaves something to be explained: else they follow noise.
    """
    # Noise of its own, so that nothing else hangs on which sets were asked.
    left = battery(grown.refit.frame(), np.random.default_rng(0)).p_value < SEARCH.left_over
    if left:
        yield from _extended(grown, effects)
    yield from one_or_two_for_one(search, grown, effects, left)


def _extended(grown: Grown, effects: Sequence[Effect]) -> list[AskedSet]:
    """Sets with one effect more than one."""
    return one_more(grown.effects, scanned_beside(grown.effects, grown.refit, effects))


def _likeliest(search: Search) -> list[Grown]:
    """One fit of each set, the likeliest first."""
    library = size_of_scanned(search)
    sets = one_for_each_set(search.grown)
    return sorted(sets, key=lambda one: -one.refit.log_evidence - log_prior(one, library))


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
    rungs = SweepRungs(
        measurement=measurement, effects=library, rng=rng, accuracy=accuracy, fitted=fitted
    )
    return climbed(rungs, model, accept, progress, reached, begun)


@dataclass(frozen=True, eq=False, kw_only=True)
class SweepRungs(Rungs[Refit]):
    """A sweep that stands alone.

    Attributes
    ----------
    measurement : Measurement
        The data.
    rng : numpy.random.Generator
        For simulated noise.
    """

    measurement: Measurement
    rng: np.random.Generator

    def examined(
        self, model: Model, progress: Progress, before: Step | None, effect: Effect | None
    ) -> Case:
        """The examination of a model, begun where the rung before has led."""
        starts: list[Real] = []
        if before is not None and effect is not None:
            require_conditions(model, self.measurement)
            starts = _starts(before.case, effect)
        starts += [model.picked(fit.model.named(fit.theta)) for fit in self.fits_of(model)]
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

    def complete_set(self, steps: Sequence[Step]) -> FoundSet[Refit] | None:
        """Several effects that together explain all, where no one or two do; None without such."""
        case = steps[-1].case
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
        left = battery(best.refit.frame(), self.rng)
        if (
            evidence.unknown > VERDICT.likely
            or 2.0 * behind > SEARCH.decisive
            or 2.0 * _needed(found, best) < SEARCH.decisive
            or left.p_value < VERDICT.structure_alarm
            or best.beyond_physics
        ):
            return None
        return _found(evidence)

    def decisive(self, steps: Sequence[Step]) -> Effect | None:
        """The effect that the last rung asks for beyond doubt."""
        return _decisive(steps)

    def likeliest_set(self, steps: Sequence[Step]) -> FoundSet[Refit] | None:
        """The likeliest set, begun with the effects accepted one after the other.

        Of one beside which more is missing, what may stand in its place there.
        """
        chosen = accepted_of(steps)
        if len(chosen) == 1 and steps[-1].diagnosis.verdict == "effect-missing":
            return beside_what_is_left(steps[0].case, chosen[0])
        if len(chosen) < 2:
            return None
        cases = [step.case for step in steps]
        first, last = cases[0].search, cases[-1].search.base
        # In units of the noise that is known in the end, and without the points set aside.
        base = refit(first.base.model, last.data, last.noise, [first.base.theta])
        scanned = {score.influence.effect for case in cases for score in case.search.scan.scores}
        # Beside another effect what is narrow may stand for a broad one as well.
        effects = [
            effect
            for effect in applicable(self.effects, base.fit.measurement)
            if effect in scanned or effect in chosen or effect.narrow
        ]
        frame = base.frame()
        search = replace(
            first,
            base=base,
            frame=frame,
            scan=scan_effects(base, frame, effects),
            grown=[Grown(chosen, last, last.rss)],
            promoted=frozenset(),
        )
        # Rivals that the first rung has seen may differ in every place.
        least = first.best.log_evidence - EVIDENCE.rivals
        fit_new(
            search,
            [
                AskedSet(one.effects, one.refit.model, [one.refit.theta], 0, one.predicted)
                for one in first.grown
                if one.refit.log_evidence > least and len(one.effects) > 1
            ],
        )
        return _found(Evidence.of(searched_sets(search, effects)))

    def settled(self, steps: list[Step], progress: Progress) -> list[Step]:
        """The rungs that explain something, each the likeliest beside all others."""
        explained = _spared(self._explained(steps))
        settled = _spared(super().settled(explained, progress))
        # What a set adds to them, or puts in their place, is asked for the same proof, and what it
        # adds is worth its price by the noise of its own rung as well.
        more = len(settled) > len(explained)
        unproved = len(self._explained(settled)) < len(settled)
        if unproved or (more and _likelier(explained[-1], settled[-1])):
            return explained
        return settled

    def _explained(self, steps: list[Step]) -> list[Step]:
        return _explained(steps, [len(found.effects) for found in self.sets])


def _found(evidence: Evidence) -> FoundSet[Refit]:
    """The likeliest set of a search."""
    best, sets = evidence.explanations[0].grown, one_for_each_set(evidence.search.grown)
    worth = {one.key: one.refit.log_evidence for one in sets}
    return FoundSet(in_order(best.effects, worth), best.refit, evidence.places)


def beside_what_is_left(case: Case, accepted: Effect) -> FoundSet[Refit] | None:
    """An effect with what may stand in its place beside what else is missing.

    None where nothing else is.

    Parameters
    ----------
    case : Case
        The examination of the model without it.
    accepted : Effect
        The effect.
    """
    effects = [score.influence.effect for score in case.search.scan.scores]
    pairs = [
        one for one in case.search.grown if accepted.name in one.names and len(one.effects) > 1
    ]
    if not pairs or case.search.grown[0].key != pairs[0].key:
        return None
    search = replace(case.search, grown=list(case.search.grown), confounded=[])
    GrownSets(search, effects, MOST_TOGETHER).open(pairs[:1])
    sort_by_evidence(search)
    evidence = Evidence.of(search)
    return FoundSet((accepted,), pairs[0].refit, lambda _: evidence.places(pairs[0].names))


def _needed(search: Search, grown: Grown) -> float:
    """Log-evidence that a set has beyond the best with fewer effects."""
    fewer = [one.refit for one in search.grown if len(one.effects) < len(grown.effects)]
    return grown.refit.log_evidence - max(fit.log_evidence for fit in (search.base, *fewer))


MOST_HIDDEN = 2
"""Effects that may be accepted from an unexplained rung on, if they complete the model."""


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
    first = told_apart(case.diagnosis)
    if first is None:
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
        bases = before.case.search.base, after.case.search.base
        if left > VERDICT.remainder and prediction_gain(*bases) > VERDICT.predicts:
            break
        kept += 1
    return steps[:kept]


def _spared(steps: list[Step]) -> list[Step]:
    """The rungs without the last ones that do nothing beside the others.

    Of a set, which was taken to its end.
    """
    while len(steps) > 1 and _likelier(*steps[-2:]):
        steps = steps[:-1]
    return steps


def _likelier(one: Step, other: Step) -> bool:
    """Whether one set of effects is likelier than another, by data and noise of the other."""
    if sorted(one.model.names) == sorted(other.model.names):
        return False
    judged, begun = other.case.search.base, one.case.search.base.theta
    again = refit(one.model, judged.data, judged.noise, [begun], starts=2)
    return again.log_evidence > judged.log_evidence
