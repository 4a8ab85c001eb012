"""Where a branch of a network has its relaxation: at single rates, or spread over all of them.

Single rates are poles at s = -r, spread ones a cut. Both are found from the reciprocal J = 1/K, an
analytic function of u = ln r on the upper edge of the negative axis: a line of K is a zero of J on
that edge, a peak of its continuous spectrum a zero of J a little beyond it.

Every network is analytic in ln s, so that a branch evaluates at a complex `log_omega`: s = i
exp(log_omega). With ``log_omega = ln r + i pi/2`` it is read at s = -r, on the upper edge of the
cut on which its relaxation lives. A cut is integrated by the trapezoidal rule in ln r: where its
nodes lie, and which of its modes a band of frequencies needs.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..numerics import ALIKE, MOST_STEPS, ROUNDING
from .elements import FixedPower, KnownMass
from .nodes import (
    FULL,
    GRADIENT,
    VALUE,
    Chain,
    Composition,
    Mapped,
    Node,
    Parallel,
    Renamed,
    Response,
    Scaled,
    Series,
    Shift,
)
from .points import HALF_PI, Complex, Points, Real
from .rational import Lines, inside, settled

Anywhere: TypeAlias = NDArray[np.inexact[Any]]
"""Real or complex logarithms of a frequency."""


@dataclass(frozen=True)
class Branch:
    """One of the branches whose stiffnesses (or compliances) add up to the whole network's.

    Parameters
    ----------
    node : Node
        Its network.
    theta : ndarray, shape (b,)
        Its own parameters.
    chain : ndarray, shape (b, p)
        Their derivative by the parameters of the whole.
    conditions : Points
        Temperature and reference temperature; its frequencies are not used.
    compliance : bool
        Read 1/K as a function of p = 1/s, which has the form of a stiffness: then "log_omega" means
        that of p.
    """

    node: Node
    theta: Real
    chain: Real
    conditions: Points
    compliance: bool = False

    def respond(self, log_omega: Anywhere, depth: int = VALUE) -> Response:
        """The branch (n,), its derivative (p, n) by the whole's parameters and its slope (n,)."""
        where = log_omega
        if self.compliance:
            # s = 1/p, so that i exp(where) = 1 / (i exp(log_omega)).
            where = -log_omega - 1j * np.pi
        at = replace(self.conditions, log_omega=where)  # type: ignore[arg-type]
        response = self.node.respond(self.theta, at, depth)
        by_theta = response.by_theta
        if depth >= GRADIENT:
            by_theta = self.chain.T @ by_theta
        if not self.compliance:
            return Response(response.value, by_theta, response.by_log_omega)
        value = 1.0 / response.value
        if depth == VALUE:
            return Response(value)
        # d(1/K) = -dK / K^2, and ln p falls where ln s grows.
        square = value**2
        if depth < FULL:
            return Response(value, -square * by_theta)
        return Response(value, -square * by_theta, square * response.by_log_omega)

    @property
    def is_mass(self) -> bool:
        """Whether it is nothing but a mass."""
        element = _innermost(self.node)
        return isinstance(element, KnownMass) or (
            isinstance(element, FixedPower) and element.exponent == 2.0
        )

    @property
    def is_layer(self) -> bool:
        """Whether it is a fluid layer set in motion (Basset), between a dashpot and a mass."""
        element = _innermost(self.node)
        return isinstance(element, FixedPower) and 1.0 < element.exponent < 2.0

    def mass(self) -> tuple[float, Real]:
        """The constant of a mass and its derivative (p,), read at s = i."""
        # There s^2 = -1: minus the stiffness is the mass itself.
        response = self.respond(np.zeros(1), GRADIENT)
        return -float(response.value[0].real), -response.by_theta[:, 0].real


def _innermost(node: Node) -> Node:
    while isinstance(node, Renamed | Scaled | Shift | Chain):
        if isinstance(node, Composition):
            node = node.children[0]
        else:
            node = node.node
    return node


def branches(
    network: Node, theta: Real, conditions: Points, *, compliance: bool = False
) -> list[Branch]:
    """The branches of a network side by side, or, for the compliance, one after the other.

    Parameters
    ----------
    network : Node
        Of the whole model.
    theta : ndarray, shape (p,)
        Its parameters.
    conditions : Points
        Temperature and reference temperature.
    compliance : bool
        Take it apart in series instead, and let each branch give its compliance.
    """
    kind: type[Composition] = Parallel
    if compliance:
        kind = Series
    # Branch by branch: each may be a line, a mass or spread, and is then treated for what it is.
    parts = _split(network, theta, np.eye(len(theta)), kind)
    return [Branch(node, own, chain, conditions, compliance) for node, own, chain in parts]


def _split(
    node: Node, theta: Real, chain: Real, kind: type[Composition]
) -> Iterator[tuple[Node, Real, Real]]:
    if isinstance(node, Renamed):
        yield from _split(node.node, theta, chain, kind)
    elif isinstance(node, Scaled):
        for inner, own, link in _split(node.node, theta, chain, kind):
            yield Scaled(inner, node.factor), own, link
    elif isinstance(node, Mapped):
        yield from _split(node.node, node.forward(theta), node.jacobian(theta) @ chain, kind)
    elif isinstance(node, kind):
        for child, cut in zip(node.children, node.cuts, strict=True):
            yield from _split(child, theta[cut], chain[cut], kind)
    elif isinstance(node, Shift | Chain):
        # A shift, or a factor, of the whole is one of every branch.
        first, second = node.cuts
        for inner, own, link in _split(node.children[0], theta[first], chain[first], kind):
            together = np.concatenate([own, theta[second]]), np.concatenate([link, chain[second]])
            yield type(node)((inner, node.children[1])), *together
    else:
        yield node, theta, chain


STEP = 0.05
"""Step in ln r of the search.

Two lines nearer than 5 % count as one, unless more of them follow ever nearer.
"""
FINEST_STEP = STEP / 64
"""Of a row of lines without end, such as that of diffusion, the first six hundred are told apart.
"""
CROWDED = 4.0
"""Steps from one line to the next below which the next but one may be missed."""
FAR = 8.0
"""Distance in ln r beyond the band from which lines are a dashpot to it.

They are 3000 times as fast.
"""
NARROW = 1.2
"""Wider peaks in ln r do not disturb the trapezoidal rule, whose kernel has the width pi/2."""
MOST_SAMPLES, MOST_POLES = 250, 30
"""Of the rational approximation: it takes some 20 ms."""
AROUND = 0.3
"""Radius of the circle about a pole, over the way to the next one, and at most in ln r."""
CIRCLE = np.exp(2j * np.pi * np.arange(16) / 16)
"""Points of Cauchy's integral for the derivatives at a pole.

Error 0.3^16, a third of the way to the next one.
"""


class Edge(NamedTuple):
    """A branch read along the upper edge of the negative axis.

    Attributes
    ----------
    u : ndarray, shape (g,)
        Logarithm of the rate.
    value, slope : ndarray, shape (g,)
        K and dK/du.
    step : float
        Of the grid.
    """

    u: Real
    value: Complex
    slope: Complex
    step: float

    @property
    def discrete(self) -> bool:
        """Whether all relaxation is at single rates."""
        # Between its lines a discrete spectrum has no loss on the axis; a continuous one has it
        # everywhere.
        return bool(np.all(np.abs(self.value.imag) <= ALIKE * np.abs(self.value)))

    @property
    def lines(self) -> NDArray[np.intp]:
        """Numbers of the steps in which there is a line: everywhere else K falls as r grows."""
        rise = np.diff(self.value.real)
        # Where K is all but zero, it also rises by rounding.
        return np.flatnonzero(rise > ALIKE * np.median(np.abs(self.value)))

    @property
    def clear(self) -> int:
        """How many lines from the slowest lie so far apart that none between them was missed."""
        crowded = np.flatnonzero(np.diff(self.u[self.lines]) < CROWDED * self.step)
        if not len(crowded):
            return len(self.lines)
        return int(crowded[0]) + 1


def edge_of(branch: Branch, low: float, high: float, step: float = STEP) -> Edge:
    """The branch on a fine grid of ln r from `low` to `high`."""
    # The offset keeps the grid away from round numbers, at which rates often are.
    u = np.arange(low + 0.37 * step, high, step)
    response = branch.respond(u + HALF_PI, FULL)
    return Edge(u, response.value, response.by_log_omega, step)


def resolved(branch: Branch, edge: Edge, high: float) -> Edge:
    """The edge on a grid that tells its lines apart.

    Up to where they are too fast for a band that ends at `high`.

    Lines of diffusion are at 1, 9, 25, ... times the slowest: in ln r ever nearer to each other,
    without end.
    """
    while edge.clear < len(edge.lines):
        fastest = edge.u[edge.lines[edge.clear - 1]]
        if fastest > high + FAR or edge.step <= FINEST_STEP:
            kept = edge.lines[edge.clear - 1] + 2
            return Edge(edge.u[:kept], edge.value[:kept], edge.slope[:kept], edge.step)
        edge = edge_of(branch, edge.u[0], edge.u[-1], edge.step / 4.0)
    return edge


def lines_of(branch: Branch, edge: Edge) -> Lines:
    """The lines of a branch whose relaxation is at single rates, each to rounding.

    Near one, K = w / (u - u0) + ..., and w and u0 move with theta: coefficients of its Laurent
    series, by Cauchy's integral around the line, at which itself K cannot be evaluated.
    """
    u = _poles(branch, edge)
    if not len(u):
        return Lines.none(branch.chain.shape[1])
    # To the next line on either side; a single one has none.
    gap = np.diff(u, prepend=-np.inf, append=np.inf)
    circle = AROUND * np.minimum(np.minimum(gap[:-1], gap[1:]), 1.0)[:, None] * CIRCLE
    around = branch.respond((u[:, None] + circle).ravel() + HALF_PI, GRADIENT)
    by_theta = around.by_theta.reshape(-1, *circle.shape)
    weights = _mean_of(around.value.reshape(circle.shape) * circle)
    weight_slopes = _mean_of(by_theta * circle)
    # d/dtheta of w / (u - u0) has u0' w / (u - u0)^2 beside w' / (u - u0).
    shift = _mean_of(by_theta * circle**2) / weights
    rates = np.exp(u)
    return Lines(rates, weights, (rates * shift).T, weight_slopes.T)


def _mean_of(values: Complex) -> Real:
    """Mean over the circle, shape (...,), of a function that is real on the axis."""
    mean: Real = values.mean(axis=-1).real
    return mean


def _poles(branch: Branch, edge: Edge) -> Real:
    """Places ln r at which K is infinite, one in each step in which it rises.

    Newton's method, held by bisection.
    """
    steps = edge.lines
    if not len(steps):
        return np.zeros(0)
    low: Real = edge.u[steps]
    high: Real = edge.u[steps + 1]
    # Between the values at the ends of the step, so that K has this one nowhere within it: K less
    # the level then changes its sign at the line alone, and its inverse is zero there.
    level = 0.5 * (edge.value.real[steps] + edge.value.real[steps + 1])
    u = 0.5 * (low + high)
    last = np.inf
    for _ in range(MOST_STEPS):
        response = branch.respond(u + HALF_PI, FULL)
        value = response.value.real - level
        beyond = value > 0.0
        low, high = np.where(beyond, low, u), np.where(beyond, u, high)
        # Of Newton's method for 1 / (K - level), whose slope is -K' / (K - level)^2.
        step: Real = value / response.by_log_omega.real
        moved = inside(u + step, u, low, high)
        left = float(np.abs(moved - u).max())
        # Of thousands of lines one is always moved on by what K is rounded by: steps that no longer
        # shrink are at their end.
        if settled(moved, u) or last <= left < ALIKE:
            return moved
        u, last = moved, left
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
        change = np.nan_to_num(
            response.value / response.by_log_omega, nan=0.0, posinf=0.0, neginf=0.0
        )
        # By no more than half a factor e at a time, lest it run on to another peak.
        u = u + change / np.maximum(2.0 * np.abs(change), 1.0)
        if np.all(np.abs(change) < ROUNDING):
            break
    ended = (np.abs(change) < ALIKE) & (u.imag > 0.0) & (u.imag < NARROW)
    within = ended & (u.real > edge.u[0]) & (u.real < edge.u[-1])
    # Neighbouring starts end at one peak, and it must count once.
    return np.unique(np.round(u[within], 9))


def all_peaks_of(branch: Branch, edge: Edge) -> Complex:
    """The same, the ones hidden beside a larger part of K or of another shape included.

    A hundred times as slow.

    d ln K / du has a pole of strength one at each of them (and at the zeros of K), however weak it
    is in K; the rational approximation of it tells where (Nakatsukasa, Sete & Trefethen 2018,
    10.1137/16M1106122).
    """
    from scipy.interpolate import AAA

    some = slice(None, None, max(1, len(edge.u) // MOST_SAMPLES))
    power = (edge.slope / edge.value)[some]
    fine = np.isfinite(power)
    if not np.any(fine):
        # K is nothing along the whole edge, as of an element whose constant has become zero: it has
        # no poles.
        return np.zeros(0, dtype=np.complex128)
    with warnings.catch_warnings():
        # It complains where K has more poles than it may have terms: those that it does find serve
        # all the same.
        warnings.simplefilter("ignore")
        u = AAA(edge.u[some][fine], power[fine], rtol=1e-7, max_terms=MOST_POLES).poles()
    within = (u.imag > ALIKE) & (u.imag < NARROW) & (u.real > edge.u[0]) & (u.real < edge.u[-1])
    # One pole may be found twice, apart by rounding.
    return np.unique(np.round(u[within], 9))


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
    widths = np.maximum(peaks.imag, ROUNDING)
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
