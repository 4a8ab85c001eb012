"""Whether storage and loss stand in each other's place.

Physics knows, since the two are not independent.

Of a linear passive material K = K_e + i omega c + integral of H(r) i omega / (i omega + r) d ln r
with H >= 0 (the Kramers-Kronig relations and positive work in one), so that a course of storage has
its own course of loss. Columns that no such material could have, but one could if they were
exchanged, were named the wrong way round.
"""

from __future__ import annotations

import numpy as np

from springpot.numerics import non_negative
from springpot.rheology.points import Complex, Real

from .measurement import Measurement
from .mixed_tests import sweeps_of

NOTE = "note exchange"
"""Key of the note in a measurement's provenance."""
FEWEST_POINTS = 5
"""With fewer points nearly any pair of curves is that of some material."""
LEAST_RANGE = 5.0
"""Ratio of highest and lowest frequency.

Over less, both curves are straight lines and tell little of each other.
"""
MOST_DECADES = 20.0
"""Of frequencies and of |K|.

No instrument and no master curve has more, and a spectrum over hundreds of decades
would take seconds at each opening."""
MOST_ROWS = 10_000
"""Larger tables are written by programs, which mix up no columns, and finding their sweeps would
take time.
"""
MOST_POINTS = 60
"""Points that are looked at, evenly chosen.

A question asked at each opening must take a millisecond.
"""
MODES_PER_DECADE = 3
"""Relaxation rates of the spectrum.

A decade has no room for more that differ by more than a per cent in K.
"""
BEYOND = 100.0
"""How far below and above the measured frequencies the spectrum reaches.

Its tails enter by (omega / r)^2.
"""
FAR = 0.1
"""Relative rms from which no material is near.

Measured sweeps that were named rightly lie at 0.001 to 0.2, exchanged
at 0.3 to 0.8, those of a springpot of order 1/2, whose two parts are alike, at 0.1."""
NEAR = 0.2
"""Share of that misfit which the exchanged columns may have left.

A mass or a delay takes a sweep far from every
material too, but exchanging its columns brings it no nearer (0.8 to 3 times of the misfit in all
data at hand).
"""


def exchange_note(measurement: Measurement) -> dict[str, str]:
    """A note where storage and loss look exchanged; empty otherwise.

    Parameters
    ----------
    measurement : Measurement
        The data; the sweep with the most points is looked at.
    """
    if len(measurement) > MOST_ROWS:
        return {}
    sweep = max(sweeps_of(measurement), key=lambda each: len(each.rows))
    picks = np.linspace(0, len(sweep.rows) - 1, MOST_POINTS).round().astype(int)
    rows = sweep.rows[np.unique(picks)]
    omega, stiffness = measurement.omega[rows], measurement.stiffness[rows]
    if len(np.unique(omega)) < FEWEST_POINTS or omega.max() < LEAST_RANGE * omega.min():
        return {}
    if max(decades(omega), decades(np.abs(stiffness))) > MOST_DECADES:
        return {}
    # Of what is left neither is near the end of what a number can be.
    omega, stiffness = omega / omega.max(), stiffness / np.abs(stiffness).max()
    # By an absolute bound first: sound data, which nearly all are, need no second fit.
    as_named = material_misfit(omega, stiffness)
    if as_named < FAR:
        return {}
    exchanged = material_misfit(omega, stiffness.imag + 1j * stiffness.real)
    if exchanged > NEAR * as_named:
        return {}
    return {
        NOTE: (
            f"no material has such storage and loss ({100 * as_named:.0f} % off), but one has them"
            f" the other way round ({100 * exchanged:.1f} %): if the columns are exchanged, open"
            " 'FILE?storage=loss,loss=storage'"
        )
    }


def decades(positive: Real) -> float:
    """Powers of ten between the least and the largest of some positive numbers."""
    return float(np.log10(positive.max()) - np.log10(positive.min()))


def material_misfit(omega: Real, stiffness: Complex) -> float:
    """Relative rms distance of a sweep from the nearest linear passive material.

    Parameters
    ----------
    omega : ndarray, shape (n,)
        Angular frequency in rad/s.
    stiffness : ndarray of complex, shape (n,)
        Complex stiffness or modulus; none zero.

    Returns
    -------
    float
        Root mean square of |K - K_material| / |K|.

    Examples
    --------
    >>> import numpy as np
    >>> omega = np.logspace(-1, 1, 9)
    >>> maxwell = 1j * omega / (1 + 1j * omega)
    >>> bool(material_misfit(omega, maxwell) < 0.01)
    True
    >>> bool(material_misfit(omega, maxwell.conj()) > 0.3)
    True
    """
    low, high = np.log10([omega.min() / BEYOND, omega.max() * BEYOND])
    rates = np.logspace(low, high, int(MODES_PER_DECADE * (high - low)) + 1)
    modes = 1j * omega[:, None] / (1j * omega[:, None] + rates)
    # Beside the spectrum a spring and a dashpot, its limits at infinitely low and high rates.
    basis = np.column_stack([np.ones_like(omega), 1j * omega / omega.max(), modes])
    # Relative at each point: a sweep over decades would else be judged at its stiff end alone.
    weighted = basis / np.abs(stiffness)[:, None]
    target = stiffness / np.abs(stiffness)
    _, left = non_negative(
        np.vstack([weighted.real, weighted.imag]), np.concatenate([target.real, target.imag])
    )
    return float(np.sqrt(left / len(omega)))
