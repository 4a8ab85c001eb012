"""The answer of a diagnosis as plain data and sentences, and what to do next.

The table of effects: what each would do, how likely it is, and what it cannot be told from.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np

from springpot.identification.fitted_quantities import in_short
from springpot.identification.held_material import parameters_of
from springpot.identification.result import known_of_sweep
from springpot.identification.value import PartResult, Quantities, Value, in_floors
from springpot.measurement.measurement import Measurement
from springpot.measurement.mixed_up import turned, wrong_way
from springpot.misfit.drift_search import Course, change_in_order, course_behind
from springpot.misfit.error import Error, times
from springpot.misfit.material import (
    MaterialFloor,
    error_of,
    split_in_words,
)
from springpot.misfit.outliers import Outlier
from springpot.misfit.refit import Refit
from springpot.misfit.residual_causes import (
    Column,
    EqualRows,
    column_behind,
    equal_rows_behind,
    one_test_of,
)
from springpot.misfit.where import Where, periodic, where
from springpot.rheology.effect import Effect
from springpot.thresholds import EVIDENCE, VERDICT

from ..numerics import SMALLEST
from .evidence import Evidence, best_with
from .experiment import (
    experiment_on_confounded,
    experiment_on_points,
    experiment_on_unknown,
    experiment_on_untold,
    next_experiment,
    openness,
    worth_telling_apart,
)
from .grown import Grown, Search
from .notes import header_notes, notes, unexplained_harmonics
from .result import (
    SEEN,
    Candidate,
    Diagnosis,
    EffectVerdict,
    NextExperiment,
    ToDo,
    Verdict,
    leaving_out,
    splitting,
    turning,
)
from .scan import Score
from .search import with_factors
from .verdict import by_chain, drifted, leading_names, only_points, prefers_effects, sentence


def candidates_of(evidence: Evidence, verdict: Verdict) -> list[Candidate]:
    """All scanned effects as candidates, the likeliest first.

    None is missing where the verdict is another.
    """
    search = evidence.search
    groups: list[list[str]] = []
    if verdict != "adequate":
        groups = evidence.classes
    class_of = {name: tuple(group) for group in groups for name in group}
    # Reversed, so that of several fits of one effect the best stays.
    alone = {grown.names[0]: grown for grown in reversed(search.grown) if len(grown.effects) == 1}
    best, chances = best_with(search), evidence.effects
    leader, beside = "", dict[str, Grown]()
    if evidence.explanations:
        leader, beside = evidence.leader, evidence.grown_beside(evidence.beside)
    rows = []
    for score in search.scan.scores:
        name = score.influence.effect.name
        chance = chances.get(name, 0.0)
        # Of the first class one member is missing for certain; any other must be likely in its own
        # right.
        least = EVIDENCE.beside
        if groups and name in groups[0]:
            least = VERDICT.likely
        missing = verdict == "effect-missing" and chance > least * evidence.trust(name)
        # One of its class needs a condition that moved with the frequency: no fit can say which of
        # them it is.
        if search.confounded and groups and name in groups[0]:
            missing = False
        word = _effect_verdict(search, score, best.get(name), missing)
        # What is told after an effect is what accepting it gives: the model with that effect alone.
        row = _candidate(search.base, score, alone.get(name), chance > VERDICT.profiled)
        if name in beside:
            row = _beside(search.base, row, beside[name], leader, alone.get(leader))
        rows.append(
            replace(row, alike=class_of.get(name, (name,)), probability=chance, verdict=word)
        )
    # The leader first: it stands for its class, of which another member may be as likely.
    rows.sort(key=lambda row: (row.effect != leader, -row.probability, -row.delta_bic))
    return rows


def _candidate(before: Refit, score: Score, grown: Grown | None, believed: bool) -> Candidate:
    """What one effect does when it joins a fitted model.

    The user's alone, or that with the leading effect.
    """
    effect = score.influence.effect
    row = Candidate(
        physics=effect,
        alike=(effect.name,),
        probability=0.0,
        delta_bic=-np.inf,
        score=score.score,
        verdict="cannot-tell",
        predicted_error=_predicted(before, score.predicted),
        bound=score.bound,
        says=effect.summary,
    )
    if grown is None:
        return row
    return replace(
        row,
        delta_bic=2.0 * (grown.refit.log_evidence - before.log_evidence),
        predicted_error=_predicted(before, grown.predicted),
        alone=AsFitted(grown.refit, before.floor, effect, believed),
    )


def _beside(
    before: Refit, row: Candidate, pair: Grown, leader: str, alone: Grown | None
) -> Candidate:
    """The row of an effect that shows beside the leading one, as it is in the model with both.

    Its evidence is that of joining the model with the leading one, if that was fitted alone.
    """
    gain = row.delta_bic
    if alone is not None:
        gain = 2.0 * (pair.refit.log_evidence - alone.refit.log_evidence)
    left = f"{100.0 * pair.refit.error:.3g} % is left with both"
    return replace(
        row,
        delta_bic=gain,
        says=f"beside {leader}: {row.says}; {left}",
        predicted_error=_predicted(before, pair.predicted),
        beside=AsFitted(pair.refit, before.floor, row.physics, by_profile=False),
    )


def _predicted(before: Refit, left: float) -> float:
    """Relative error that is foretold, from the sum of squares that is."""
    return before.error * float(np.sqrt(max(left, 0.0) / max(before.rss, SMALLEST)))


def _effect_verdict(
    search: Search, score: Score, best: Refit | None, missing: bool
) -> EffectVerdict:
    gain = -np.inf
    if best is not None:
        gain = 2.0 * (best.log_evidence - search.base.log_evidence)
    # A probability shared among few rivals may be large where the data hardly speak: the gain must
    # be clear too.
    if missing and gain >= VERDICT.clear_evidence:
        return "missing"
    # Not seen is not absent: only where the data would have shown a small one. Nor is one that was
    # not fitted as others leave less, but follows more of the misfit than it does of noise.
    unasked = best is None and score.score > search.scan.threshold
    if gain < 0.0 and score.bound < VERDICT.seen and not unasked:
        return "absent"
    return "cannot-tell"


@dataclass(frozen=True, eq=False)
class AsFitted:
    """What a fit with one more effect tells when it is asked: both take searches of their own.

    Attributes
    ----------
    refit : Refit
        The model with the effect.
    floor : float
        Relative error that noise leaves of the model without it.
    effect : Effect
        The effect.
    by_profile : bool
        Whether the intervals of its parameters are worth a profile.
    """

    refit: Refit
    floor: float
    effect: Effect
    by_profile: bool

    @property
    def error(self) -> float:
        """Relative error that `identify` leaves."""
        return self.refit.error

    @property
    def over_floor(self) -> float:
        """The same over the noise."""
        return in_floors(self.error, self.floor)

    @cached_property
    def parameters(self) -> dict[str, Value]:
        """The effect's own parameters."""
        return self.effect.own_of(parameters_of(self.refit.known, self.by_profile))


BESIDE_MATERIAL = {
    "effect-missing": ", and beside it a part of the material that no single effect supplies",
    "unexplained": "; any linear material comes nearer than the model with any effect",
    "inconclusive": "; any linear material comes nearer than the model with any effect",
}
"""What is added where effects are named beside a free spectrum."""
OPEN = frozenset({"unexplained", "inconclusive"})
"""Verdicts after which the cause may be something that no effect knows, such as another column."""
Cause: TypeAlias = Column | EqualRows | Course | None
"""What the misfit goes with that no effect knows.

A column of settings, repeats without a number, or the time.
"""
HARMONICS = "; the force holds harmonics that this model does not make"


def course_instead(evidence: Evidence, verdict: Verdict) -> Course | None:
    """How the specimen changed with time, where no effect explains the misfit better.

    Parameters
    ----------
    evidence : Evidence
        Of every effect, with the search behind it.
    verdict : {"adequate", "effect-missing", "unexplained", "inconclusive"}
        What they amount to without the time.
    """
    search = evidence.search
    drifts = search.repeats.p_value < VERDICT.beyond_doubt
    if verdict == "adequate" and not drifts:
        return None
    frame = search.base.frame()
    # The mean of repeats knows no time: they are looked at one by one.
    if drifts:
        frame = search.base.frame_of(search.base.data.raw)
    course = course_behind(frame)
    if course is None or verdict != "effect-missing":
        return course
    # An amplitude that only followed the specimen explains whatever the specimen did.
    if course.force_held and any("amplitude" in effect.needs for effect in search.grown[0].effects):
        return course
    spent = len(search.best.own) - len(search.base.own)
    gain = search.base.fair_rss - search.best.fair_rss - spent * float(np.log(frame.size))
    if gain > course.gain:
        return None
    return course


def answer(
    measurement: Measurement,
    search: Search,
    floor: MaterialFloor,
    evidence: Evidence,
    outliers: Sequence[Outlier],
    verdict: Verdict,
    library: Sequence[Effect],
    course: Course | None = None,
) -> Diagnosis:
    """Tell what was found, of the user's own model whatever the names were found beside.

    Parameters
    ----------
    measurement : Measurement
        The data as given.
    search : Search
        Fits and scans of the user's model.
    floor : MaterialFloor
        The least error that any material reaches.
    evidence : Evidence
        Of every effect.
    outliers : sequence of Outlier
        Points set aside.
    verdict : {"adequate", "effect-missing", "unexplained", "inconclusive"}
        Overall.
    library : sequence of Effect
        Those with a factor for each level tell whether any shift would do.
    course : Course, optional
        How the specimen changed with time, where that is what the misfit goes with.
    """
    error = error_of(search.base, floor)
    # Noise that is hard to believe is told of first: until it is smaller, the rest is not worth it.
    doubted = verdict == "inconclusive" and error.is_hardly_noise
    candidates = candidates_of(evidence, verdict)
    leading = _leading(search, evidence, verdict, course)
    cause, one_test = _cause(measurement, search, evidence, verdict, course)
    split, experiment = "", None
    if verdict in SEEN:
        split = _split(search, floor, cause, only_points(search, outliers))
    # To look at one test needs no measurement, nor to number repeats: they come first.
    if (verdict != "adequate" or outliers) and not one_test and not isinstance(cause, EqualRows):
        experiment = _next_experiment(search, evidence, verdict, outliers, leading, course)
    sentences = list(notes(evidence, verdict, outliers, cause, floor, len(measurement), library))
    sentences += [*_in_order_of_time(search, cause), *header_notes(candidates, measurement)]
    if doubted:
        sentences.insert(0, error.advice)
    diagnosis = Diagnosis(
        data=search.base.data.raw.name,
        model=search.base.model,
        error=error,
        verdict=verdict,
        says=_says(search, evidence, verdict, outliers, cause),
        split=split,
        where=tuple(_places(search, outliers, verdict)),
        candidates=tuple(candidates),
        classes=() if verdict == "adequate" else tuple(map(tuple, evidence.classes)),
        next_experiment=experiment,
        notes=tuple(sentences),
        evidence=_chances(search, evidence),
        parameters=parameters_of(search.base.known),
        leading=tuple(leading),
        one_test=one_test,
        tests=(_as_test(measurement, error),),
        steps=tuple(_steps(measurement, search, evidence, verdict, outliers, cause)),
        quantities=_quantities(search, verdict),
    )
    if not course:
        # A factor at each temperature would be another name for the time.
        diagnosis = _with_factors(diagnosis, search, evidence, library)
    return diagnosis.behind_a_sign()


def _quantities(search: Search, verdict: Verdict) -> Quantities | None:
    """Those of an adequate model: of another they would be no one's."""
    if verdict != "adequate":
        return None
    raw = search.base.data.raw
    return in_short(known_of_sweep(search.base.known), raw.name, [raw])


def _steps(
    measurement: Measurement,
    search: Search,
    evidence: Evidence,
    verdict: Verdict,
    outliers: Sequence[Outlier],
    cause: Cause,
) -> Iterator[ToDo]:
    """What can be done with the data themselves."""
    if spec := turned(measurement.provenance):
        yield turning(spec, what=wrong_way(measurement.provenance))
    error = search.base.error
    known = {**measurement.conditions, **measurement.labels}
    if isinstance(cause, Column) and cause.name in known:
        # Taken from what the best model leaves: a mass beside the gains is not split off with them.
        taken = cause.of_gains * min(search.best.error, error) ** 2
        left = float(np.sqrt(max(error**2 - taken, 0.0)))
        if left < VERDICT.helps * error:
            yield splitting(cause.name, left)
    elif cause is None and verdict in SEEN and (rest := evidence.rest) and rest.column:
        # What each level of a condition has of its own hides the rest from every later test.
        yield splitting(rest.column, what="what is left")
    # The error is that without them: that is how the answer was found.
    if rows := [outlier.row for outlier in outliers if outlier.row is not None]:
        yield leaving_out(rows, error)


def _split(search: Search, floor: MaterialFloor, cause: Cause, nothing: bool) -> str:
    """What the material floor says of what is missing; of single points alone it says nothing.

    Nor of rows that a column sets apart: they are of no one material.
    """
    if nothing or isinstance(cause, Column):
        return ""
    return split_in_words(search.base, floor)


def _as_test(measurement: Measurement, error: Error) -> PartResult:
    """The sweep that all of it is about."""
    return PartResult.of_sweep(
        measurement.name, len(measurement), error.relative_rms, error.noise_floor
    )


def _leading(
    search: Search, evidence: Evidence, verdict: Verdict, course: Course | None
) -> Sequence[str]:
    """Effects to add next: none is where the specimen changes."""
    if course is not None:
        return []
    return leading_names(search, evidence, verdict)


def _cause(
    measurement: Measurement,
    search: Search,
    evidence: Evidence,
    verdict: Verdict,
    course: Course | None,
) -> tuple[Cause, str]:
    """What the misfit goes with that no effect knows, and how to choose the rows of one test.

    Both may be empty.
    """
    if course is not None:
        return course, course.last_round
    if verdict not in OPEN:
        return None, ""
    frame = evidence.search.best.frame()
    column = column_behind(frame)
    one_test, _ = one_test_of(search.base.data.raw, column)
    if column is None and verdict == "unexplained":
        return equal_rows_behind(frame, measurement), one_test
    return column, one_test


def _with_factors(
    diagnosis: Diagnosis, search: Search, evidence: Evidence, library: Sequence[Effect]
) -> Diagnosis:
    """The same, where factors per level of a condition take the error and nothing named does."""
    if diagnosis.verdict != "unexplained" or evidence.search is not search:
        return diagnosis
    named = [grown.refit for grown in search.grown if grown.names[0] in diagnosis.leading]
    least = min((fitted.error for fitted in named), default=np.inf)
    # What is named leaves no more than noise: more freedom is no answer to that.
    if least < VERDICT.noisy * search.base.floor:
        return diagnosis
    factors = with_factors(search, library)
    if factors is None or factors.refit.error > VERDICT.takes_most * least:
        return diagnosis
    left = times(factors.refit.error / factors.refit.floor)
    (effect,) = factors.effects
    (column,) = effect.needs
    # Named all the same, and first: so a user can go on, and knows that it is no law.
    what = f"a factor of its own at each {column}, which no law joins"
    says = f"{diagnosis.says}; {effect.name} takes it to {left}: {what}"
    return replace(diagnosis, says=says, leading=(*factors.names, *diagnosis.leading))


def _in_order_of_time(search: Search, cause: Cause) -> Iterator[str]:
    """What changed between values of a column, or between repeats, if one came after another."""
    says = ""
    if isinstance(cause, Column):
        says = change_in_order(search.base.data.raw, cause.name)
    elif cause is None and drifted(search):
        says = change_in_order(search.base.data.raw, "repeat")
    if says:
        yield says


def _says(
    search: Search, evidence: Evidence, verdict: Verdict, outliers: Sequence[Outlier], cause: Cause
) -> str:
    """The verdict in words, with what was seen beside any material and in the force's harmonics."""
    if isinstance(cause, Course):
        ratio = search.base.error / search.base.floor
        return f"the error is {times(ratio)} the noise floor; {cause.headline}"
    says = sentence(search, evidence, verdict, outliers, cause)
    if evidence.search is not search:
        says = f"{says}{BESIDE_MATERIAL[verdict]}"
    if unexplained_harmonics(evidence.search, verdict):
        says = f"{says}{HARMONICS}"
    return says


def _chances(search: Search, evidence: Evidence) -> dict[str, float]:
    """The chances on which the verdict rests."""
    return {
        "p_library": search.scan.p_value,
        "p_structure": search.structure.p_value,
        "p_left": evidence.search.left.p_value,
        "p_repeats": search.repeats.p_value,
        "nothing": evidence.nothing,
        "unknown": evidence.unknown + evidence.narrow + evidence.other_shape,
    }


def _places(search: Search, outliers: Sequence[Outlier], verdict: Verdict) -> Iterator[Where]:
    """Bands first, then what only a period shows, then the single points that were set aside.

    The first place is told beside the effect that explains it, which a point is not.
    """
    bands = []
    if verdict != "adequate":
        bands = where(search.frame)
    yield from bands
    # A ripple of which no band is off to one side would else leave "unexplained" without a place.
    if (
        not bands
        and verdict == "unexplained"
        and search.structure.parts["ripple"] < VERDICT.structure_alarm
    ):
        yield periodic(search.frame)
    yield from (outlier.place for outlier in outliers)


def _next_experiment(
    search: Search,
    evidence: Evidence,
    verdict: Verdict,
    outliers: Sequence[Outlier],
    leading: Sequence[str],
    course: Course | None,
) -> NextExperiment | None:
    """What would decide between effects that may be it, or else tell of what is unknown."""
    if course is not None:
        return NextExperiment(course.advice, (), None)
    # Whatever else is open: first the frequency and the amplitude must be told from each other.
    names = [grown.names[0] for grown in evidence.search.confounded]
    if evidence.moved:
        names = [name for name in evidence.classes[0] if name in evidence.moved]
    if names and verdict != "adequate":
        return experiment_on_confounded(evidence.search.base.fit.measurement, names)
    if verdict == "adequate" or only_points(search, outliers):
        return experiment_on_points(outliers)
    # Of an effect that is in no headline nobody asks what stands in its place.
    asked = evidence.effects if verdict == "unexplained" else {*leading, *evidence.partners}
    # The cheapest question of all, and no other measurement answers it.
    drifts = evidence.drift is not None and evidence.drift.effect in asked
    if drifts or (verdict == "unexplained" and by_chain(evidence)):
        return experiment_on_unknown(search.base.data.raw)
    if evidence.untold is not None and evidence.untold.effect in asked:
        return experiment_on_untold(evidence.untold, search.base.data.raw)
    # Effects that nobody believes in are not worth a measurement that tells them apart.
    experiment = None
    if (verdict != "unexplained" and prefers_effects(evidence)) or leading:
        experiment = _between_effects(evidence)
    # Where repeats drift, the very question has been answered.
    if experiment is None and verdict in OPEN and not drifted(search):
        experiment = experiment_on_unknown(search.base.data.raw)
    return experiment


def _between_effects(evidence: Evidence) -> NextExperiment | None:
    """What would settle the more open of two questions.

    Which effect leads, and which one stands beside it.
    """
    if not evidence.explanations:
        return None
    chances, fits = evidence.rivals, evidence.likeliest_with()
    if openness(evidence.partners) > openness(chances):
        chances = evidence.partners
        fits = {name: grown.refit for name, grown in evidence.grown_beside(chances).items()}
        # What was only fitted beside a rival of the leader has no curve to compare.
        chances = {name: chance for name, chance in chances.items() if name in fits}
    return next_experiment(evidence.search.base, worth_telling_apart(chances), fits, chances)
