"""The search for the parameters of effects around any linear passive material."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from springpot.measurement.measurement import Measurement
from springpot.measurement.replicates import thinned as thinned_rows
from springpot.rheology.continuum import Continuum
from springpot.rheology.effect import Effect
from springpot.rheology.levels import Levels, levels_of
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.rheology.thermal import arrhenius, wlf

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
ROUNDS = 8
"""Rounds in which lines and effects move together; nearly all fits come to rest in two."""
MENDED = 0.998
"""Share of the objective that a round leaves at least where there is nothing more to be had."""


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
    best, converged = _deepest(coarse, places, still, hopeless * part)
    if coarse is not search:
        start = search.solve(search.u_of(coarse.theta_of(best.u)))
        best, _ = search.descend(start, LAST)
        search.evaluations += coarse.evaluations
    best = _on_closer_lines(search, best)
    if settings_of_each and expected is None:
        lower = [end for end in _on_laws(search, measurement, objective) if end.cost < best.cost]
        ends = (_on_closer_lines(search, end) for end in lower)
        best = min(ends, key=lambda each: each.cost, default=best)
    return search.result(best, converged)


def _deepest(
    search: SpectrumSearch, places: Sequence[Iterable[Real]], still: float, hopeless: float
) -> tuple[Trial, bool]:
    """The best end of descents from the best starts of each kind; whether it came to rest."""
    ends = []
    for some in places:
        # A setting costs one convex problem; descents are begun only from the best of them.
        trials = sorted(
            (search.solve(search.u_of(own)) for own in some), key=lambda trial: trial.cost
        )
        ends += [search.descend(trial, ITERATIONS, still, hopeless) for trial in trials[:KEPT]]
    return min(ends, key=lambda end: end[0].cost)


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
    """The same with closer lines, which move together with the effects' parameters.

    One after the other they creep along a valley: of single Maxwell elements between the lines of
    the first lattice the factors were such that these lines fitted best, and the error stayed at
    1.5 x that of the noise.
    """
    finer = search.refined(trial)
    for _ in range(ROUNDS):
        again, _ = search.descend(finer, LAST, lines=search.about(finer))
        again = search.nearest(again)
        if not again.cost < MENDED * finer.cost:
            return min(again, finer, key=lambda each: each.cost)
        finer = again
    return finer


def _on_laws(search: SpectrumSearch, measurement: Measurement, objective: Objective) -> list[Trial]:
    """Ends of the laws of temperature that free factors of it contain.

    Above none of them may the search for the factors end.
    """
    model = search.model
    free = [
        effect
        for effect in model.effects
        if effect.by_levels and effect.plane == "shift" and effect.needs == {"temperature"}
    ]
    # What is held is no longer free to follow a law.
    if len(free) != 1 or model.constrained:
        return []
    ends, material = [], model.material
    assert isinstance(material, Continuum)
    for element in (arrhenius(), wlf()):
        law = replace(free[0], element=element)
        effects = tuple(law if effect is free[0] else effect for effect in model.effects)
        lawful = replace(model, material=replace(material, rates=()), effects=effects)
        if 2 * len(measurement) <= len(lawful.parameters):
            continue
        ended = fit_spectrum(lawful, measurement, objective)
        ends.append(_as_factors(search, free[0], law, ended))
    return ends


def _as_factors(search: SpectrumSearch, free: Effect, law: Effect, ended: Spectral) -> Trial:
    """A fitted law as free factors, with its lines."""
    points, levels = search.points, free.element
    assert isinstance(levels, Levels)
    known = dict(zip(ended.model.names, ended.theta.tolist(), strict=True))
    constants = np.array([known[f"{law.name}.{p.name}"] for p in law.element.parameters])
    number = levels_of(levels.column, points.need(levels.column))
    log_a = law.element.respond(constants, points).value.real
    log_a = np.bincount(number, log_a) / np.bincount(number)
    at_reference = log_a[levels.reference]
    factors = np.exp(log_a - at_reference)[list(levels.free)].tolist()
    names = [f"{free.name}.{parameter.name}" for parameter in levels.parameters]
    known |= dict(zip(names, factors, strict=True))
    material = ended.model.material
    assert isinstance(material, Continuum)
    # The curve is that of the level at which the factor is one.
    lines = np.log(np.array(material.rates)) - at_reference
    own = np.array([known[parameter.name] for parameter in search.own])
    return search.solve(search.u_of(own), lines)


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
