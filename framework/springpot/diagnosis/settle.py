"""The search, with what it rests on put right on the way: the noise, and points that stand out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from springpot.errors import DataError
from springpot.identification import is_material
from springpot.measurement import Measurement
from springpot.rheology import Effect, Model, Real

from .floor import as_given, borne_out, fitted_to_floor, sharpened
from .outliers import Outlier, are_outliers, described, may_be_effects, outlying, without
from .refit import Refit, refit
from .search import Search, search

SUSPICIOUS = 0.01
"""Chance of a false alarm below which it is asked whether single points raise it."""
TOLD = 3
"""Grown models whose parameters are tried for the model alone."""
BETTER = 0.5
"""Gain in log-likelihood from which a fit has found another minimum."""
DECISIVE = 10.0
"""Drop of the information criterion from which the best model is trusted to tell the noise."""


class Settled(NamedTuple):
    """The search, and the points that were set aside for it."""

    found: Search
    outliers: list[Outlier]


def settled(
    measurement: Measurement,
    model: Model,
    library: Sequence[Effect],
    rng: np.random.Generator,
    seeds: Sequence[Real] = (),
) -> Settled:
    """Search for what is missing, without outliers and in units of a noise that the best model bears out.

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

    Raises
    ------
    DataError
        If there are too few data to judge the model.
    """
    found = _searched(measurement, model, library, rng, seeds)
    if (start := better_start(found)) is not None:
        found = _searched(measurement, model, library, rng, [*seeds, start])
    if min(found.scan.p_value, found.structure.p_value) > SUSPICIOUS or found.base.data.mean is not measurement:
        return Settled(found, [])
    rows = outlying(found.frame)
    if len(rows) == 0:
        return Settled(found, [])
    reduced = _searched(without(measurement, rows), model, library, rng, seeds)
    missing = min(reduced.scan.p_value, reduced.structure.p_value) < SUSPICIOUS
    if (missing and may_be_effects(measurement, rows)) or not are_outliers(found, reduced, len(rows)):
        return Settled(found, [])
    return Settled(reduced, described(reduced.base.frame_of(measurement), rows))


def better_start(found: Search) -> Real | None:
    """Parameters (p,) from which the user's model fits better than it did, read off the grown models.

    A grown model that fits far better has either found what is missing or left a local minimum behind; then the
    model alone fits as well from there, and nothing is missing at all.

    Parameters
    ----------
    found : Search
        A finished search.
    """
    base = found.base
    if not found.grown or min(found.scan.p_value, found.structure.p_value) > SUSPICIOUS:
        return None
    if is_material(base.model):
        return None  # its spectrum has no other minimum
    seeds = []
    for grown in found.grown[:TOLD]:
        values = dict(zip(grown.refit.model.names, grown.refit.theta, strict=True))
        seeds.append(np.array([values[name] for name in base.model.names]))
    again = refit(base.model, base.data, base.noise, seeds, starts=0)
    return again.theta if again.log_likelihood > base.log_likelihood + BETTER else None


def _searched(
    measurement: Measurement,
    model: Model,
    library: Sequence[Effect],
    rng: np.random.Generator,
    seeds: Sequence[Real],
) -> Search:
    base = fitted_to_floor(model, measurement, seeds)
    _require_enough(base, measurement)
    if base.noise.overruled:
        # Structure that a sweep is too short to show as such looks like scatter, until its effect is found.
        found = search(as_given(base), library, rng)
        if borne_out(found.best):
            return found
    found = search(base, library, rng)
    gain = 2.0 * (found.best.log_evidence - found.base.log_evidence)
    if gain >= DECISIVE and (sharper := sharpened(base, found.best)) is not None:
        found = search(sharper, library, rng)
    return found


def _require_enough(base: Refit, measurement: Measurement) -> None:
    if base.fit.dof < 1:
        raise DataError(
            f"{measurement.name}: {len(base.fit.measurement)} distinct points cannot judge a model of "
            f"{len(base.theta)} parameters; measure at more frequencies"
        )
