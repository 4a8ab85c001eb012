"""Lines in what a fit leaves of a record: one frequency, as of the mains or of a fan.

White noise has none; the largest of m ordinates of its periodogram is known (Fisher 1929,
doi:10.1098/rspa.1929.0151), and here each is held against those around it, as noise may have a
memory and a misfit is slow.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from springpot.misfit.mains_hum import HARMONICS, MAINS
from springpot.misfit.words import plain
from springpot.rheology.points import Real

from ..numerics import SMALLEST
from .residuals_of_tests import InTimePart, TestPart
from .scatter import UPPER
from .where import rms

TAPER = 0.1
"""Share of the record at both ends that is faded, so that a slow misfit does not leak."""
EVEN = 0.01
"""Relative spread of the steps of time below which samples are evenly spaced."""
FEWEST = 200
"""Samples of a record in which a line is sought."""
AROUND = 20
"""Ordinates on either side with which one is compared."""
RARE = 1e-6
"""Chance of noise alone below which the largest ordinate is a line."""
WIDE = 3
"""Ordinates on either side over which a line that falls between two of them is spread."""


def is_even(time: Real) -> bool:
    """Whether times (n,) are evenly spaced."""
    steps = np.diff(time)
    return bool(np.ptp(steps) < EVEN * float(np.mean(steps)))


def lines_in(part: TestPart, residual: Real) -> Iterator[str]:
    """The strongest line in a residual (m,) over the noise, in words; nothing where there is none.

    Sought where a misfit of a model does not reach, and at the frequencies of the mains.
    """
    if not isinstance(part, InTimePart) or len(part.at) < FEWEST or not is_even(part.at):
        return
    missed = residual * part.sd
    power, omega = periodogram(missed)
    hertz = omega / (2.0 * np.pi * float(np.mean(np.diff(part.at))))
    around = np.lib.stride_tricks.sliding_window_view(
        np.pad(power, AROUND, mode="reflect"), 2 * AROUND + 1
    )
    # Of an exponential the median is ln 2 times the mean, and a line does not move it.
    ratio = power / np.maximum(np.median(around, axis=1) / np.log(2.0), SMALLEST)
    # As near as the record tells frequencies apart.
    mains = np.outer(MAINS, HARMONICS).ravel()
    of_mains = np.min(np.abs(hertz[:, None] - mains), axis=1) <= 1.5 * hertz[0]
    sought = np.where((omega > UPPER * np.pi) | of_mains, ratio, 0.0)
    top = int(np.argmax(sought))
    # The largest of m: each might have been it.
    if len(power) * np.exp(-sought[top]) > RARE:
        return
    share = power[max(0, top - WIDE) : top + WIDE + 1].sum() / power.sum()
    size = np.sqrt(2.0 * share) * rms(missed - missed.mean())
    whose = "a vibration, or the hum of a device"
    if of_mains[top]:
        whose = "the hum of the mains"
    yield (
        f"what is left of {part.test.name} holds a line at {plain(float(hertz[top]), 3)} Hz,"
        f" {plain(float(size), 2)} {part.unit} in amplitude: {whose}, no part of the specimen"
    )


def periodogram(residual: Real) -> tuple[Real, Real]:
    """Power of a residual (n,) at each of its frequencies, in radians a sample; its mean left out.

    Of white noise the power is its variance at each of them.
    """
    n = len(residual)
    fade = max(1, int(TAPER * n))
    window = np.ones(n)
    window[:fade] = 0.5 - 0.5 * np.cos(np.pi * (np.arange(fade) + 0.5) / fade)
    window[-fade:] = window[:fade][::-1]
    turned = np.fft.rfft((residual - residual.mean()) * window)
    power = np.abs(turned) ** 2 / np.sum(window**2)
    return power[1:], 2.0 * np.pi * np.arange(1, len(power)) / n
