"""A material that is shifted from level to level of a condition: one fit for whatever command asks.

Where sweeps are straight (a power law) a factor of the stiffness and a shift of the frequency are
one, and the data leave both open along a ridge. Of all factors on it those are taken that physics
expects: a stiffness that goes with a power of temperature, and sweeps that repeat to some per cent.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from springpot.distributions import f_sf
from springpot.measurement.measurement import Measurement
from springpot.rheology.effect import Effect, Layer
from springpot.rheology.levels import Levels
from springpot.rheology.model import Model
from springpot.rheology.nodes import shift
from springpot.rheology.points import Real
from springpot.thresholds import SUPERPOSITION

from .expected_factors import Expected, expectation
from .free_factors import FactorRows, told_by_data
from .level_weights import shifted_by
from .native import Fit, fit
from .problem import Objective


def superposed_fit(
    model: Model,
    measurement: Measurement,
    objective: Objective,
    seeds_theta: Sequence[Real] = (),
    *,
    alone: Fit | None = None,
    unit: float | None = None,
) -> Fit:
    """A fit of a material and its shifts, free vertical factors as near to the expected as may be.

    Parameters
    ----------
    model : Model
        What is fitted; see `shifted_by`.
    measurement : Measurement
        To what.
    objective : Objective
        How points weigh; see `usual_objective`.
    seeds_theta : sequence of ndarray, shape (p,)
        Starts worth trying beside those read off the data.
    alone : Fit, optional
        The same without vertical factors, where it is known already.
    unit : float, optional
        Of a model with a law: the variance of a weighted residual that entirely free factors leave,
        where it is known already.
    """
    model = model.bound_to(measurement.points)
    lifts = [each for each in model.effects if each.by_levels and each.plane != "shift"]
    if not lifts or model.constrained:
        return fit(model, measurement, objective, seeds_theta=seeds_theta)
    # Shifts first: vertical factors could otherwise do what belongs to a shift.
    if alone is None:
        alone = fit(_without(model, lifts), measurement, objective)
    flat = _with_factors_of_one(alone, model)
    seeds = [*seeds_theta, flat.theta]
    by_law = any(not each.by_levels for each in model.effects)
    if by_law and unit is None:
        unit = _unit_of_factors(model, lifts, measurement, objective)
    if not by_law:
        free = fit(model, measurement, objective, seeds_theta=seeds)
        unit = FactorRows.of(free).unit
        seeds.append(free.theta)
    assert unit is not None
    expected = Expected(expectation(model), unit)
    best = fit(model, measurement, objective, seeds_theta=seeds, expected=expected)
    flat = replace(flat, expected=expected)
    if _needless(FactorRows.of(flat), FactorRows.of(best)):
        return flat
    return best


def _unit_of_factors(
    model: Model, lifts: Sequence[Effect], measurement: Measurement, objective: Objective
) -> float:
    """Variance of a weighted residual that a free factor at each level leaves in place of laws.

    Departures from the expected are weighed against it, whatever law the model has.
    """
    levels = Levels(shifted_by(model), "a", True)
    sideways = Effect("shift", shift, levels, "a factor for each level", Layer.TEMPERATURE)
    freest = replace(model, effects=(sideways, *lifts)).bound_to(measurement.points)
    flat = _with_factors_of_one(fit(_without(freest, lifts), measurement, objective), freest)
    return FactorRows.of(fit(freest, measurement, objective, seeds_theta=[flat.theta])).unit


def _without(model: Model, lifts: Sequence[Effect]) -> Model:
    return replace(model, effects=tuple(each for each in model.effects if each not in lifts))


def _with_factors_of_one(alone: Fit, model: Model) -> Fit:
    """A fit with shifts alone as one of the model with vertical factors too."""
    whole = replace(model, material=alone.model.material)
    known = dict(zip(alone.model.names, alone.theta.tolist(), strict=True))
    theta = np.array([known.get(name, 1.0) for name in whole.names])
    return replace(alone, model=whole, theta=theta)


def _needless(flat: FactorRows, best: FactorRows) -> bool:
    """Whether vertical factors of one do as well as those found."""
    # The lines are refined after the search for the factors, each time elsewhere: that can end
    # above where it began.
    if flat.objective <= best.objective:
        return True
    # On straight sweeps many factors follow the noise a little better than one does; that is no
    # reason for them.
    if np.sum(told_by_data(best, best.elements[-1].reference)) > 1:
        return False
    count, dof = len(best.elements[-1].free), max(best.fit.dof, 1)
    gain = (flat.fit.cost - best.fit.cost) / (count * best.unit)
    return bool(f_sf(gain, count, dof) >= SUPERPOSITION.alarm)
