"""Whether anything oscillates in a record, or noise was taken for an oscillation."""

from __future__ import annotations

import numpy as np

from springpot.errors import DataError
from springpot.thresholds import SIGNALS

from .fit import Basis, Fit
from .record import Record
from .steady import coarse_frequency


def tried(record: Record, frequency: bool, part: bool) -> float:
    """Of how many candidates the searched frequency and part are the best, as far as noise has any.

    Parameters
    ----------
    record : Record
        The signals.
    frequency, part : bool
        Whether these were searched.
    """
    count = 1.0
    # Noise of n samples has about n / 2 oscillations of its own, and a part may begin at any
    # sample.
    if frequency:
        count *= max(0.5 * len(record.time), 1.0)
        if part:
            count *= len(record.time)
    return count


def highest_of_noise(freedom: float, candidates: float) -> float:
    """Quantile of F(2, `freedom`) that the best of so many noise candidates exceeds in 0.1 %.

    Its tail is a power, chance = (1 + 2 F / nu)^(-nu / 2). Solved for F, for the complement of a
    chance of 1e-17 is rounded to one: six million samples have so many candidates.

    Examples
    --------
    >>> from springpot.measurement.motion import highest_of_noise
    >>> round(highest_of_noise(20.0, 1.0), 2), round(highest_of_noise(1e7, 5e13), 1)
    (9.95, 38.5)
    """
    chance = (1.0 - SIGNALS.motion) / candidates
    return 0.5 * freedom * float(np.expm1(-2.0 / freedom * np.log(chance)))


def require_motion(record: Record, basis: Basis, fit: Fit, candidates: float) -> None:
    """Refuse a frequency at which the displacement is no more than its noise there (F test, 0.1 %).

    Parameters
    ----------
    record : Record
        The signals.
    basis : Basis
        What was fitted.
    fit : Fit
        What it gave.
    candidates : float
        Of how many candidates this one is the best; 1 where the frequency was given.

    Raises
    ------
    DataError
        If the displacement does not oscillate.
    """
    # Variance of cosine and sine together: noise alone makes an amplitude of this size.
    noise = float(fit.noise[0]) * float(np.trace(fit.inverse))
    if abs(fit.amplitude[0, 0]) ** 2 > highest_of_noise(fit.freedom, candidates) * noise:
        return
    if candidates > 1.0:
        raise DataError(
            f"{record.name}: nothing oscillates in this record, the displacement scatters about its"
            " level; where it does, say when and how fast: --window START STOP --frequency HZ"
            " (window, omega in Python)"
        )
    moving = coarse_frequency(record)
    raise DataError(
        f"{record.name}: the displacement does not oscillate at {basis.omega:.4g} rad/s "
        f"({basis.omega / (2 * np.pi):.4g} Hz); give the frequency at which it does, "
        f"{moving:.4g} rad/s ({moving / (2 * np.pi):.4g} Hz), or none"
    )
