"""The diagnosis from end to end: its steps stand in `examine`.

The search itself is in units of a noise that is borne out, and without points that no physics
explains.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError
from springpot.identification.material import is_material
from springpot.identification.searching import refound
from springpot.identification.space import require_conditions
from springpot.measurement.independence import steadied
from springpot.measurement.measurement import Measurement
from springpot.measurement.mixed_up import turned
from springpot.measurement.replicates import thinned
from springpot.misfit.floor import (
    as_given,
    borne_out,
    fitted_to_floor,
    likelihood_of_all,
    remembered,
    sharpened,
)
from springpot.misfit.material import MaterialFloor, error_of, material_floor
from springpot.misfit.outliers import (
    Outlier,
    are_outliers,
    described,
    ends_beside,
    off_from_repeats,
    outlying,
    pulling,
    side_by_side,
    without,
)
from springpot.misfit.refit import Refit, in_noise, refit
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.thresholds import EVIDENCE, OUTLIERS, SEARCH, VERDICT
from springpot.writing import counted

from .answer import answer, course_instead
from .evidence import Evidence
from .grown import Search, Seek
from .in_practice import Accuracy, Misfit, in_practice
from .ladder import Case
from .result import Diagnosis, Fitted, Progress, silent, unseen
from .search import go_on_from, search_from
from .verdict import facts_of, rule_for


def search_data(
    measurement: Measurement,
    model: Model,
    library: Sequence[Effect],
    rng: np.random.Generator,
    seeds: Sequence[Real] = (),
    seek: Seek = search_from,
    begun: Search | None = None,
) -> tuple[Search, list[Outlier]]:
    """Look for what is missing, without outliers and in units of a noise that is borne out.

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
    seeds : sequence of ndarray, shape (p,)
        Starts worth trying beside those read off the data.
    seek : callable
        How it is looked for beside a fit whose noise is settled.
    begun : Search, optional
        What was found of all points already.

    Returns
    -------
    Search, list of Outlier
        The search, and the points that were set aside for it.

    Raises
    ------
    DataError
        If there are too few data to judge the model.
    """
    # Repeats tell by themselves which of them is off, before any model is asked.
    off = off_from_repeats(measurement)
    whole = measurement
    if len(off):
        begun, measurement = None, without(whole, off)
    if begun is None:
        search = _search_in_noise(measurement, model, library, rng, seeds, seek)
    else:
        search = _in_sharper_noise(begun, library, rng, seek)
    start = better_start(search)
    if start is not None:
        search = _search_in_noise(measurement, model, library, rng, [*seeds, start], seek)
    if search.base.data.mean is not measurement:
        return search, described(search.base.frame_of(whole), off)

    def reduced_by(rows: NDArray[np.int64]) -> Search:
        return _search_in_noise(without(measurement, rows), model, library, rng, seeds, seek)

    # A point that bends the curve can make its neighbour stand out: it is sought first.
    for way in (_without_a_pulling_point, _without_outliers):
        without_points = way(search, measurement, reduced_by)
        if without_points is not None:
            return without_points
    return search, []


Reduced: TypeAlias = Callable[[NDArray[np.int64]], Search]
"""The search anew without some rows."""


def _without_outliers(
    search: Search, measurement: Measurement, reduced_by: Reduced
) -> tuple[Search, list[Outlier]] | None:
    """The search without points that stand out from their neighbours.

    None where none are or they may be physics.
    """
    rows = outlying(search.frame)
    # What is missing hides a bad point: the best model found shows it where the base does not.
    hidden = len(rows) == 0 and bool(search.grown)
    if hidden:
        rows = outlying(search.best.frame())
    if len(rows) == 0:
        return None
    reduced = reduced_by(rows)
    if not are_outliers((search.base, search.best), (reduced.base, reduced.best), len(rows)):
        return None
    if _sees_something(reduced) and _may_be_effects(reduced, measurement, rows, reduced_by):
        return None
    seen = reduced.base
    if hidden:
        seen = reduced.best
    return reduced, described(seen.frame_of(measurement), rows)


def _may_be_effects(
    reduced: Search, measurement: Measurement, rows: NDArray[np.int64], reduced_by: Reduced
) -> bool:
    """Whether what makes rows stand out may be physics: something is missing without them too."""
    if side_by_side(measurement, rows):
        return True
    ends = ends_beside(measurement, rows)
    if len(ends) == 0:
        return False
    # What is named must be seen without the end: else it rests on the row beside the one that was
    # set aside.
    try:
        inner = reduced_by(np.union1d(rows, ends))
    except DataError:
        return True  # too few rows are left to see anything
    if not _sees_something(inner):
        return True
    # One of its rivals may fit the inner points a little better: that does not take it back.
    least = inner.best.log_evidence - EVIDENCE.rivals
    named = sorted(reduced.grown[0].names)
    return not any(
        sorted(grown.names) == named and grown.refit.log_evidence > least for grown in inner.grown
    )


def _sees_something(search: Search) -> bool:
    """Whether something is missing beside the points that were set aside.

    By an alarm, or by an effect's evidence.
    """
    return bool(search.grown) and (
        search.alarm < SEARCH.suspicious or search.gain >= SEARCH.decisive
    )


def _without_a_pulling_point(
    search: Search, measurement: Measurement, reduced_by: Reduced
) -> tuple[Search, list[Outlier]] | None:
    """The search without a point that bends every model, if one then explains almost all else."""
    alarmed = search.left.p_value < VERDICT.structure_alarm
    # Where an effect is seen without an alarm it goes before a point.
    if not search.grown or (not alarmed and _sees_something(search)):
        return None
    rows = pulling([search.frame, *(grown.refit.frame() for grown in search.grown)], alarmed)
    if len(rows) == 0:
        return None
    reduced = reduced_by(rows)
    # What it bent hid another bad point: it made the next one stand out in its place.
    kept = np.setdiff1d(np.arange(len(measurement)), rows)
    if len(others := outlying(reduced.frame)):
        rows = np.union1d(rows, kept[others])
        reduced = reduced_by(rows)
    # Of a misfit, not of an error: noise is left without any point.
    noise = reduced.best.floor**2
    before, after = (fit.relative_rms**2 - noise for fit in (search.best, reduced.best))
    if after > OUTLIERS.settles * before:
        return None
    if not are_outliers((search.base, search.best), (reduced.base, reduced.best), len(rows)):
        return None
    if _sees_something(reduced) and _may_be_effects(reduced, measurement, rows, reduced_by):
        return None
    return reduced, described(reduced.best.frame_of(measurement), rows)


def better_start(search: Search) -> Real | None:
    """Parameters (p,) from which the user's model fits better, read off the grown models.

    A grown model that fits far better has either found what is missing or left a local minimum
    behind; then the model alone fits as well from there, and nothing is missing at all.

    Parameters
    ----------
    search : Search
        A finished search.
    """
    base = search.base
    if not search.grown or search.alarm > SEARCH.suspicious:
        return None
    if base.has_one_minimum:
        return None
    seeds = [base.seed_from(grown.refit) for grown in search.grown[: SEARCH.tried_alone]]
    again = refit(base.model, base.data, base.noise, seeds, starts=0)
    if again.log_likelihood <= base.log_likelihood + SEARCH.better:
        return None
    return again.theta


def _search_in_noise(
    measurement: Measurement,
    model: Model,
    library: Sequence[Effect],
    rng: np.random.Generator,
    seeds: Sequence[Real],
    seek: Seek,
) -> Search:
    base = fitted_to_floor(model, measurement, seeds)
    _require_enough(base, measurement)
    if base.noise.overruled:
        # Structure that a sweep is too short to show as such looks like scatter, until its effect
        # is found.
        search = seek(as_given(base), library, rng)
        if borne_out(search.best):
            return search
    return _in_sharper_noise(seek(base, library, rng), library, rng, seek)


def _in_sharper_noise(
    search: Search, library: Sequence[Effect], rng: np.random.Generator, seek: Seek
) -> Search:
    """The search anew in the smaller noise that its best tells of, if it does."""
    # What moved with the frequency is no evidence for a cause, but what it follows so closely is no
    # noise.
    nearest = max(
        [search.best, *(grown.refit for grown in search.confounded)],
        key=lambda fit: fit.log_evidence,
    )
    gain = 2.0 * (nearest.log_evidence - search.base.log_evidence)
    # What goes on from point to point may be noise, unless an effect explains it better.
    tried = 2.0 * float(np.log(max(len(library), 1)))
    if (noisier := remembered(search.base, gain - tried)) is not None:
        return seek(noisier, library, rng)
    sure = gain >= SEARCH.decisive
    if not sure and not search.base.noise.memory:
        return search
    sharper = sharpened(search.base, nearest)
    if sharper is not None and (sure or _passed_for_memory(search.base, nearest, sharper)):
        return go_on_from(seek(sharper, library, rng), search, rng)
    return search


def _passed_for_memory(base: Refit, nearest: Refit, sharper: Refit) -> bool:
    """Whether the memory of a noise is a misfit, which a better model explains.

    Read beside the misfit the memory is as long as that, and leaves each point worth next to
    nothing: in such noise no effect has evidence. So each model is weighed in its own.
    """
    own = in_noise(nearest, sharper.noise)
    return 2.0 * (likelihood_of_all(own) - likelihood_of_all(base)) >= SEARCH.decisive


def _require_enough(base: Refit, measurement: Measurement) -> None:
    if base.fit.dof < 1:
        points = counted(len(base.fit.measurement), "distinct point")
        raise DataError(
            f"{measurement.name}: {points} cannot judge a model of"
            f" {counted(len(base.theta), 'parameter')}; measure at more frequencies (springpot"
            " signals FILE... -o SWEEP.csv makes one table of records), or diagnose the record"
            " itself: columns time [s], displacement [mm], force [N]"
        )


def diagnose(
    measurement: Measurement,
    model: Model,
    library: Sequence[Effect],
    rng: np.random.Generator,
    progress: Progress = silent,
    accuracy: Accuracy | None = None,
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
    accuracy : Accuracy, optional
        What the instrument promises: a misfit within it is no verdict on the model.

    Raises
    ------
    DataError
        If there are too few data to judge anything.
    ModelError
        If the data lack a column that the model needs.
    """
    case = examine(measurement, model, library, rng, progress=progress, accuracy=accuracy)
    return case.diagnosis


def examine(
    measurement: Measurement,
    model: Model,
    library: Sequence[Effect],
    rng: np.random.Generator,
    seeds: Sequence[Real] = (),
    progress: Progress = silent,
    accuracy: Accuracy | None = None,
    fitted: Fitted = unseen,
) -> Case:
    """As `diagnose`, with the fits and scans behind the answer.

    Starts (p,) may be known from a smaller model; `accuracy` is what the instrument promises;
    `fitted` is given each effect that was fitted by itself.
    """
    # Before any fit: a column that is missing is told at once.
    require_conditions(model, measurement)
    data, library = prepared(measurement, model), _asked_of(measurement, library)
    progress(f"fitting {model.name} and trying what may be missing from it")
    seek = partial(search_from, fitted=fitted)
    search, set_aside = search_data(data, model, library, rng, seeds, seek)
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
        evidence = evidence.without_unknown().beside_drift().beside_untold(library)
    elif verdict == "unexplained":
        evidence = evidence.doubted(naming.left.p_value).beside_drift()
    diagnosis = answer(measurement, search, floor, evidence, outliers, verdict, library, course)
    diagnosis = replace(diagnosis, left_out=search.scan.mute)
    if not outliers:
        # Of points that were set aside no fit tells how far they are off.
        diagnosis = in_practice(diagnosis, [misfit_of(search.base)], accuracy)
    if accuracy is not None:
        fit, raw = search.base.identified, search.base.data.raw
        values = accuracy.beside(diagnosis.parameters, fit, [raw], raw.units, refound(fit))
        diagnosis = replace(diagnosis, parameters=values)
    return Case(search, naming, floor, evidence, tuple(outliers), diagnosis, course)


def misfit_of(base: Refit) -> Misfit:
    """How far the model lies beside each measured value, repeats one by one."""
    raw = base.data.raw
    return Misfit.of_stiffness(base.model.stiffness(base.theta, raw.points), raw.stiffness)


def prepared(measurement: Measurement, model: Model) -> Measurement:
    """The points that are diagnosed, an amplitude that was held not counting as varied.

    Parameters
    ----------
    measurement : Measurement
        The data.
    model : Model
        What is judged.
    """
    data = thinned(measurement)
    # A model that needs the amplitude is told every value of it, however little it varied.
    if "amplitude" in model.needs:
        return data
    return steadied(data)


def _asked_of(measurement: Measurement, library: Sequence[Effect]) -> Sequence[Effect]:
    """Effects that are looked for: none before a channel of the wrong sign is turned."""
    return () if turned(measurement.provenance) else library


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
