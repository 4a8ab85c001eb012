"""The diagnosis from end to end: its steps stand in `examine`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np

from springpot.errors import ModelError
from springpot.identification.material import is_material
from springpot.identification.space import require_conditions
from springpot.measurement.independence import steadied
from springpot.measurement.measurement import Measurement
from springpot.measurement.replicates import thinned
from springpot.misfit.drift_in_time import Course
from springpot.misfit.material import MaterialFloor, error_of, material_floor
from springpot.misfit.outliers import Outlier
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.thresholds import SEARCH, VERDICT

from .answer import answer, course_instead
from .evidence import Evidence
from .grown import Search
from .result import Diagnosis
from .scan import scan_effects
from .search import search_from
from .searched_data import search_data
from .verdict import facts_of, rule_for

Progress: TypeAlias = Callable[[str], None]
"""Called with a stage in a few words when it begins; whatever it raises ends the work."""


def silent(stage: str) -> None:
    """For those who do not ask."""


def within(whole: str, progress: Progress) -> Progress:
    """Stages of a part, told as such: ``step 1: fitting fractional-maxwell``."""

    def part(stage: str) -> None:
        progress(f"{whole}: {stage}")

    return part


class GrownBy(NamedTuple):
    """A model with one more effect.

    Attributes
    ----------
    model : Model
        The grown model.
    theta : ndarray, shape (p,)
        Its parameters.
    refitted : bool
        Whether it was fitted with the effect; else the effect stands where the scan puts it, and
        the rest as before.
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
        Those by which effects are named: of the model, or of any material where the model does not
        follow it.
    floor : MaterialFloor
        The least error that any material reaches.
    evidence : Evidence
        Of every effect.
    outliers : tuple of Outlier
        Points set aside.
    diagnosis : Diagnosis
        The answer.
    course : Course or None
        How the specimen changed with time, where that is what the misfit goes with.
    """

    search: Search
    naming: Search
    floor: MaterialFloor
    evidence: Evidence
    outliers: tuple[Outlier, ...]
    diagnosis: Diagnosis
    course: Course | None = None

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
            If the model cannot take the effect, the data lack a column that it needs, or nothing is
            known of it.

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
                return GrownBy(grown.refit.identified.model, grown.refit.identified.theta, True)
        if effect.by_levels:
            raise ModelError(
                f"{effect.name} has a factor for each level, which only a fit can tell"
            )
        if not effect.element.parameters:
            raise ModelError(f"{effect.name} has no parameter, and nothing of it can be fitted")
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
    """As `diagnose`, with the fits and scans behind the answer.

    Starts (p,) may be known from a smaller model.
    """
    # Before any fit: a column that is missing is told at once.
    require_conditions(model, measurement)
    data = _prepared(measurement, model)
    progress(f"fitting {model.name} and trying what may be missing from it")
    search, set_aside = search_data(data, model, library, rng, seeds)
    # Users count rows in their own file, not in what thinning left of it.
    outliers = [outlier.counted_in(measurement) for outlier in set_aside]
    progress("looking how near any material comes")
    # After the search: outliers are set aside and the noise is settled, so that both errors are in
    # the same units.
    floor = material_floor(search.base, rng)
    naming = _naming_search(search, floor, library, rng, progress)
    progress("weighing what was found")
    evidence = Evidence.of(naming, naming is not search)
    verdict = rule_for(facts_of(evidence, outliers, naming is not search)).verdict
    if verdict == "adequate" and error_of(search.base, floor).is_hardly_noise:
        # Nothing is adequate beside an error of 40 %, whatever the scatter looks like.
        verdict = "inconclusive"
    course = course_instead(evidence, verdict)
    if course is not None:
        # What only the time tells has no name in any library, however well an effect imitates a
        # part of it.
        verdict = "unexplained"
    # The chance of "unknown" must agree with the verdict, which rests on more than the evidence.
    if verdict == "effect-missing":
        evidence = evidence.without_unknown().beside_drift()
    elif verdict == "unexplained":
        evidence = evidence.doubted(naming.left.p_value).beside_drift()
    diagnosis = answer(measurement, search, floor, evidence, outliers, verdict, library, course)
    return Case(search, naming, floor, evidence, tuple(outliers), diagnosis, course)


def _prepared(measurement: Measurement, model: Model) -> Measurement:
    """The points that are diagnosed, an amplitude that was held not counting as varied."""
    data = thinned(measurement)
    # A model that needs the amplitude is told every value of it, however little it varied.
    if "amplitude" in model.needs:
        return data
    return steadied(data)


def _naming_search(
    search: Search,
    floor: MaterialFloor,
    library: Sequence[Effect],
    rng: np.random.Generator,
    progress: Progress,
) -> Search:
    """The search by which effects are named.

    That on any material, where the model and its effects leave structure.

    A model that cannot follow the material hides every other effect under its own misfit, and bends
    them to mend it.
    """
    if is_material(search.base.model) or search.left.p_value >= VERDICT.structure_alarm:
        return search
    progress("trying what may be missing beside any material")
    beside_material = search_from(floor.refit, library, rng)
    # With a price for each line of the spectrum: beside models with a name its freedom is no gift.
    gain = 2.0 * (beside_material.best.log_evidence_of_all - search.best.log_evidence_of_all)
    if gain > SEARCH.decisive:
        return beside_material
    return search
