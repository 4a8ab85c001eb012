"""The search on data.

In units of a noise that is borne out, and without points that no physics explains.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError
from springpot.format_numbers import counted
from springpot.measurement.measurement import Measurement
from springpot.misfit.floor import as_given, borne_out, fitted_to_floor, sharpened
from springpot.misfit.outliers import (
    Outlier,
    are_outliers,
    described,
    ends_beside,
    outlying,
    pulling,
    side_by_side,
    without,
)
from springpot.misfit.refit import Refit, refit
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.thresholds import EVIDENCE, OUTLIERS, SEARCH, VERDICT

from .grown import Search
from .search import search_from


def search_data(
    measurement: Measurement,
    model: Model,
    library: Sequence[Effect],
    rng: np.random.Generator,
    seeds: Sequence[Real] = (),
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

    Returns
    -------
    Search, list of Outlier
        The search, and the points that were set aside for it.

    Raises
    ------
    DataError
        If there are too few data to judge the model.
    """
    search = _search_in_noise(measurement, model, library, rng, seeds)
    start = better_start(search)
    if start is not None:
        search = _search_in_noise(measurement, model, library, rng, [*seeds, start])
    if search.base.data.mean is not measurement:
        return search, []  # repeats tell by themselves which of them is off

    def reduced_by(rows: NDArray[np.int64]) -> Search:
        return _search_in_noise(without(measurement, rows), model, library, rng, seeds)

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
    if len(rows) == 0:
        return None
    reduced = reduced_by(rows)
    if not are_outliers((search.base, search.best), (reduced.base, reduced.best), len(rows)):
        return None
    if _sees_something(reduced) and _may_be_effects(reduced, measurement, rows, reduced_by):
        return None
    return reduced, described(reduced.base.frame_of(measurement), rows)


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
    if not search.grown or search.left.p_value >= VERDICT.structure_alarm:
        return None
    rows = pulling([search.frame, *(grown.refit.frame() for grown in search.grown)])
    if len(rows) == 0:
        return None
    reduced = reduced_by(rows)
    before, after = search.best.relative_rms, reduced.best.relative_rms
    if after**2 > OUTLIERS.settles * before**2:
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
) -> Search:
    base = fitted_to_floor(model, measurement, seeds)
    _require_enough(base, measurement)
    if base.noise.overruled:
        # Structure that a sweep is too short to show as such looks like scatter, until its effect
        # is found.
        search = search_from(as_given(base), library, rng)
        if borne_out(search.best):
            return search
    search = search_from(base, library, rng)
    # What moved with the frequency is no evidence for a cause, but what it follows so closely is no
    # noise.
    nearest = max(
        [search.best, *(grown.refit for grown in search.confounded)],
        key=lambda fit: fit.log_evidence,
    )
    gain = 2.0 * (nearest.log_evidence - search.base.log_evidence)
    if gain >= SEARCH.decisive and (sharper := sharpened(base, nearest)) is not None:
        search = search_from(sharper, library, rng)
    return search


def _require_enough(base: Refit, measurement: Measurement) -> None:
    if base.fit.dof < 1:
        points = counted(len(base.fit.measurement), "distinct point")
        raise DataError(
            f"{measurement.name}: {points} cannot judge a model of"
            f" {counted(len(base.theta), 'parameter')}; measure at more frequencies (springpot"
            " signals FILE... -o SWEEP.csv makes one table of records), or diagnose the record"
            " itself: columns time [s], displacement [mm], force [N]"
        )
