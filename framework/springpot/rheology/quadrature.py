"""The trapezoidal rule in ln r.

Where its nodes lie, and which of its modes a band of frequencies needs.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .points import Complex, Real
from .poles import Lines

NARROWEST = 1e-12
"""Half width of a peak in ln r at least.

That of a line by itself is none, by which nothing can be divided.
"""
CUT_OFF = 0.1
"""Share of the tolerance that may be cut off at each end.

It is not seen beside the error of the step.
"""


def nodes_of(low: float, high: float, step: float, peaks: Complex) -> tuple[Real, Real]:
    """Nodes u of the trapezoidal rule from `low` to `high`, closer together at narrow peaks.

    With their share of it.

    With x = u + sum of a arcsinh((u - u_p) / d_p), a peak of half width d_p is as wide in x as the
    kernel, pi/2.
    """
    # The rule converges as its integrand is wide: what is narrow is stretched until it is as wide
    # as the kernel.
    widths = np.maximum(peaks.imag, NARROWEST)
    # A peak as wide as the kernel needs no stretching; the narrower, the more.
    strengths = np.clip(1.0 - 2.0 * widths / np.pi, 0.0, 1.0)

    def stretched(u: Real) -> tuple[Real, Real]:
        away = (u[:, None] - peaks.real) / widths
        x = u + np.arcsinh(away) @ strengths
        return x, 1.0 + (1.0 / np.sqrt(1.0 + away**2)) @ (strengths / widths)

    # Newton below needs starts near the nodes: they are read backwards off a table of x.
    table = [np.arange(low - step, high + step, 0.25 * step)]
    # Evenly in arcsinh, as the narrowest peak must be seen by the table too.
    table += [
        p.real + d * np.sinh(np.arange(-30.0, 30.0, 0.1))
        for p, d in zip(peaks, widths, strict=True)
    ]
    coarse = np.unique(np.concatenate(table))
    coarse = coarse[(coarse >= low - step) & (coarse <= high + step)]
    x_coarse, _ = stretched(coarse)
    first, last = stretched(np.array([low, high]))[0]
    x = step * np.arange(np.ceil(first / step), last / step)
    u = np.interp(x, x_coarse, coarse)
    # Without a peak x is u itself, and there is nothing to refine.
    if not len(peaks):
        return u, np.full(len(u), step)
    # Newton from the table: each step squares the error that interpolation has left.
    for _ in range(4):
        here, slope = stretched(u)
        u = u - (here - x) / slope
    return u, step / stretched(u)[1]


def needed_on(
    modes: Lines,
    sizes: tuple[float, float],
    band: tuple[float, float],
    tolerance: float,
    order: int,
) -> NDArray[np.bool_]:
    """Modes that the band sees as more than a spring or, to that order, a dashpot.

    Slower ones would be a spring, faster ones a dashpot.
    """
    low, high = np.exp(band)
    rates, weights = modes.rates, np.abs(modes.weights)
    # What a mode adds to K at the end of the band beyond that spring or dashpot, by the next term
    # of its series.
    slow = weights * rates / low * (rates < low)
    fast = weights * (high / rates) ** order * (rates > high)
    # Summed from the outside: many that are nothing each may be something together.
    lost_slow = (np.cumsum(slow) < CUT_OFF * tolerance * sizes[0]) & (rates < low)
    lost_fast = (np.cumsum(fast[::-1])[::-1] < CUT_OFF * tolerance * sizes[1]) & (rates > high)
    needed: NDArray[np.bool_] = ~(lost_slow | lost_fast)
    return needed
