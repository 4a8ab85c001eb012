"""Harmonics of the force: whether they are there, and how they grow with the amplitude."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import chi2_sf
from springpot.measurement import Measurement
from springpot.rheology import Complex, Real

from .battery import Finding
from .policy import VERDICT

MEANINGS = {
    -1.0: "as Coulomb friction would",
    0.0: "as a power-law damper would",
    2.0: "as a cubic spring would",
}
"""Power of the amplitude with which the third harmonic's share grows."""


def judged(found: list[Finding]) -> list[Finding]:
    """Findings held against the number of tests made (Bonferroni), the surest first."""
    kept = [replace(one, found=one.p_value * len(found) < VERDICT.harmonic_alarm) for one in found]
    return sorted(kept, key=lambda one: (not one.found, one.p_value))


def overtones(measurement: Measurement, noise: Complex) -> list[Finding]:
    """Tests on even and odd force harmonics; none where they were not measured.

    Parameters
    ----------
    measurement : Measurement
        The data with their `harmonics`, relative to the first.
    noise : ndarray of complex, shape (n,)
        Standard deviations of K' and K''; a sinusoid's fit leaves the same deviation in every harmonic.
    """
    if measurement.harmonics is None:
        return []
    relative = np.sqrt(0.5 * (noise.real**2 + noise.imag**2)) / measurement.magnitude
    return [*_harmonic(measurement, relative, 3, "odd"), *_harmonic(measurement, relative, 2, "even")]


def _harmonic(measurement: Measurement, relative: Real, order: int, word: str) -> Iterator[Finding]:
    assert measurement.harmonics is not None
    if measurement.harmonics.shape[1] < order - 1:
        return
    share = np.abs(measurement.harmonics[:, order - 2])
    rows = np.flatnonzero(np.isfinite(share))
    if len(rows) == 0:
        return
    value = float(np.sum((share[rows] / relative[rows]) ** 2))
    chance = float(chi2_sf(value, 2 * len(rows)))
    typical = float(np.median(share[rows]))
    growth = _growth(measurement, share, rows)
    words = f"{word} nonlinearity: harmonic {order} is {100 * typical:.2g} % of the first{growth}"
    yield Finding(f"harmonic {order}", typical, chance, False, words)


def _growth(measurement: Measurement, share: Real, rows: NDArray[np.int64]) -> str:
    """The power of the amplitude with which the share grows, where amplitudes differ."""
    amplitude = measurement.conditions.get("amplitude")
    if amplitude is None:
        return ""
    x, y = amplitude[rows], share[rows]
    usable = (x > 0) & (y > 0)
    x, y = np.log(x[usable]), np.log(y[usable])
    if len(x) < 3 or np.ptp(x) < np.log(VERDICT.spread):
        return ""
    design = np.column_stack([x - x.mean(), np.ones(len(x))])
    (slope, level), *_ = np.linalg.lstsq(design, y, rcond=None)
    rest = y - design @ np.array([slope, level])
    error = float(np.sqrt(np.sum(rest**2) / max(len(x) - 2, 1) / np.sum(design[:, 0] ** 2)))
    named = min(MEANINGS, key=lambda power: abs(power - slope))
    meaning = ""
    # The powers are one or two apart: a slope known worse than that has no name.
    if error < 0.7 and abs(named - slope) < max(VERDICT.close_power, 2 * error):
        meaning = f", {MEANINGS[named]}"
    return f", growing as amplitude^{slope:.2g} ± {2 * error:.1g}{meaning}"
