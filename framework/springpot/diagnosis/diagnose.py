"""The diagnosis from end to end: its steps stand in `examine`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeAlias

import numpy as np

from springpot.errors import ModelError
from springpot.identification import is_material, require_conditions
from springpot.measurement import Measurement, steadied, thinned
from springpot.misfit.leftover import Column, column_behind, one_test_of
from springpot.misfit.material import MaterialFloor, error_of, material_floor, split_in_words
from springpot.misfit.outliers import Outlier
from springpot.misfit.refit import Refit
from springpot.misfit.values import Value, printed
from springpot.misfit.where import Where, periodic, where
from springpot.misfit.words import times
from springpot.policy import EVIDENCE, EXPERIMENT, SEARCH, VERDICT
from springpot.rheology import Effect, Model, Real

from .evidence import Evidence, best_with
from .experiment import experiment_on_confounded, experiment_on_points, experiment_on_unknown, next_experiment
from .marginal import explaining_unknown
from .notes import header_notes, notes, unexplained_harmonics
from .result import Candidate, Diagnosis, EffectVerdict, NextExperiment, Verdict
from .scan import Score, scan_effects
from .search import Grown, Search, search_from, with_factors
from .searched_data import search_data
from .verdict import drifted, facts_of, leading_names, only_points, rule_for, sentence

Progress: TypeAlias = Callable[[str], None]
"""Called with a stage in a few words when it begins; whatever it raises ends the work."""


def silent(stage: str) -> None:
    """For those who do not ask."""


def within(whole: str, progress: Progress) -> Progress:
    """Stages of a part, told as such: ``step 1: fitting fractional-maxwell``."""

    def part(stage: str) -> None:
        progress(f"{whole}: {stage}")

    return part


BESIDE_MATERIAL = {
    "effect-missing": ", and beside it a part of the material that no single effect supplies",
    "unexplained": "; any linear material comes nearer than the model with any effect",
    "inconclusive": "; any linear material comes nearer than the model with any effect",
}
"""What is added where effects are named beside a free spectrum."""
OPEN = frozenset({"unexplained", "inconclusive"})
"""Verdicts after which the cause may be something that no effect knows, such as another column."""
HARMONICS = "; the force holds harmonics that this model does not make"


class GrownBy(NamedTuple):
    """A model with one more effect.

    Attributes
    ----------
    model : Model
        The grown model.
    theta : ndarray, shape (p,)
        Its parameters.
    refitted : bool
        Whether it was fitted with the effect; else the effect stands where the scan puts it, and the rest as before.
    """

    model: Model
    theta: Real
    refitted: bool


@dataclass(frozen=True, eq=False)
class Case:
    """All that a diagnosis found, for those who go on from it.

    Attributes
    ----------
    search : Search
        Fits and scans of the model.
    naming : Search
        Those by which effects are named: of the model, or of any material where the model does not follow it.
    floor : MaterialFloor
        The least error that any material reaches.
    evidence : Evidence
        Of every effect.
    outliers : tuple of Outlier
        Points set aside.
    diagnosis : Diagnosis
        The answer.
    """

    search: Search
    naming: Search
    floor: MaterialFloor
    evidence: Evidence
    outliers: tuple[Outlier, ...]
    diagnosis: Diagnosis

    def __repr__(self) -> str:
        return f"<Case {self.diagnosis!r:.200}>"

    def grown_with(self, effect: Effect) -> GrownBy:
        """The model as accepting one effect would make it, without a new fit.

        Parameters
        ----------
        effect : Effect
            Scanned or not: the ``physics`` of a candidate, or any other.

        Raises
        ------
        ModelError
            If the model cannot take the effect, the data lack a column that it needs, or nothing is known of it.

        Examples
        --------
        >>> import springpot
        >>> ladder = springpot.discover("artificial-hidden", "fractional-maxwell", accept="inertia")
        >>> case = ladder.steps[0].case
        >>> grown = case.grown_with(case.diagnosis.best.physics)
        >>> grown.model.name, grown.refitted
        ('fractional-maxwell + inertia', True)
        """
        base = self.search.base
        # A fit that was made is better than what the scan foretells of it.
        for grown in self.search.grown:
            if grown.names == (effect.name,):
                return GrownBy(grown.refit.model, grown.refit.theta, True)
        if effect.by_levels:
            raise ModelError(f"{effect.name} has a factor for each level, which only a fit can tell")
        require_conditions(base.model + effect, base.fit.measurement)
        scores = [score for score in self.search.scan.scores if score.influence.effect == effect]
        for score in scores or scan_effects(base, self.search.frame, [effect]).scores:
            for theta in score.starts[:1]:
                return GrownBy(score.influence.model, theta, False)
        raise ModelError(f"{effect.name} changes nothing that these data show of {base.model.name}")


def diagnose(
    measurement: Measurement,
    model: Model,
    library: Sequence[Effect],
    rng: np.random.Generator,
    progress: Progress = silent,
) -> Diagnosis:
    """Find what is missing from a model of measured data.

    Parameters
    ----------
    measurement : Measurement
        The data.
    model : Model
        The model to be judged.
    library : sequence of Effect
        Effects that may be missing.
    rng : numpy.random.Generator
        For simulated noise.
    progress : callable
        Told in a few words what is being done.

    Raises
    ------
    DataError
        If there are too few data to judge anything.
    ModelError
        If the data lack a column that the model needs.
    """
    return examine(measurement, model, library, rng, progress=progress).diagnosis


def examine(
    measurement: Measurement,
    model: Model,
    library: Sequence[Effect],
    rng: np.random.Generator,
    seeds: Sequence[Real] = (),
    progress: Progress = silent,
) -> Case:
    """As `diagnose`, with the fits and scans behind the answer, and with starts (p,) known from a smaller model."""
    # Before any fit: a column that is missing is told at once.
    require_conditions(model, measurement)
    data = _prepared(measurement, model)
    progress(f"fitting {model.name} and trying what may be missing from it")
    search, found = search_data(data, model, library, rng, seeds)
    # Users count rows in their own file, not in what thinning left of it.
    outliers = [outlier.counted_in(measurement) for outlier in found]
    progress("looking how near any material comes")
    # After the search: outliers are set aside and the noise is settled, so that both errors are in the same units.
    floor = material_floor(search.base, rng)
    naming = _naming_search(search, floor, library, rng, progress)
    progress("weighing what was found")
    evidence = Evidence.of(naming, naming is not search)
    verdict = rule_for(facts_of(evidence, outliers, naming is not search)).verdict
    if verdict == "adequate" and error_of(search.base, floor).is_hardly_noise:
        # Nothing is adequate beside an error of 40 %, whatever the scatter looks like.
        verdict = "inconclusive"
    # The chance of "unknown" must agree with the verdict, which rests on more than the evidence.
    if verdict == "effect-missing":
        evidence = evidence.without_unknown().beside_drift()
    elif verdict == "unexplained":
        evidence = evidence.doubted(naming.left.p_value)
    diagnosis = _answer(measurement, search, floor, evidence, outliers, verdict, library)
    return Case(search, naming, floor, evidence, tuple(outliers), diagnosis)


def _prepared(measurement: Measurement, model: Model) -> Measurement:
    """The points that are diagnosed, an amplitude that was held not counting as varied."""
    data = thinned(measurement)
    # A model that needs the amplitude is told every value of it, however little it varied.
    if "amplitude" in model.needs:
        return data
    return steadied(data)


def _naming_search(
    search: Search, floor: MaterialFloor, library: Sequence[Effect], rng: np.random.Generator, progress: Progress
) -> Search:
    """The search by which effects are named: that on any material, where the model and its effects leave structure.

    A model that cannot follow the material hides every other effect under its own misfit, and bends them to mend it.
    """
    if is_material(search.base.model) or search.left.p_value >= VERDICT.structure_alarm:
        return search
    progress("trying what may be missing beside any material")
    free = search_from(floor.refit, library, rng)
    # With a price for each line of the spectrum: beside models with a name its freedom is no gift.
    gain = 2.0 * (free.best.log_evidence_of_all - search.best.log_evidence_of_all)
    if gain > SEARCH.decisive:
        return free
    return search


def _answer(
    measurement: Measurement,
    search: Search,
    floor: MaterialFloor,
    evidence: Evidence,
    outliers: Sequence[Outlier],
    verdict: Verdict,
    library: Sequence[Effect],
) -> Diagnosis:
    """The answer as plain data and sentences, told of the user's own model whatever the names were found beside."""
    naming = evidence.search
    error = error_of(search.base, floor)
    # Noise that is hard to believe is told of first: until it is smaller, none of the rest is worth reading.
    doubted = verdict == "inconclusive" and error.is_hardly_noise
    candidates = candidates_of(evidence, verdict)
    leading = leading_names(search, evidence, verdict)
    column, one_test, split, classes, experiment = None, "", "", [], None
    if verdict in OPEN:
        column = column_behind(naming.best.frame())
        one_test, _ = one_test_of(search.base.data.raw, column)
    if verdict != "adequate":
        # Beside such noise, and beside single points alone, nothing is known to be missing that could be split.
        if not doubted and not only_points(search, outliers):
            split = split_in_words(search.base, floor)
        classes = evidence.classes
        # To look at one test needs no measurement: it comes first.
        if not one_test:
            experiment = _next_experiment(search, evidence, verdict, outliers, leading)
    says = _says(search, evidence, verdict, outliers, column)
    factors = None
    if verdict == "unexplained" and naming is search and not leading:
        factors = _by_factors(search, library)
    if factors is not None:
        leading = list(factors.names)
        says = f"{says}; {_factors_in_words(factors)}"
    told = [
        *notes(evidence, verdict, outliers, column, len(measurement), library),
        *header_notes(candidates, measurement),
    ]
    if doubted:
        told.insert(0, error.advice)
    return Diagnosis(
        data=search.base.data.raw.name,
        model=search.base.model,
        error=error,
        verdict=verdict,
        says=says,
        split=split,
        where=tuple(_places(search, outliers, verdict)),
        candidates=tuple(candidates),
        classes=tuple(tuple(group) for group in classes),
        next_experiment=experiment,
        notes=tuple(told),
        evidence=_chances(search, evidence),
        parameters=printed(search.base),
        leading=tuple(leading),
        one_test=one_test,
    )


def _says(
    search: Search, evidence: Evidence, verdict: Verdict, outliers: Sequence[Outlier], column: Column | None
) -> str:
    """The sentence of the verdict, with what was seen beside any material and in the force's harmonics."""
    says = sentence(search, evidence, verdict, outliers, column)
    if evidence.search is not search:
        says = f"{says}{BESIDE_MATERIAL[verdict]}"
    if unexplained_harmonics(evidence.search, verdict):
        says = f"{says}{HARMONICS}"
    return says


def _by_factors(search: Search, library: Sequence[Effect]) -> Grown | None:
    """The model with a factor at each level of a condition, where the misfit looks like a gain of its own at each."""
    unknown = explaining_unknown(search)
    if unknown is None or not unknown.gain_of:
        return None
    return with_factors(search, library, unknown.gain_of)


def _factors_in_words(factors: Grown) -> str:
    """What factors without a law explain, so that the user can go on with them and knows what they are."""
    left = times(factors.refit.relative_rms / factors.refit.floor)
    (effect,) = factors.effects
    (column,) = effect.needs
    return f"{effect.name} takes it to {left}: a gain of its own at each {column}, which no law joins"


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
    """Single points first, then bands, then what only a period shows."""
    yield from (outlier.place for outlier in outliers)
    bands = []
    if verdict != "adequate":
        bands = where(search.frame)
    yield from bands
    # A ripple of which no band is off to one side would else leave "unexplained" without a place.
    if not bands and verdict == "unexplained" and search.structure.parts["ripple"] < VERDICT.structure_alarm:
        yield periodic(search.frame)


def _next_experiment(
    search: Search, evidence: Evidence, verdict: Verdict, outliers: Sequence[Outlier], leading: Sequence[str]
) -> NextExperiment | None:
    """What would decide between effects that may be it, or where none may be, what would tell of the unknown."""
    # Whatever else is open: first the frequency and the amplitude must be told from each other.
    names = [grown.names[0] for grown in evidence.search.confounded]
    if evidence.moved:
        names = [name for name in evidence.classes[0] if name in evidence.moved]
    if names and verdict != "adequate":
        return experiment_on_confounded(evidence.search.base.fit.measurement, names)
    if only_points(search, outliers):
        return experiment_on_points(outliers)
    # The cheapest question of all, and no other measurement answers it.
    if evidence.drift is not None:
        return experiment_on_unknown(search.base.data.raw)
    # Effects that nobody believes in are not worth a measurement that tells them apart.
    experiment = None
    if verdict != "unexplained" or leading:
        experiment = _between_effects(evidence)
    # Where repeats drift, the very question has been answered.
    if experiment is None and verdict in OPEN and not drifted(search):
        experiment = experiment_on_unknown(search.base.data.raw)
    return experiment


def _between_effects(evidence: Evidence) -> NextExperiment | None:
    """What would settle the more open of two questions: which effect leads, and which one stands beside it."""
    if not evidence.explanations:
        return None
    chances, fits = evidence.rivals, evidence.likeliest_with()
    if _openness(evidence.partners) > _openness(chances):
        chances = evidence.partners
        fits = {name: grown.refit for name, grown in evidence.grown_beside(chances).items()}
    if _openness(chances) < EXPERIMENT.rival:
        return None
    if sorted(chances.values())[-2] < EXPERIMENT.believed:
        return None
    # Two, not all rivals: a measurement that separates the leading ones can be promised in one sentence.
    first, second = sorted(chances, key=lambda name: -chances[name])[:2]
    return next_experiment(fits[first], fits[second], (first, second), (chances[first], chances[second]))


def _openness(chances: Mapping[str, float]) -> float:
    """Odds of the second likeliest answer against the likeliest."""
    most = sorted(chances.values())[-2:]
    if len(most) < 2 or most[1] <= 0.0:
        return 0.0
    return most[0] / most[1]


def candidates_of(evidence: Evidence, verdict: Verdict) -> list[Candidate]:
    """All scanned effects as candidates, the likeliest first; none is missing where the verdict is another."""
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
        # Of the first class one member is missing for certain; any other must be likely in its own right.
        least = EVIDENCE.beside
        if groups and name in groups[0]:
            least = VERDICT.likely
        missing = verdict == "effect-missing" and chance > least * evidence.trust(name)
        # One of its class needs a condition that moved with the frequency: no fit can say which of them it is.
        if search.confounded and groups and name in groups[0]:
            missing = False
        word = _effect_verdict(search, score, best.get(name), missing)
        before, grown = search.base, alone.get(name)
        if name in beside:
            # An effect that only shows beside the leading one is told as it is there.
            grown = beside[name]
            if leader in alone:
                before = alone[leader].refit
        row = _candidate(before, score, grown)
        if name in beside:
            row = replace(row, says=f"beside {leader}: {row.says}")
        rows.append(replace(row, alike=class_of.get(name, (name,)), probability=chance, verdict=word))
    # The leader first: it stands for its class, of which another member may be as likely.
    rows.sort(key=lambda row: (row.effect != leader, -row.probability, -row.delta_bic))
    return rows


def _candidate(before: Refit, score: Score, grown: Grown | None) -> Candidate:
    """What one effect does when it joins a fitted model: the user's alone, or that with the leading effect."""
    effect = score.influence.effect
    row = Candidate(
        physics=effect,
        alike=(effect.name,),
        probability=0.0,
        delta_bic=-np.inf,
        score=score.score,
        verdict="cannot-tell",
        predicted_error=_predicted(before, score.predicted),
        error_after=before.relative_rms,
        bound=score.bound,
        parameters={},
        says=effect.summary,
    )
    if grown is None:
        return row
    return replace(
        row,
        delta_bic=2.0 * (grown.refit.log_evidence - before.log_evidence),
        predicted_error=_predicted(before, grown.predicted),
        error_after=grown.refit.relative_rms,
        parameters=_parameters(grown.refit, effect),
    )


def _predicted(before: Refit, left: float) -> float:
    """Relative error that is foretold, from the sum of squares that is."""
    return before.relative_rms * float(np.sqrt(max(left, 0.0) / max(before.rss, 1e-300)))


def _effect_verdict(search: Search, score: Score, best: Refit | None, missing: bool) -> EffectVerdict:
    gain = -np.inf
    if best is not None:
        gain = 2.0 * (best.log_evidence - search.base.log_evidence)
    # A probability shared among few rivals may be large where the data hardly speak: the gain must be clear too.
    if missing and gain >= VERDICT.clear_evidence:
        return "missing"
    # Not seen is not absent: only where the data would have shown a small one.
    if gain < 0.0 and score.bound < VERDICT.seen:
        return "absent"
    return "cannot-tell"


def _parameters(refit: Refit, effect: Effect) -> dict[str, Value]:
    """The effect's own parameters in printed units, without the prefix of its name."""
    own = {}
    for name, value in printed(refit).items():
        prefix, _, short = name.rpartition(".")
        if prefix.partition("#")[0] == effect.name:
            own[short] = value
    return own
