"""What is known of vertical factors before the data speak, and those that depart least from it.

Where sweeps are straight (a power law) a factor of the stiffness and a shift of the frequency are
one, and the data leave both open along a ridge. Of all factors on it those are taken that physics
expects: a stiffness that goes with a power of temperature, and sweeps that repeat to some per cent.
Tikhonov's regularisation with a width that has a meaning, which is Bayes' theorem with a normal
prior of ln b; data that contradict it have their way.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.linalg import block_diag

from springpot.distributions import f_sf
from springpot.identification.alignment import aligned
from springpot.identification.native import Fit, fit
from springpot.rheology.effect import Effect, Layer
from springpot.rheology.levels import Levels
from springpot.rheology.model import Model
from springpot.rheology.nodes import chain
from springpot.rheology.points import Real
from springpot.thresholds import SUPERPOSITION

from .factors import Expected, Rows, told_by_data

POWER = 1.0
"""Standard deviation of n in b = (T / Tr)^n.

1 for an ideal rubber (Flory), below 0 for a glass, whose modulus falls
by tenths of a per cent for each kelvin."""
REPEATED = 0.03
"""Standard deviation of ln b of one sweep by itself.

The gap and the grip of a specimen give and slip by some per
cent when the temperature changes."""
ELSEWHERE = float(np.log(2.0))
"""Standard deviation of ln b along other columns: only its order of magnitude is known."""


def expectation(rows: Rows) -> Real:
    """Rows (r, q) that whiten the logarithms of all free factors by what is expected of them.

    Zero where nothing is.

    Every level, that of reference too, has an error of its own, so that no level is trusted before
    the others.
    """
    blocks = np.zeros((0, 0))
    for element in rows.elements:
        own = np.zeros((0, len(element.parameters)))
        if not element.logarithmic:
            own = whitening(element)
        blocks = block_diag(blocks, own)
    return np.asarray(blocks, dtype=np.float64)


def whitening(element: Levels) -> Real:
    """Rows (q, q) that whiten logarithms of free vertical factors by what is expected of them."""
    return np.asarray(np.linalg.inv(np.linalg.cholesky(_covariance(element))), dtype=np.float64)


def _covariance(element: Levels) -> Real:
    """Of the logarithms of the free vertical factors, one at the reference."""
    free = list(element.free)
    size, along = ELSEWHERE, np.zeros(len(free))
    if element.column == "temperature":
        size = REPEATED
        kelvin = np.array(element.values)
        along = POWER * np.log(kelvin[free] / kelvin[element.reference])
    shared = np.ones((len(free), len(free)))
    return np.asarray(
        np.outer(along, along) + size**2 * (np.eye(len(free)) + shared), dtype=np.float64
    )


def spread_between(element: Levels) -> Real:
    """Expected standard deviation (m, m) of ln b from each level to each other."""
    size, along = ELSEWHERE, np.zeros(len(element.values))
    if element.column == "temperature":
        size, along = REPEATED, POWER * np.log(np.array(element.values))
    return np.asarray(
        np.sqrt(np.subtract.outer(along, along) ** 2 + 2.0 * size**2), dtype=np.float64
    )


def lifted(alone: Fit, column: str) -> Rows:
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
    unfitted = replace(Rows.of(alone).material, rates=())
    model = (replace(alone.model, material=unfitted) + upwards).bound_to(data.points)
    own = alone.theta[len(alone.model.material.parameters) :]
    unlifted = np.concatenate([own, np.ones(len(own))])
    read_off = np.array(list(aligned(model, data).values()))
    # Two ways in, because few sweeps that hardly overlap can have two optima.
    free = fit(model, data, alone.objective, seeds_theta=[unlifted, read_off])
    # What the freest factors leave is the scatter that departures from the expected are weighed
    # against.
    rows = Rows.of(free)
    expected = Expected(expectation(rows), rows.unit)
    seeds = [unlifted, read_off, free.theta]
    best = Rows.of(
        fit(model, data, alone.objective, seeds_theta=seeds, expected=expected.weighted), expected
    )
    flat = Rows.of(_with_factors_of_one(alone, model), expected)
    if _needless(flat, best):
        return flat
    return best


def _with_factors_of_one(alone: Fit, model: Model) -> Fit:
    """A fit with shifts alone as one of the model with vertical factors too."""
    material = alone.model.material
    shifts = alone.theta[len(material.parameters) :]
    theta = np.concatenate([alone.theta, np.ones(len(shifts))])
    return replace(alone, model=replace(model, material=material), theta=theta)


def _needless(flat: Rows, best: Rows) -> bool:
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
