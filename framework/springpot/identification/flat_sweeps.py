"""Flat sweeps, such as those of a rubbery plateau: no shift of one is better than another."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import student
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL, SUPERPOSITION

from ..numerics import ALIKE, DECADE

if TYPE_CHECKING:
    from .free_factors import FactorRows

FEWEST = 3
"""Points of a sweep that a slope and its scatter take up."""


def flat_levels(rows: FactorRows) -> NDArray[np.bool_]:
    """Levels (m,) whose storage and loss neither rise nor fall with frequency beyond scatter."""
    data = rows.fit.measurement
    flat = np.zeros(len(rows.elements[0].values), dtype=np.bool_)
    for level in range(len(flat)):
        here = rows.number == level
        x = np.log(data.omega[here])
        if len(x) <= FEWEST or np.ptp(x) == 0.0:
            continue
        shares = data.stiffness[here] / np.median(data.magnitude[here])
        flat[level] = all(_is_level(x, part) for part in (shares.real, shares.imag))
    return flat


def _is_level(x: Real, values: Real) -> bool:
    """Whether values (n,) do not follow x (n,) beyond their scatter, and cannot do so by much."""
    away = x - x.mean()
    slope = abs(float(away @ values / (away @ away)))
    left = values - values.mean() - away * (away @ values / (away @ away))
    freedom = len(x) - 2
    sd = float(np.sqrt(left @ left / freedom / (away @ away)))
    # Few points or a short sweep show no slope either, and leave room for a large one.
    room = slope + student(INTERVAL, freedom) * sd
    return (
        slope <= student(SUPERPOSITION.seen, freedom) * sd + ALIKE
        and DECADE * room < SUPERPOSITION.flat
    )
