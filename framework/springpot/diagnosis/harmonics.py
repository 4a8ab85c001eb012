"""What the measured third harmonic of the force says for or against an explanation.

Dry friction and a hysteretic loss are one curve K(omega) at one amplitude, but friction makes a third of its force
again at three times the frequency and a linear loss makes none.
"""

from __future__ import annotations

import numpy as np

from springpot.rheology import Real

from .refit import Refit

TOLERANCE = 0.3
"""Share by which a predicted harmonic may be off: describing functions hold the displacement to be a sinusoid, which
no rig makes it."""
LEAST = 0.002
"""Share of the first harmonic below which a third one is held to be the rig's."""
MOST_ROWS = 10.0
"""Rows that count at most: what is wrong with a prediction is wrong in all of them."""
UNPREDICTED = -3.0
"""Log-likelihood where an effect makes harmonics of which neither a formula nor a bound is known."""


def harmonic_evidence(refit: Refit) -> float:
    """Log-likelihood of the measured third harmonic, at most 0; 0 where none was measured.

    Parameters
    ----------
    refit : Refit
        A model, fitted.
    """
    data = refit.data.mean
    if data.harmonics is None or data.harmonics.shape[1] < 2:
        return 0.0
    measured = data.harmonics[:, 1]
    rows = np.flatnonzero(np.isfinite(measured))
    if len(rows) == 0:
        return 0.0
    predicted, radius = refit.model.third_harmonic_range(refit.theta, data.points)
    if not np.all(np.isfinite(radius)):
        return UNPREDICTED
    sd: Real = (np.hypot(refit.noise.sd.real, refit.noise.sd.imag) / data.magnitude)[rows] + LEAST
    off = np.maximum(np.abs(measured[rows] - predicted[rows]) - radius[rows], 0.0)
    size = np.maximum(np.abs(measured[rows]), np.abs(predicted[rows]))
    missed = off**2 / (sd**2 + (TOLERANCE * size) ** 2)
    return -0.5 * float(np.mean(missed)) * min(float(len(rows)), MOST_ROWS)
