"""Where a branch has its relaxation: at single rates (poles at s = -r), or spread over all of them (a cut).

Both are found from the reciprocal J = 1/K, an analytic function of u = ln r on the upper edge of the negative axis: a
line of K is a zero of J on that edge, a peak of its continuous spectrum a zero of J a little beyond it.
"""

from __future__ import annotations

import warnings
from typing import NamedTuple

import numpy as np

from .branches import Branch
from .elements import HALF_PI
from .nodes import FULL, GRADIENT
from .points import Complex, Real
from .roots import inside, settled

STEP = 0.05
"""Step in ln r of the search: two lines nearer than 5 % count as one, which the error estimate then shows."""
DISCRETE = 1e-8
"""Share of K that the loss must reach on the negative axis to be a spectrum and not rounding."""
NARROW = 1.2
"""Peaks wider than this in ln r do not disturb the trapezoidal rule, whose kernel has the width pi/2."""
ROUNDED = 1e-13
"""Step in ln r of Newton's method after which the next one is rounding."""
SAME = 1e-9
"""Step after which a search has ended, and distance in ln r within which two peaks are one."""
MOST_SAMPLES, MOST_POLES = 250, 30
"""Of the rational approximation: it takes some 20 ms."""
AROUND = 0.3
"""Radius of the circle about a pole, over the way to the next one, and at most in ln r."""
CIRCLE = np.exp(2j * np.pi * np.arange(16) / 16)
"""Points of Cauchy's integral for the derivatives at a pole: error 0.3^16, a third of the way to the next one."""


class Lines(NamedTuple):
    """Single relaxation rates with their weights, and the derivatives of both.

    Attributes
    ----------
    rates, weights : ndarray, shape (l,)
        In K = sum of weight s / (s + rate).
    rate_slopes, weight_slopes : ndarray, shape (l, p)
        Their derivatives by theta.
    """

    rates: Real
    weights: Real
    rate_slopes: Real
    weight_slopes: Real


class Edge(NamedTuple):
    """A branch read along the upper edge of the negative axis.

    Attributes
    ----------
    u : ndarray, shape (g,)
        Logarithm of the rate.
    value, slope : ndarray, shape (g,)
        K and dK/du.
    """

    u: Real
    value: Complex
    slope: Complex

    @property
    def discrete(self) -> bool:
        """Whether all relaxation is at single rates."""
        # Between its lines a discrete spectrum has no loss on the axis; a continuous one has it everywhere.
        return bool(np.all(np.abs(self.value.imag) <= DISCRETE * np.abs(self.value)))


def edge_of(branch: Branch, low: float, high: float) -> Edge:
    """The branch on a fine grid of ln r from `low` to `high`."""
    # The offset keeps the grid away from round numbers, at which rates often are.
    u = np.arange(low + 0.37 * STEP, high, STEP)
    response = branch.respond(u + HALF_PI, FULL)
    return Edge(u, response.value, response.by_log_omega)


def lines_of(branch: Branch, edge: Edge) -> Lines:
    """The lines of a branch whose relaxation is at single rates, each to rounding.

    Near one, K = w / (u - u0): the weight is one over dJ/du.
    """
    # At a line K is infinite; its inverse is zero there and changes its sign, which can be held.
    inverse = 1.0 / edge.value.real
    rising = np.flatnonzero((inverse[:-1] < 0.0) & (inverse[1:] >= 0.0))
    falling = np.flatnonzero((edge.value.real[:-1] > 0.0) & (edge.value.real[1:] <= 0.0))
    # From one line to the next K falls from plus to minus infinity, through a zero.
    u = _root(branch, edge.u[rising], -1)
    zeros = _root(branch, edge.u[falling], 1)
    if not len(u):
        empty = np.zeros((0, branch.chain.shape[1]))
        return Lines(u, u, empty, empty)
    # The circle must stay clear of the next zero of K, where its inverse is infinite.
    gap = np.min(np.abs(u[:, None] - np.append(zeros, np.inf)[None, :]), axis=1)
    radius = np.minimum(AROUND * gap, AROUND)[:, None]
    # Derivatives by Cauchy's integral: at the pole itself K cannot be evaluated.
    around = branch.respond((u[:, None] + radius * CIRCLE).ravel() + HALF_PI, GRADIENT)
    value = 1.0 / around.value.reshape(len(u), -1)
    by_theta = -around.by_theta.reshape(-1, *value.shape) * value**2
    first = _taylor(value, radius, 1)
    shift = -_taylor(by_theta, radius, 0) / first
    bend = _taylor(by_theta, radius, 1) + 2.0 * _taylor(value, radius, 2) * shift
    rates = np.exp(u)
    return Lines(rates, 1.0 / first, (rates * shift).T, (-bend / first**2).T)


def _taylor(values: Complex, radius: Real, order: int) -> Real:
    """Taylor coefficient of a function that is real on the axis, from its values on a circle (..., 16)."""
    coefficient: Real = (values * CIRCLE**-order / radius**order).mean(axis=-1).real
    return coefficient


def _root(branch: Branch, low: Real, power: int) -> Real:
    """Zeros in ln r of K (power 1) or 1/K (power -1), one in each step from `low`: Newton, held by bisection."""
    if not len(low):
        return low
    high = low + STEP
    u = 0.5 * (low + high)
    for _ in range(60):
        response = branch.respond(u + HALF_PI, FULL)
        value = response.value.real
        if power != 1:
            value = 1.0 / value
        # Beyond a zero K is negative; beyond a pole of K its inverse is positive.
        positive = value < 0.0
        if power == -1:
            positive = value > 0.0
        low, high = np.where(positive, low, u), np.where(positive, u, high)
        slope = power * response.by_log_omega.real / response.value.real
        moved = inside(u - 1.0 / slope, low, high)
        if settled(moved, u, 1e-15):
            return moved
        u = moved
    return u


def peaks_of(branch: Branch, edge: Edge) -> Complex:
    """Narrow peaks of a continuous spectrum: u + i d of a pole at ln r = u with half width d.

    Newton's step towards a zero of J = 1/K is K / K'; its length tells how far it still is.
    """
    step = edge.value / edge.slope
    far = np.abs(step)
    nearest = (far[1:-1] <= far[:-2]) & (far[1:-1] <= far[2:]) & (far[1:-1] < 2.0 * NARROW)
    u = edge.u[1:-1][nearest] + step[1:-1][nearest]
    change = np.zeros_like(u)
    if not len(u):
        return u
    for _ in range(12):
        response = branch.respond(u + HALF_PI, FULL)
        # At the pole itself, to the last digit, K is infinite: there is nothing left to change.
        change = np.nan_to_num(response.value / response.by_log_omega, nan=0.0, posinf=0.0, neginf=0.0)
        # By no more than half a factor e at a time, lest it run on to another peak.
        u = u + change / np.maximum(2.0 * np.abs(change), 1.0)
        if np.all(np.abs(change) < ROUNDED):
            break
    ended = (np.abs(change) < SAME) & (u.imag > 0.0) & (u.imag < NARROW)
    within = ended & (u.real > edge.u[0]) & (u.real < edge.u[-1])
    # Neighbouring starts end at one peak, and it must count once.
    return np.unique(np.round(u[within], 9))


def all_peaks_of(branch: Branch, edge: Edge) -> Complex:
    """The same, the ones hidden beside a larger part of K or of another shape included; a hundred times as slow.

    d ln K / du has a pole of strength one at each of them (and at the zeros of K), however weak it is in K; the
    rational approximation of it tells where (Nakatsukasa, Sete & Trefethen 2018, 10.1137/16M1106122).
    """
    from scipy.interpolate import AAA

    some = slice(None, None, max(1, len(edge.u) // MOST_SAMPLES))
    power = (edge.slope / edge.value)[some]
    fine = np.isfinite(power)
    if not np.any(fine):
        # K is nothing along the whole edge, as of an element whose constant has become zero: it has no poles.
        return np.zeros(0, dtype=np.complex128)
    with warnings.catch_warnings():
        # It complains where K has more poles than it may have terms: those that it does find serve all the same.
        warnings.simplefilter("ignore")
        u = AAA(edge.u[some][fine], power[fine], rtol=1e-7, max_terms=MOST_POLES).poles()
    within = (u.imag > SAME) & (u.imag < NARROW) & (u.real > edge.u[0]) & (u.real < edge.u[-1])
    # One pole may be found twice, apart by rounding.
    return np.unique(np.round(u[within], 9))
