"""Vertical factors that depart least from what is known of them before the data speak.

Where sweeps are straight (a power law) a factor of the stiffness and a shift of the frequency are
one, and the data leave both open along a ridge. Of all factors on it those are taken that physics
expects: a stiffness that goes with a power of temperature, and sweeps that repeat to some per cent.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from springpot.distributions import f_sf
from springpot.identification.expected_factors import Expected, expectation
from springpot.identification.free_factors import FactorRows, told_by_data
from springpot.identification.material_fit import aligned
from springpot.identification.native import Fit, fit
from springpot.rheology.effect import Effect, Layer
from springpot.rheology.levels import Levels
from springpot.rheology.model import Model
from springpot.rheology.nodes import chain
from springpot.thresholds import SUPERPOSITION


def lifted(alone: Fit, column: str) -> FactorRows:
    """With vertical factors, begun where the shifts alone have ended.

    Parameters
    ----------
    alone : Fit
        A material with shifts.
    column : str
        The condition along which both stand.
    """
    data = alone.measurement
    upwards = Effect(
        "vertical", chain, Levels(column, "b", False), "a factor for each level", Layer.TEMPERATURE
    )
    unfitted = replace(FactorRows.of(alone).material, rates=())
    model = (replace(alone.model, material=unfitted) + upwards).bound_to(data.points)
    own = alone.theta[len(alone.model.material.parameters) :]
    unlifted = np.concatenate([own, np.ones(len(own))])
    read_off = np.array(list(aligned(model, data).values()))
    # Two ways in, because few sweeps that hardly overlap can have two optima.
    free = fit(model, data, alone.objective, seeds_theta=[unlifted, read_off])
    # What the freest factors leave is the scatter that departures from the expected are weighed
    # against.
    rows = FactorRows.of(free)
    expected = Expected(expectation(rows.elements), rows.unit)
    seeds = [unlifted, read_off, free.theta]
    best = FactorRows.of(
        fit(model, data, alone.objective, seeds_theta=seeds, expected=expected.weighted), expected
    )
    flat = FactorRows.of(_with_factors_of_one(alone, model), expected)
    if _needless(flat, best):
        return flat
    return best


def _with_factors_of_one(alone: Fit, model: Model) -> Fit:
    """A fit with shifts alone as one of the model with vertical factors too."""
    material = alone.model.material
    shifts = alone.theta[len(material.parameters) :]
    theta = np.concatenate([alone.theta, np.ones(len(shifts))])
    return replace(alone, model=replace(model, material=material), theta=theta)


def _needless(flat: FactorRows, best: FactorRows) -> bool:
    """Whether vertical factors of one do as well as those found."""
    # The lines are refined after the search for the factors, each time elsewhere: that can end
    # above where it began.
    if flat.objective <= best.objective:
        return True
    # On straight sweeps many factors follow the noise a little better than one does; that is no
    # reason for them.
    if np.sum(told_by_data(best, best.elements[0].reference)) > 1:
        return False
    count, dof = len(best.elements[-1].free), max(best.fit.dof, 1)
    gain = (flat.fit.cost - best.fit.cost) / (count * best.unit)
    return bool(f_sf(gain, count, dof) >= SUPERPOSITION.alarm)
