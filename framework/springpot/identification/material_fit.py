"""The search for the parameters of effects around any linear passive material."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from springpot.measurement.measurement import Measurement
from springpot.measurement.replicates import thinned as thinned_rows
from springpot.rheology.model import Model
from springpot.rheology.points import Real

from .alignment import aligned, laid_over
from .material import ITERATIONS, STILL, Spectral, SpectrumSearch, Trial
from .objective import Objective, relative_objective
from .ranges import Window, settings
from .starts import thinned

SETTINGS = 6
"""Settings that are tried of each parameter of an effect for each start."""
STARTS = 8
"""Starts for which settings are tried at most, and where nothing else is known."""
MOST_SETTINGS = 192
"""Settings that are tried at most, however many effects there are: each costs a convex problem."""
KEPT = 2
"""Settings from which the search begins."""
COARSE_POINTS = 120
"""Of more points so many show the effects' parameters; the last steps are taken with all of them.
"""
LAST = 3
"""Steps with all points: each squares the error that was left."""
MENDED = 0.98
"""Share of the objective that closer lines leave at least where the first lattice was close enough.
"""


def fit_spectrum(
    model: Model,
    measurement: Measurement,
    objective: Objective,
    seeds_theta: Sequence[Real] = (),
    starts: int = 8,
    *,
    still: float = STILL,
    hopeless: float = np.inf,
    expected: Real | None = None,
) -> Spectral:
    """Fit a material, and the effects around it, to a measurement.

    Parameters
    ----------
    model : Model
        Its material is a `Continuum`.
    measurement : Measurement
        The data.
    objective : Objective
        How the misfit is measured; a logarithmic one by its weights relative to |K|.
    seeds_theta : sequence of ndarray
        Starts, of which the last numbers are the effects' parameters.
    starts : int
        How many starts read off the data settings of the effects' parameters stand for; 0 where
        the seeds are to be the only ones.
    still : float
        Relative drop of the objective below which a descent ends.
    hopeless : float
        Objective above which a descent ends after its first steps.
    expected : ndarray, shape (r, q), optional
        What is known of the effects' q parameters beforehand: the squares of these rows times their
        logarithms are added to the objective (Tikhonov's regularisation).
    """
    search = coarse = SpectrumSearch.of(model, measurement, objective, expected)
    # A material alone is a convex problem: nothing is searched but its lines.
    if not search.own:
        return search.result(search.refined(search.solve(np.zeros(0))), True)
    rows = thinned(measurement.points.log_omega, COARSE_POINTS)
    part = len(rows) / len(measurement)
    if len(rows) < len(measurement):
        if expected is not None:
            # What is expected weighs against the points: of fewer points as much less.
            expected = np.sqrt(part) * expected
        coarse = SpectrumSearch(model, measurement.subset(rows), search.weights[rows], expected)
    count = len(search.own)
    seeds = [np.asarray(seed, dtype=float)[len(seed) - count :] for seed in seeds_theta]
    settings_of_each = 0
    if not seeds:
        settings_of_each = SETTINGS * STARTS
    elif starts:
        # Beside seeds too: those of a scan may all lie in one valley, and it need not be the
        # deepest.
        settings_of_each = SETTINGS * min(starts, STARTS)
    places = [seeds]
    if settings_of_each:
        tried = list(_settings(search, measurement, settings_of_each))
        places += [tried, laid_over(model, measurement, tried[0])]
    ends = []
    for some in places:
        # A setting costs one convex problem; descents are begun only from the best of them.
        trials = sorted(
            (coarse.solve(coarse.u_of(own)) for own in some), key=lambda trial: trial.cost
        )
        ends += [
            coarse.descend(trial, ITERATIONS, still, hopeless * part) for trial in trials[:KEPT]
        ]
    best, converged = min(ends, key=lambda end: end[0].cost)
    if coarse is not search:
        start = search.solve(search.u_of(coarse.theta_of(best.u)))
        best, _ = search.descend(start, LAST)
        search.evaluations += coarse.evaluations
    return search.result(_on_closer_lines(search, best), converged)


def least_error(model: Model, measurement: Measurement, known: Sequence[Real]) -> float:
    """The least relative error, as printed, of any linear passive material with a model's effects.

    Parameters
    ----------
    model : Model
        Its material is a `Continuum`.
    measurement : Measurement
        The rows over which the error is taken.
    known : sequence of ndarray, shape (q,)
        Parameters of the effects from which the search begins; of no effect one that is empty.
    """
    # Of many rows some show where the lines are, and all of them what these leave.
    few = thinned_rows(measurement)
    search = SpectrumSearch.of(model, few, relative_objective())
    trials = sorted((search.solve(search.u_of(own)) for own in known), key=lambda trial: trial.cost)
    # No line is spared for the degrees of freedom: they are no part of an error.
    ends = [search.refined(search.descend(trial)[0]) for trial in trials[:KEPT]]
    best = min(ends, key=lambda trial: trial.cost)
    if few is not measurement:
        whole = SpectrumSearch.of(model, measurement, relative_objective())
        best = whole.solve(best.u, best.log_rates)
    return float(np.sqrt(best.cost / len(measurement)))


def _on_closer_lines(search: SpectrumSearch, trial: Trial) -> Trial:
    """The same with closer lines, the effects refitted where those alone have mended much.

    Of single Maxwell elements between the lines of the first lattice, the parameters had to follow
    what the lines could not: shifts were 2 % off, and the error was 1.2 x that of the noise.
    """
    finer = search.refined(trial)
    for _ in range(LAST):
        if finer.cost > MENDED * trial.cost:
            return finer
        trial = finer
        again, _ = search.descend(trial, LAST, lines=trial.log_rates)
        finer = search.refined(again)
        if finer.cost >= trial.cost:
            return trial
    return finer


def _settings(search: SpectrumSearch, measurement: Measurement, each: int) -> Real:
    """Settings (m, q) of the effects' parameters, so many of each.

    Factors of levels are read off the data.
    """
    known: dict[str, float] = {}
    if any(effect.by_levels for effect in search.model.effects):
        # A factor for each level is too many to be tried: overlapping sweeps tell where it lies.
        known = aligned(search.model, measurement)
    scanned = np.array([parameter.name not in known for parameter in search.own])
    count = min(each * int(scanned.sum()), MOST_SETTINGS) or 1
    places = np.tile([known.get(parameter.name, 1.0) for parameter in search.own], (count, 1))
    if scanned.any():
        others = tuple(parameter for parameter in search.own if parameter.name not in known)
        places[:, scanned] = settings(others, Window.of(measurement), count)
    return places
