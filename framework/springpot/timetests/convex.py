"""A test as a sum of exponentials with weights >= 0, a convex problem with one solution.

After a step of displacement, and under any history of it, the force is linear in the weights of
relaxation; under a force the displacement is linear in those of retardation, J_g + t/eta + sum of
L_j (1 - exp(-t/tau_j)). Either tells the other: the poles of K are the zeros of 1/K, one between
each two of its own poles (N. W. Tschoegl, 1989, doi:10.1007/978-3-642-73602-5).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from springpot.identification.material import CLOSER
from springpot.numerics import (
    DECADE,
    ENOUGH,
    HALVINGS,
    PER_DECADE,
    evenly,
    non_negative,
    projected_out,
)
from springpot.rheology.points import Real, real_form

from .residuals_of_tests import InTimePart, TestPart
from .start import answers_of

SLOWER, FASTER = 1.0, 0.5
"""Decades beyond the times of the tests.

What relaxes more slowly is a spring there, and of what is gone before the
first sample, but for a few per cent, any amount could have been."""
SPACINGS = (CLOSER, CLOSER * CLOSER)
"""Spacings, over that of the first lattice, at which lines are looked for about those that carry.
"""
APART = 0.2
"""Least distance of lines in ln tau.

The exact response tells those apart that differ by more than a twentieth.
"""
SHARES = (1.0, 0.3, 0.1, 0.03)
"""Of a step that are tried until one leaves less."""
SETTLING = 5
"""Steps by which lines come to rest where they leave least."""
MOVED = 1e-4
"""Distance in ln tau by which a line is moved for its slope."""


class ConvexSpectrum(NamedTuple):
    """K = K_e + c s + sum of weight s / (s + rate), none of them negative."""

    equilibrium: float
    viscosity: float
    rates: Real
    weights: Real

    def among(self, others: Real) -> tuple[Real, Real]:
        """Rates (m,) of these lines and of others apart from them, and all weights (2 + m,)."""
        far = [rate for rate in others if np.all(np.abs(np.log(self.rates / rate)) > APART)]
        rates = np.concatenate([self.rates, far])
        weights = np.concatenate([self.weights, np.zeros(len(far))])
        order = np.argsort(rates)
        return rates[order], np.concatenate([[self.equilibrium, self.viscosity], weights[order]])

    def beside(self, others: Sequence[ConvexSpectrum]) -> ConvexSpectrum:
        """The same with lines of no weight where others have theirs."""
        found = self
        for other in others:
            rates, weights = found.among(other.rates)
            found = found._replace(rates=rates, weights=weights[2:])
        return found


@lru_cache(maxsize=256)
def lines_of(part: TestPart) -> ConvexSpectrum:
    """The material that a test shows when nothing but a material has made it."""
    low, high = part.test.seen
    step = DECADE / PER_DECADE
    ends = -np.log(high * 10.0**FASTER), -np.log(low * 10.0**-SLOWER)
    logs = np.arange(ends[0], ends[1] + step, step)
    amounts = _amounts(part, logs)
    for share in SPACINGS:
        carrying = logs[amounts[2:] > 0.0]
        near = carrying[:, None] + share * step * np.arange(-4.0, 5.0)
        logs = np.unique(np.round(near.ravel() / (share * step))) * share * step
        logs = logs[(logs > ends[0] - share * step) & (logs < ends[1] + share * step)]
        amounts = _amounts(part, logs)
    logs = _apart(logs[amounts[2:] > 0.0], amounts[2:][amounts[2:] > 0.0])
    logs, amounts = _settled(part, logs, ends)
    kept = amounts[2:] > 0.0
    times, weights = np.exp(logs[kept]), amounts[2:][kept]
    if isinstance(part, InTimePart) and part.test.control == "force":
        return relaxation_of(float(amounts[0]), float(amounts[1]), times, weights)
    return ConvexSpectrum(float(amounts[0]), float(amounts[1]), 1.0 / times, weights)


def relaxation_of(glass: float, fluidity: float, times: Real, weights: Real) -> ConvexSpectrum:
    """The relaxation of a retardation J = glass + fluidity t + sum of weight (1 - exp(-t / time)).

    Parameters
    ----------
    glass, fluidity : float
        J_g in 1/Pa, and 1/eta in 1/(Pa s).
    times, weights : ndarray, shape (m,)
        Of retardation, in s and 1/Pa.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.timetests.convex import relaxation_of
    >>> found = relaxation_of(0.5, 0.0, np.array([2.0]), np.array([0.5]))
    >>> found.equilibrium, found.viscosity, found.rates.round(6), found.weights.round(6)
    (1.0, 0.0, array([1.]), array([1.]))
    """
    poles = np.sort(1.0 / times)
    amounts = (weights / times)[np.argsort(1.0 / times)]
    # A flow is a retardation without end.
    if fluidity > 0.0:
        poles, amounts = np.append(0.0, poles), np.append(fluidity, amounts)
    equilibrium = viscosity = 0.0
    if not fluidity > 0.0:
        equilibrium = 1.0 / (glass + float(weights.sum()))
    if not glass > 0.0 and len(poles):
        viscosity = 1.0 / float(amounts.sum())
    # J at s = -r rises from one of its poles to the next, and beyond the last towards J_g.
    low = poles[: len(poles) - (not glass > 0.0)]
    high = poles[1:]
    if glass > 0.0 and len(poles):
        high = np.append(high, poles[-1] + amounts.sum() / glass)
    for _ in range(HALVINGS):
        middle = np.where(low > 0.0, np.sqrt(low * high), 0.5 * high)
        below = glass - np.sum(amounts / (middle[:, None] - poles), axis=1) < 0.0
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    rates = np.where(low > 0.0, np.sqrt(low * high), high)
    slopes = np.sum(amounts / (rates[:, None] - poles) ** 2, axis=1)
    return ConvexSpectrum(equilibrium, viscosity, rates, 1.0 / (rates * slopes))


def _settled(part: TestPart, logs: Real, ends: tuple[float, float]) -> tuple[Real, Real]:
    """Lines at places of their own, and their amounts: two that became one stand a little off."""
    amounts, left = _nearest(part, logs)
    for _ in range(SETTLING):
        kept = amounts[2:] > 0.0
        logs = logs[kept]
        amounts = np.concatenate([amounts[:2], amounts[2:][kept]])
        # Variable projection: the slopes by the places, less what the amounts could do instead.
        columns, target = _columns(part, logs)
        ahead, behind = (_columns(part, logs + by)[0][:, 2:] for by in (MOVED, -MOVED))
        slopes = (ahead - behind) / (2.0 * MOVED) * amounts[2:]
        basis = np.linalg.qr(columns)[0]
        move = np.linalg.lstsq(
            projected_out(slopes, basis), target - columns @ amounts, rcond=1e-8
        )[0]
        for share in SHARES:
            moved = np.clip(logs + share * move, *ends)
            if np.all(np.diff(moved) >= APART):
                others, less = _nearest(part, moved)
                if less < left:
                    break
        else:
            break
        logs, amounts, left = moved, others, less
    return logs, amounts


def _amounts(part: TestPart, logs: Real) -> Real:
    """Amounts (2 + m,) of spring, dashpot and exponentials of these times nearest to a test."""
    return _nearest(part, logs)[0]


def _nearest(part: TestPart, logs: Real) -> tuple[Real, float]:
    return non_negative(*_columns(part, logs))


def _columns(part: TestPart, logs: Real) -> tuple[Real, Real]:
    """What each amount does to a test (n, 2 + m), and the test (n,), in standard deviations."""
    if not isinstance(part, InTimePart):
        return _columns_of_sweep(part, logs)
    test = part.test
    rows = evenly(len(test), ENOUGH)
    rows = rows[~np.isin(test.time[rows], test.loading.jumps[0])]
    answers = answers_of(test.loading, test.control, np.exp(logs), test.time[rows])
    # Without the mass, which is no part of such a sum.
    columns = np.delete(answers, 2, axis=1) / part.sd[rows, None]
    return columns, test.response[rows] / part.sd[rows]


def _columns_of_sweep(part: TestPart, logs: Real) -> tuple[Real, Real]:
    s = 1j * np.split(part.rate, 2)[0][:, None]
    turned = s * np.exp(logs)
    shown = np.hstack([np.ones_like(s), s, turned / (1.0 + turned)])
    columns = real_form(shown) / part.sd[:, None]
    return columns, part.measured / part.sd


def _apart(logs: Real, amounts: Real) -> Real:
    """Places of lines, those that stand too near to one another as one in their middle."""
    placed: list[float] = []
    held: list[float] = []
    for log, amount in zip(logs, amounts, strict=True):
        if placed and log - placed[-1] < APART:
            placed[-1] = (held[-1] * placed[-1] + amount * log) / (held[-1] + amount)
            held[-1] += amount
        else:
            placed.append(float(log))
            held.append(float(amount))
    return np.array(placed)


def lattice(bands: Sequence[tuple[float, float]], per_decade: int) -> Real:
    """Rates (m,) in 1/s of the lines that tests of these bands tell of, so many a decade."""
    low, high = min(each[0] for each in bands), max(each[1] for each in bands)
    decades = np.log10(high / low) + SLOWER + FASTER
    return np.geomspace(low * 10.0**-SLOWER, high * 10.0**FASTER, int(per_decade * decades) + 2)
